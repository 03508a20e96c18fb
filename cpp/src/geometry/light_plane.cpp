#include "geometry/light_plane.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace penumbra {

namespace {

/// An area below this share of the squared size counts as none: float64 could not tell its plane.
constexpr double kFlat = 1e-14;
constexpr double kGuard = 1.75;  // within BoundaryIntervals::kLimit
constexpr int kEllipseCorners = 256;

bool spans_area(const glm::dvec3& u, const glm::dvec3& v) {
    const double u2 = glm::dot(u, u);
    const double v2 = glm::dot(v, v);
    return glm::length(glm::cross(u, v)) > kFlat * std::max(u2, v2);
}

std::optional<LightPlane> polygon_plane(const Light& light, const glm::dvec3& anchor_ws) {
    const std::vector<glm::dvec3>& corners = light.corners_ws;
    // The three corners that span the largest triangle make the best frame.
    std::array<std::size_t, 3> best{};
    double largest = 0.0;
    for (std::size_t i = 0; i < corners.size(); ++i) {
        for (std::size_t j = i + 1; j < corners.size(); ++j) {
            for (std::size_t k = j + 1; k < corners.size(); ++k) {
                const double area = glm::length(glm::cross(corners[j] - corners[i], corners[k] - corners[i]));
                if (area > largest) {
                    largest = area;
                    best = {i, j, k};
                }
            }
        }
    }
    const glm::dvec3 origin = largest > 0.0 ? corners[best[0]] : glm::dvec3{0.0};
    const glm::dvec3 u = largest > 0.0 ? corners[best[1]] - origin : glm::dvec3{0.0};
    const glm::dvec3 v = largest > 0.0 ? corners[best[2]] - origin : glm::dvec3{0.0};
    if (!spans_area(u, v)) {
        return std::nullopt;
    }
    const glm::dvec3 normal = glm::cross(u, v);
    const glm::dvec3 along_u = glm::cross(v, normal) / glm::dot(normal, normal);
    const glm::dvec3 along_v = glm::cross(normal, u) / glm::dot(normal, normal);
    LightPlane plane;
    glm::dvec2 low{0.0};
    glm::dvec2 high{0.0};
    for (std::size_t i = 0; i < corners.size(); ++i) {
        glm::dvec2 corner{glm::dot(along_u, corners[i] - origin), glm::dot(along_v, corners[i] - origin)};
        if (i == best[0]) {
            corner = glm::dvec2{0.0};
        } else if (i == best[1]) {
            corner = glm::dvec2{1.0, 0.0};
        } else if (i == best[2]) {
            corner = glm::dvec2{0.0, 1.0};
        }
        low = glm::min(low, corner);
        high = glm::max(high, corner);
        plane.corners.push_back(corner);
    }
    const glm::dvec2 middle = 0.5 * (low + high);
    const glm::dvec2 half = 0.5 * (high - low);
    for (glm::dvec2& corner : plane.corners) {
        corner = glm::clamp((corner - middle) / half, glm::dvec2{-1.0}, glm::dvec2{1.0});
    }
    plane.origin_m = (origin - anchor_ws) + middle.x * u + middle.y * v;
    plane.u_m = half.x * u;
    plane.v_m = half.y * v;
    return plane;
}

/// Room for a triangle that six planes clip.
using Corners = std::array<glm::dvec3, 12>;

/// Clips the convex polygon of the first `count` corners, in homogeneous coordinates, to dot(plane, point) >= 0.
/// @return the new number of corners, at most one more than before
std::size_t clip(Corners& corners, std::size_t count, const glm::dvec3& plane, double offset) {
    Corners result;
    std::size_t kept = 0;
    for (std::size_t i = 0; i < count; ++i) {
        const glm::dvec3& from = corners[i];
        const glm::dvec3& to = corners[(i + 1) % count];
        const double at_from = glm::dot(plane, from) + offset;
        const double at_to = glm::dot(plane, to) + offset;
        if (at_from >= 0.0) {
            result[kept++] = from;
        }
        if ((at_from >= 0.0) != (at_to >= 0.0)) {
            // Always from the kept side, so that both triangles of an edge find the same point.
            result[kept++] = at_from >= 0.0 ? from + (to - from) * (at_from / (at_from - at_to))
                                            : to + (from - to) * (at_to / (at_to - at_from));
        }
    }
    std::copy_n(result.begin(), kept, corners.begin());
    return kept;
}

}  // namespace

std::optional<LightPlane> light_plane(const Light& light, const glm::dvec3& anchor_ws) {
    if (light.kind == LightKind::Polygon) {
        return polygon_plane(light, anchor_ws);
    }
    if (light.kind != LightKind::Rectangle || !spans_area(light.half_u_ws, light.half_v_ws)) {
        return std::nullopt;
    }
    return LightPlane{light.position_ws - anchor_ws,
                      light.half_u_ws,
                      light.half_v_ws,
                      {{-1.0, -1.0}, {1.0, -1.0}, {1.0, 1.0}, {-1.0, 1.0}}};
}

std::optional<LightPlane> ellipse_as_polygon(const Light& light, const glm::dvec3& anchor_ws) {
    if (light.kind != LightKind::Ellipse || !spans_area(light.half_u_ws, light.half_v_ws)) {
        return std::nullopt;
    }
    constexpr double kStep = 2.0 * std::numbers::pi / kEllipseCorners;
    // The polygon reaches past the ellipse at its corners by this factor; the frame grows with it.
    const double reach = std::sqrt(kStep / std::sin(kStep));
    LightPlane plane{light.position_ws - anchor_ws, reach * light.half_u_ws, reach * light.half_v_ws, {}};
    for (int i = 0; i < kEllipseCorners; ++i) {
        plane.corners.emplace_back(std::cos(i * kStep), std::sin(i * kStep));
    }
    return plane;
}

CentralProjection::CentralProjection(const LightPlane& plane, const glm::dvec3& receiver_m)
    : centre_{plane.origin_m - receiver_m}, depth_{0.0}, along_u_{0.0}, along_v_{0.0} {
    const glm::dvec3 normal = glm::cross(plane.u_m, plane.v_m);
    const double normal2 = glm::dot(normal, normal);
    const double height = glm::dot(normal, centre_);
    const double size = glm::length(centre_) + glm::length(plane.u_m) + glm::length(plane.v_m);
    if (!(std::abs(height) > 1e-12 * std::sqrt(normal2) * size)) {
        return;
    }
    valid_ = true;
    orientation_ = height > 0.0 ? 1.0 : -1.0;
    depth_ = normal / height;
    along_u_ = glm::cross(plane.v_m, normal) / normal2;
    along_v_ = glm::cross(normal, plane.u_m) / normal2;
}

glm::dvec3 CentralProjection::to_homogeneous(const glm::dvec3& offset) const noexcept {
    const double w = glm::dot(depth_, offset);
    const glm::dvec3 in_plane = offset - w * centre_;
    return glm::dvec3{glm::dot(along_u_, in_plane), glm::dot(along_v_, in_plane), w};
}

std::size_t CentralProjection::project(const glm::dvec3& a, const glm::dvec3& b, const glm::dvec3& c,
                                       std::array<PlaneTriangle, kMostParts>& out) const {
    Corners corners{to_homogeneous(a), to_homogeneous(b), to_homogeneous(c)};
    const glm::dvec3 low = glm::min(corners[0], glm::min(corners[1], corners[2]));
    const glm::dvec3 high = glm::max(corners[0], glm::max(corners[1], corners[2]));
    if (!(high.z > kSlab) || !(low.z < 1.0 - kSlab)) {
        return 0;
    }
    // Wholly beyond one side of the square: x > w, x < -w, and the same for y.
    const auto all_beyond = [&corners](const glm::dvec3& plane) {
        return glm::dot(plane, corners[0]) > 0.0 && glm::dot(plane, corners[1]) > 0.0 &&
               glm::dot(plane, corners[2]) > 0.0;
    };
    if (all_beyond({1.0, 0.0, -1.0}) || all_beyond({-1.0, 0.0, -1.0}) || all_beyond({0.0, 1.0, -1.0}) ||
        all_beyond({0.0, -1.0, -1.0})) {
        return 0;
    }
    std::size_t count = 3;
    if (low.z < kSlab) {
        count = clip(corners, count, {0.0, 0.0, 1.0}, -kSlab);
    }
    if (high.z > 1.0 - kSlab) {
        count = clip(corners, count, {0.0, 0.0, -1.0}, 1.0 - kSlab);
    }
    bool within = true;
    for (std::size_t i = 0; i < count; ++i) {
        const double reach = std::max(std::abs(corners[i].x), std::abs(corners[i].y));
        within = within && reach <= kGuard * corners[i].z;
    }
    if (!within) {
        count = clip(corners, count, {1.0, 0.0, kGuard}, 0.0);
        count = clip(corners, count, {-1.0, 0.0, kGuard}, 0.0);
        count = clip(corners, count, {0.0, 1.0, kGuard}, 0.0);
        count = clip(corners, count, {0.0, -1.0, kGuard}, 0.0);
    }
    if (count < 3) {
        return 0;
    }
    std::array<glm::dvec2, 12> flat{};
    for (std::size_t i = 0; i < count; ++i) {
        flat[i] =
            glm::clamp(glm::dvec2{corners[i].x, corners[i].y} / corners[i].z, glm::dvec2{-kGuard}, glm::dvec2{kGuard});
    }
    for (std::size_t i = 2; i < count; ++i) {
        out[i - 2].corner = {flat[0], flat[i - 1], flat[i]};
    }
    return count - 2;
}

}  // namespace penumbra
