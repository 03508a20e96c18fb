#include "penumbra/light.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <numbers>
#include <utility>

#include "scene/light_names.h"
#include "scene/message.h"
#include "scene/normalise.h"

namespace penumbra {

namespace {

using message::is_finite;
using message::refuse;

constexpr double kPi = std::numbers::pi;
/// Angles from degrees may overshoot a half turn by a rounding error.
constexpr double kAngleSlack_rad = 1e-6;
/// Corners may leave their plane by this share of the polygon's size: float32 input has about 1e-7.
constexpr double kFlatness = 1e-6;
/// Below this share of (size)^2 an area is zero: a sliver whose width is lost in the rounding of its corners.
constexpr double kZeroArea = 1e-14;
constexpr std::size_t kMinCorners = 3;
constexpr std::size_t kMaxCorners = 8;

double largest(const glm::dvec3& v) noexcept {
    return std::max({std::abs(v.x), std::abs(v.y), std::abs(v.z)});
}

/// Unit vector along v, whatever its length; v must not be zero.
glm::dvec3 unit(const glm::dvec3& v) noexcept {
    return glm::normalize(v / largest(v));
}

glm::dvec3 any_perpendicular(const glm::dvec3& direction) noexcept {
    const glm::dvec3 axis = std::abs(direction.x) < 0.6 ? glm::dvec3{1.0, 0.0, 0.0} : glm::dvec3{0.0, 1.0, 0.0};
    return unit(glm::cross(direction, axis));
}

/// What of v is perpendicular to the unit vector, as unit vector; zero if v has no such part.
glm::dvec3 perpendicular_part(const glm::dvec3& v, const glm::dvec3& to_unit) noexcept {
    if (largest(v) == 0.0) {
        return glm::dvec3{0.0};
    }
    const glm::dvec3 scaled = unit(v);
    const glm::dvec3 rest = scaled - to_unit * glm::dot(scaled, to_unit);
    return glm::length(rest) < 1e-9 ? glm::dvec3{0.0} : unit(rest);
}

void check_point(const Light& light, const char* member, const glm::dvec3& value) {
    if (!is_finite(value) || largest(value) > message::kLargest_m) {
        refuse("light \"", light.name, "\": ", member, " is ", value, "; give finite metres of at most ",
               message::kLargest_m);
    }
}

void check_range(const Light& light, const char* member, double value, double low, double high, const char* unit_name) {
    if (!(value >= low && value <= high)) {
        refuse("light \"", light.name, "\": ", member, " is ", value, "; give a value from ", low, " to ", high,
               unit_name);
    }
}

void check_numbers(const Light& light) {
    check_point(light, "position", light.position_ws);
    check_point(light, "half axis u", light.half_u_ws);
    check_point(light, "half axis v", light.half_v_ws);
    if (!is_finite(light.direction_ws)) {
        refuse("light \"", light.name, "\": direction is ", light.direction_ws, "; give a finite vector");
    }
    if (!is_finite(light.power_w)) {
        refuse("light \"", light.name, "\": power is ", light.power_w, "; give finite watts");
    }
    check_range(light, "radius", light.radius_m, 0.0, message::kLargest_m, " m");
    check_range(light, "sun angle", light.sun_angle_rad, 0.0, kPi + kAngleSlack_rad, " rad");
    check_range(light, "spot angle", light.spot_angle_rad, 0.0, kPi + kAngleSlack_rad, " rad");
    check_range(light, "spot blend", light.spot_blend, 0.0, 1.0, "");
    for (const double stretch : {light.spot_stretch.x, light.spot_stretch.y}) {
        if (!(stretch > 0.0 && std::isfinite(stretch))) {
            refuse("light \"", light.name, "\": spot stretch is ", light.spot_stretch,
                   "; give two finite factors above 0");
        }
    }
    for (std::size_t i = 0; i < light.corners_ws.size(); ++i) {
        check_point(light, ("corner " + std::to_string(i)).c_str(), light.corners_ws[i]);
    }
}

/// The unit normal of an area light on the side that direction_ws points to.
glm::dvec3 normal_towards(const Light& light, const glm::dvec3& normal) {
    const double cosine = glm::dot(normal, unit(light.direction_ws));
    if (std::abs(cosine) < 1e-6) {
        refuse("light \"", light.name, "\": direction ", light.direction_ws,
               " lies in the plane of the light, whose normal is ", normal, "; turn it to the side that shines");
    }
    return cosine > 0.0 ? normal : -normal;
}

/// Direction of an area light without area: perpendicular to its remaining axis (zero: it is a point).
glm::dvec3 direction_beside(const Light& light, const glm::dvec3& axis) {
    const glm::dvec3 direction = unit(light.direction_ws);
    if (largest(axis) == 0.0) {
        return direction;
    }
    const glm::dvec3 beside = perpendicular_part(direction, unit(axis));
    if (largest(beside) == 0.0) {
        refuse("light \"", light.name, "\": direction ", light.direction_ws,
               " runs along the light, which has no width; turn it to the side that shines");
    }
    return beside;
}

void normalise_parallelogram(Light& light) {
    const glm::dvec3& u = light.half_u_ws;
    const glm::dvec3& v = light.half_v_ws;
    const double u_size = largest(u);
    const double v_size = largest(v);
    if (u_size == 0.0 || v_size == 0.0) {
        light.direction_ws = direction_beside(light, u_size > 0.0 ? u : v);
        return;
    }
    const glm::dvec3 normal = glm::cross(u / u_size, v / v_size);
    if (glm::length(normal) < kZeroArea) {
        light.direction_ws = direction_beside(light, u_size > v_size ? u : v);
        return;
    }
    light.direction_ws = normal_towards(light, unit(normal));
}

/// Twice the area times the unit normal of a polygon given relative to its mean. Source: Newell's method.
glm::dvec3 area_vector(const std::vector<glm::dvec3>& corners) {
    glm::dvec3 sum{0.0};
    for (std::size_t i = 0; i < corners.size(); ++i) {
        sum += glm::cross(corners[i], corners[(i + 1) % corners.size()]);
    }
    return sum;
}

glm::dvec3 mean(const std::vector<glm::dvec3>& corners) {
    glm::dvec3 sum{0.0};
    for (const glm::dvec3& corner : corners) {
        sum += corner;
    }
    return sum / static_cast<double>(corners.size());
}

void drop_repeated_corners(std::vector<glm::dvec3>& corners) {
    // Not std::ranges::unique: Clang 14, which the fuzzer is built with, cannot compile libstdc++ 12's subrange.
    corners.erase(std::unique(corners.begin(), corners.end()), corners.end());  // NOLINT(modernize-use-ranges)
    while (corners.size() > 1 && corners.front() == corners.back()) {
        corners.pop_back();
    }
}

void check_corner_count(const Light& light) {
    if (light.corners_ws.size() < kMinCorners || light.corners_ws.size() > kMaxCorners) {
        refuse("light \"", light.name, "\": polygon has ", light.corners_ws.size(), " corners; give ", kMinCorners,
               " to ", kMaxCorners);
    }
}

/// @param local corners divided by the polygon's size, relative to their mean
void check_flat(const Light& light, const std::vector<glm::dvec3>& local, const glm::dvec3& normal) {
    for (std::size_t i = 0; i < local.size(); ++i) {
        const double distance = glm::dot(local[i], normal);
        if (std::abs(distance) > kFlatness) {
            refuse("light \"", light.name, "\": corner ", i, " at ", light.corners_ws[i],
                   " leaves the polygon's plane by ", std::abs(distance), " of its size (limit ", kFlatness,
                   "); flatten it or split it into triangles");
        }
    }
}

/// Every turn goes the same way, and all of them make one full turn (a star turns twice).
void check_convex(const Light& light, const std::vector<glm::dvec3>& local, const glm::dvec3& normal) {
    const std::size_t n = local.size();
    double turned_rad = 0.0;
    for (std::size_t i = 0; i < n; ++i) {
        const glm::dvec3 before = unit(local[i] - local[(i + n - 1) % n]);
        const glm::dvec3 after = unit(local[(i + 1) % n] - local[i]);
        const double sine = glm::dot(glm::cross(before, after), normal);
        if (sine < -kFlatness) {
            refuse("light \"", light.name, "\": polygon is not convex at corner ", i, " at ", light.corners_ws[i],
                   "; split it into convex lights");
        }
        turned_rad += std::atan2(std::max(sine, 0.0), glm::dot(before, after));
    }
    if (turned_rad > 3.0 * kPi) {
        refuse("light \"", light.name, "\": polygon crosses itself (its edges turn by ", turned_rad / kPi * 180.0,
               " degrees, not 360); list the corners around its rim");
    }
}

void normalise_polygon(Light& light) {
    light.half_u_ws = glm::dvec3{0.0};
    light.half_v_ws = glm::dvec3{0.0};
    check_corner_count(light);
    std::vector<glm::dvec3> corners = light.corners_ws;
    drop_repeated_corners(corners);
    light.position_ws = mean(corners);
    if (corners.size() < kMinCorners) {  // a segment or a point, written with repeated corners: kept as it is
        light.direction_ws = direction_beside(light, corners.back() - corners.front());
        return;
    }

    std::vector<glm::dvec3> local;
    double size = 0.0;
    glm::dvec3 farthest{0.0};
    for (const glm::dvec3& corner : corners) {
        local.push_back(corner - light.position_ws);
        if (largest(local.back()) > size) {
            size = largest(local.back());
            farthest = local.back();
        }
    }
    for (glm::dvec3& corner : local) {
        corner /= size;
    }
    const glm::dvec3 vector = area_vector(local);
    if (glm::length(vector) < kZeroArea) {
        // Opposite loops of a bow tie cancel: that is a crossing, not a line.
        for (std::size_t i = 0; i < local.size(); ++i) {
            const glm::dvec3 along = unit(farthest);
            if (glm::length(local[i] - along * glm::dot(local[i], along)) > kFlatness) {
                refuse("light \"", light.name, "\": polygon crosses itself at corner ", i, " at ", corners[i],
                       "; list the corners around its rim");
            }
        }
        light.direction_ws = direction_beside(light, farthest);
        return;
    }
    light.corners_ws = std::move(corners);
    const glm::dvec3 normal = unit(vector);
    check_flat(light, local, normal);
    check_convex(light, local, normal);
    // Counter-clockwise about `normal` is clockwise for an eye on the other side.
    light.direction_ws = normal_towards(light, normal);
    if (glm::dot(light.direction_ws, normal) < 0.0) {
        std::ranges::reverse(light.corners_ws);
    }
}

void normalise_spot(Light& light) {
    light.direction_ws = unit(light.direction_ws);
    glm::dvec3 u = perpendicular_part(light.half_u_ws, light.direction_ws);
    if (largest(u) == 0.0) {
        u = any_perpendicular(light.direction_ws);
    }
    light.half_u_ws = u;
    light.half_v_ws = glm::cross(u, light.direction_ws);  // local y, where the spot shines along local -z
}

}  // namespace

std::string_view to_string(LightKind kind) noexcept {
    switch (kind) {
        case LightKind::Point:
            return "point";
        case LightKind::Spot:
            return "spot";
        case LightKind::Sun:
            return "sun";
        case LightKind::Rectangle:
            return "rectangle";
        case LightKind::Ellipse:
            return "ellipse";
        case LightKind::Line:
            return "line";
        case LightKind::Polygon:
            return "polygon";
    }
    return "unknown";
}

std::optional<LightKind> light_kind_from_string(std::string_view name) noexcept {
    const auto found = std::ranges::find(kLightKinds, name, [](LightKind kind) { return to_string(kind); });
    return found == kLightKinds.end() ? std::nullopt : std::optional{*found};
}

bool is_area(LightKind kind) noexcept {
    return kind == LightKind::Rectangle || kind == LightKind::Ellipse || kind == LightKind::Line ||
           kind == LightKind::Polygon;
}

bool has_no_extent(const Light& light) noexcept {
    switch (light.kind) {
        case LightKind::Point:
        case LightKind::Spot:
            return light.radius_m == 0.0;
        case LightKind::Sun:
            return light.sun_angle_rad == 0.0;
        case LightKind::Rectangle:
        case LightKind::Ellipse:
            return light.half_u_ws == glm::dvec3{0.0} && light.half_v_ws == glm::dvec3{0.0};
        case LightKind::Line:
            return light.half_u_ws == glm::dvec3{0.0};
        case LightKind::Polygon:
            return std::ranges::all_of(light.corners_ws,
                                       [&](const glm::dvec3& corner) { return corner == light.corners_ws.front(); });
    }
    return true;
}

void normalise(Light& light) {
    check_numbers(light);
    light.sun_angle_rad = std::min(light.sun_angle_rad, kPi);
    light.spot_angle_rad = std::min(light.spot_angle_rad, kPi);
    if (light.kind == LightKind::Point || light.kind == LightKind::Line) {  // shine all around
        light.half_v_ws = glm::dvec3{0.0};
        return;
    }
    if (largest(light.direction_ws) == 0.0) {
        refuse("light \"", light.name, "\": direction is (0, 0, 0); give the direction in which it shines");
    }
    switch (light.kind) {
        case LightKind::Spot:
            normalise_spot(light);
            break;
        case LightKind::Rectangle:
        case LightKind::Ellipse:
            normalise_parallelogram(light);
            break;
        case LightKind::Polygon:
            normalise_polygon(light);
            break;
        default:
            light.direction_ws = unit(light.direction_ws);
            break;
    }
}

void validate(const Light& light) {
    Light copy = light;
    normalise(copy);
}

}  // namespace penumbra
