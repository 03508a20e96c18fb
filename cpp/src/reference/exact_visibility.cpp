#include "reference/exact_visibility.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <string>

#include "base/parallel.h"
#include "geometry/contour.h"
#include "scene/message.h"

namespace penumbra {

namespace {

constexpr double kEpsilon = std::numeric_limits<double>::epsilon();
constexpr std::int64_t kGrain = 16;  // points of one piece of work: 1 ms or so, well below the cancel interval

/// True if the plane of the triangle (corners relative to the point) holds the point to within rounding.
bool holds_origin(const std::array<glm::dvec3, 3>& corner, double rounding_m) {
    const glm::dvec3 first = corner[1] - corner[0];
    const glm::dvec3 second = corner[2] - corner[0];
    const glm::dvec3 normal = glm::cross(first, second);
    const double nearest = std::min({glm::length(corner[0]), glm::length(corner[1]), glm::length(corner[2])});
    const double edges = glm::length(first) * glm::length(second);
    return std::abs(glm::dot(normal, corner[0])) <=
           glm::length(normal) * rounding_m + 64.0 * kEpsilon * edges * (nearest + std::sqrt(edges));
}

/// The part of a convex polygon in the frame that lies above the receiver's horizon.
std::vector<glm::dvec2> above_horizon(const std::vector<glm::dvec2>& corners, const LightPlane& plane,
                                      const glm::dvec3& towards_origin, const glm::dvec3& normal) {
    const double constant = glm::dot(normal, towards_origin);
    const glm::dvec2 slope{glm::dot(normal, plane.u_m), glm::dot(normal, plane.v_m)};
    const auto height = [&](const glm::dvec2& p) { return constant + glm::dot(slope, p); };
    std::vector<glm::dvec2> kept;
    for (std::size_t i = 0; i < corners.size(); ++i) {
        const glm::dvec2& from = corners[i];
        const glm::dvec2& to = corners[(i + 1) % corners.size()];
        const double at_from = height(from);
        const double at_to = height(to);
        if (at_from >= 0.0) {
            kept.push_back(from);
        }
        if ((at_from >= 0.0) != (at_to >= 0.0)) {
            kept.push_back(
                glm::clamp(from + (to - from) * (at_from / (at_from - at_to)), glm::dvec2{-1.0}, glm::dvec2{1.0}));
        }
    }
    return kept;
}

}  // namespace

ExactPoint::ExactPoint(const LightPlane& plane, const glm::dvec3& shines_towards, const ShaftBvh& casters)
    : plane_{plane}, shines_towards_{shines_towards}, casters_{casters} {
    for (const glm::dvec2& corner : plane.corners) {
        const glm::dvec3 offset = corner.x * plane.u_m + corner.y * plane.v_m;
        corners_m_.push_back(plane.origin_m + offset);
        radius_m_ = std::max(radius_m_, glm::length(offset));
    }
}

double ExactPoint::ratio(const CentralProjection& projection, const glm::dvec3& normal) const {
    const Contour contour{projection.towards_origin(), normal, radius_m_};
    const auto offset = [this](const glm::dvec2& p) { return p.x * plane_.u_m + p.y * plane_.v_m; };
    const std::vector<glm::dvec2> polygon = boundary_.polygon();
    double unshadowed = 0.0;
    for (std::size_t i = 0; i < polygon.size(); ++i) {
        unshadowed += contour.edge(offset(polygon[i]), offset(polygon[(i + 1) % polygon.size()]));
    }
    double visible = 0.0;
    for (const BoundaryPiece& piece : pieces_) {
        visible += contour.edge(offset(piece.from), offset(piece.to));
    }
    unshadowed *= projection.orientation();
    visible *= projection.orientation();
    return unshadowed > 0.0 ? std::clamp(visible / unshadowed, 0.0, 1.0) : 1.0;
}

ExactPoint::Result ExactPoint::operator()(const glm::dvec3& position_m, const glm::dvec3& normal, double rounding_m) {
    Result result;
    const CentralProjection projection{plane_, position_m};
    if (!projection.valid() || !boundary_.set_polygon(plane_.corners)) {
        return result;
    }
    projected_.clear();
    const auto collect = [&](const CastingTriangle& triangle) {
        const std::array corner{triangle.corner[0] - position_m, triangle.corner[1] - position_m,
                                triangle.corner[2] - position_m};
        std::array<PlaneTriangle, CentralProjection::kMostParts> parts;
        const std::size_t count = projection.project(corner[0], corner[1], corner[2], parts);
        if (count > 0 && !holds_origin(corner, rounding_m)) {
            for (std::size_t i = 0; i < count; ++i) {
                boundary_.add_triangle(parts[i].corner[0], parts[i].corner[1], parts[i].corner[2]);
                projected_.push_back(parts[i]);
            }
        }
        return true;
    };
    casters_.visit_shaft(position_m, corners_m_, collect);
    result.area = boundary_.visible_fraction(&pieces_);

    if (glm::dot(shines_towards_, projection.towards_origin()) >= 0.0) {
        return result;  // behind the light: no irradiance to lose
    }
    if (boundary_.triangle_count() == 0 && result.area > 0.0) {
        return result;
    }
    bool cut = false;
    for (const glm::dvec3& corner : corners_m_) {
        cut = cut || glm::dot(normal, corner - position_m) < 0.0;
    }
    if (cut) {
        if (!boundary_.set_polygon(above_horizon(plane_.corners, plane_, projection.towards_origin(), normal))) {
            return result;  // wholly below the horizon
        }
        for (const PlaneTriangle& triangle : projected_) {
            boundary_.add_triangle(triangle.corner[0], triangle.corner[1], triangle.corner[2]);
        }
        static_cast<void>(boundary_.visible_fraction(&pieces_));
    }
    result.irradiance = ratio(projection, normal);
    return result;
}

namespace {

ExactResult visibility_of(const Scene& scene, const Light& light, const LightPlane& plane, const glm::dvec3& anchor_ws,
                          std::span<const glm::dvec3> positions_ws, std::span<const glm::dvec3> normals_ws,
                          Control& control) {
    if (positions_ws.size() != normals_ws.size()) {
        throw InvalidScene{"exact visibility: " + std::to_string(positions_ws.size()) + " positions but " +
                           std::to_string(normals_ws.size()) + " normals; give one normal per position"};
    }
    Bounds region;
    for (const glm::dvec2& corner : plane.corners) {
        region.add(anchor_ws + plane.origin_m + corner.x * plane.u_m + corner.y * plane.v_m);
    }
    for (std::size_t i = 0; i < positions_ws.size(); ++i) {
        const glm::dvec3& normal = normals_ws[i];
        if (!message::is_finite(positions_ws[i]) || !message::is_finite(normal) ||
            !(std::abs(glm::dot(normal, normal) - 1.0) < 1e-3)) {
            message::refuse("exact visibility: point ", i, " has position ", positions_ws[i], " and normal ", normal,
                            "; give finite positions and unit normals");
        }
        region.add(positions_ws[i]);
    }
    // A hair more than what can matter, so that rounding of the box leaves nothing out.
    const glm::dvec3 margin = 1e-9 * (region.half_size() + glm::abs(region.centre()) + glm::dvec3{region.radius()});
    region.low -= margin;
    region.high += margin;

    ExactResult result;
    result.area.assign(positions_ws.size(), 1.0);
    result.irradiance.assign(positions_ws.size(), 1.0);
    if (!light.casts_shadow || positions_ws.empty()) {
        return result;
    }
    const ShaftBvh casters{scene, anchor_ws, region};
    const auto body = [&](std::int64_t begin, std::int64_t end) {
        ExactPoint exact{plane, light.direction_ws, casters};
        for (std::int64_t i = begin; i < end; ++i) {
            const auto at = static_cast<std::size_t>(i);
            const glm::dvec3 world = glm::abs(positions_ws[at]);
            const double rounding_m = 8.0 * kEpsilon * std::max({world.x, world.y, world.z});
            const ExactPoint::Result point = exact(positions_ws[at] - anchor_ws, normals_ws[at], rounding_m);
            result.area[at] = point.area;
            result.irradiance[at] = point.irradiance;
        }
    };
    parallel_for(static_cast<std::int64_t>(positions_ws.size()), kGrain, body, control);
    return result;
}

}  // namespace

ExactResult exact_visibility(const Scene& scene, const Light& light, std::span<const glm::dvec3> positions_ws,
                             std::span<const glm::dvec3> normals_ws, Control& control) {
    const glm::dvec3 anchor_ws = light.position_ws;
    const std::optional<LightPlane> plane = light_plane(light, anchor_ws);
    if (!plane) {
        throw InvalidScene{
            "light \"" + light.name + "\": exact visibility needs a rectangle or polygon light with " +
            "an area, but this is a " + std::string{to_string(light.kind)} +
            (light.kind == LightKind::Rectangle || light.kind == LightKind::Polygon ? " without area" : "") +
            "; use the ray-traced reference"};
    }
    return visibility_of(scene, light, *plane, anchor_ws, positions_ws, normals_ws, control);
}

ExactResult nearly_exact_visibility(const Scene& scene, const Light& light, std::span<const glm::dvec3> positions_ws,
                                    std::span<const glm::dvec3> normals_ws, Control& control) {
    const glm::dvec3 anchor_ws = light.position_ws;
    const std::optional<LightPlane> plane = ellipse_as_polygon(light, anchor_ws);
    if (!plane) {
        throw InvalidScene{"light \"" + light.name + "\": visibility of an ellipse needs an ellipse light with an " +
                           "area, but this is a " + std::string{to_string(light.kind)} +
                           "; use the ray-traced reference"};
    }
    return visibility_of(scene, light, *plane, anchor_ws, positions_ws, normals_ws, control);
}

}  // namespace penumbra
