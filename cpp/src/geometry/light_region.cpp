#include "geometry/light_region.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

namespace penumbra {

namespace {

constexpr double kWidestHalfAngle = 89.0 * std::numbers::pi / 180.0;

void across(const glm::dvec3& axis, glm::dvec3& u, glm::dvec3& v) {
    const glm::dvec3 helper = std::abs(axis.z) < 0.9 ? glm::dvec3{0, 0, 1} : glm::dvec3{0, 1, 0};
    u = glm::normalize(glm::cross(helper, axis));
    v = glm::cross(axis, u);
}

/// The rectangle around a polygon, along its first edge.
LightRegion around_polygon(const Light& light) {
    LightRegion region;
    region.centre = glm::dvec4{light.position_ws, 1.0};
    if (light.corners_ws.size() < 2) {
        return region;
    }
    const glm::dvec3 along = light.corners_ws[1] - light.corners_ws[0];
    const double length = glm::length(along);
    if (!(length > 0.0)) {
        return region;
    }
    const glm::dvec3 u = along / length;
    const glm::dvec3 v = glm::cross(light.direction_ws, u);
    glm::dvec2 low{std::numeric_limits<double>::infinity()};
    glm::dvec2 high{-std::numeric_limits<double>::infinity()};
    for (const glm::dvec3& corner : light.corners_ws) {
        const glm::dvec3 from_centre = corner - light.position_ws;
        const glm::dvec2 at{glm::dot(from_centre, u), glm::dot(from_centre, v)};
        low = glm::min(low, at);
        high = glm::max(high, at);
    }
    const glm::dvec2 middle = 0.5 * (low + high);
    region.centre = glm::dvec4{light.position_ws + middle.x * u + middle.y * v, 1.0};
    region.half[0] = 0.5 * (high.x - low.x) * u;
    region.half[1] = 0.5 * (high.y - low.y) * v;
    return region;
}

}  // namespace

double LightRegion::reach(const glm::dvec3& axis) const noexcept {
    const glm::dvec3 along{glm::dot(axis, half[0]), glm::dot(axis, half[1]), glm::dot(axis, half[2])};
    return round ? glm::length(along) : std::abs(along.x) + std::abs(along.y) + std::abs(along.z);
}

double LightRegion::radius() const noexcept {
    if (round) {
        return std::max({glm::length(half[0]), glm::length(half[1]), glm::length(half[2])}) *
               (glm::length(half[2]) > 0.0 ? 1.0 : std::numbers::sqrt2);  // half axes of an ellipse may be conjugate
    }
    return glm::length(half[0]) + glm::length(half[1]) + glm::length(half[2]);
}

LightRegion LightRegion::in(const glm::dmat4& to_from_here) const noexcept {
    LightRegion moved = *this;
    moved.centre = to_from_here * centre;
    for (glm::dvec3& axis : moved.half) {
        axis = glm::dmat3{to_from_here} * axis;
    }
    return moved;
}

LightRegion light_region(const Light& light) noexcept {
    LightRegion region;
    region.centre = glm::dvec4{light.position_ws, 1.0};
    switch (light.kind) {
        case LightKind::Point:
        case LightKind::Spot:
            region.half = {glm::dvec3{light.radius_m, 0, 0}, glm::dvec3{0, light.radius_m, 0},
                           glm::dvec3{0, 0, light.radius_m}};
            region.round = true;
            break;
        case LightKind::Sun: {
            region.centre = glm::dvec4{-light.direction_ws, 0.0};
            const double tangent = std::tan(std::min(0.5 * light.sun_angle_rad, kWidestHalfAngle));
            across(light.direction_ws, region.half[0], region.half[1]);
            region.half[0] *= tangent;
            region.half[1] *= tangent;
            region.round = true;
            break;
        }
        case LightKind::Rectangle:
        case LightKind::Ellipse:
            region.half[0] = light.half_u_ws;
            region.half[1] = light.half_v_ws;
            region.round = light.kind == LightKind::Ellipse;
            break;
        case LightKind::Line:
            region.half[0] = light.half_u_ws;
            break;
        case LightKind::Polygon:
            return around_polygon(light);
    }
    return region;
}

}  // namespace penumbra
