#include "geometry/light_shape.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "geometry/irradiance.h"

namespace penumbra {

namespace {

/// Share of the light's squared size below which an area counts as none.
constexpr double kFlat = 1e-14;
/// Sizes below which a light has no extent: so small that its radiance would leave float32.
constexpr double kSmallest_m = 1e-12;
constexpr double kSmallest_rad = 1e-9;

}  // namespace

void principal_axes(glm::dvec3& u, glm::dvec3& v) {
    const double u2 = glm::dot(u, u);
    const double v2 = glm::dot(v, v);
    const double uv = glm::dot(u, v);
    if (uv != 0.0) {
        const double turn = 0.5 * std::atan2(2.0 * uv, u2 - v2);
        const glm::dvec3 turned = std::cos(turn) * u + std::sin(turn) * v;
        v = std::cos(turn) * v - std::sin(turn) * u;
        u = turned;
    } else if (u2 < v2) {
        const glm::dvec3 turned = v;
        v = -u;
        u = turned;
    }
}

double emitting_area(const Light& light) {
    switch (light.kind) {
        case LightKind::Point:
        case LightKind::Spot:
            return 4.0 * std::numbers::pi * light.radius_m * light.radius_m;
        case LightKind::Rectangle:
            return 4.0 * glm::length(glm::cross(light.half_u_ws, light.half_v_ws));
        case LightKind::Ellipse:
            return std::numbers::pi * glm::length(glm::cross(light.half_u_ws, light.half_v_ws));
        case LightKind::Polygon: {
            glm::dvec3 doubled{0.0};
            for (std::size_t i = 2; i < light.corners_ws.size(); ++i) {
                doubled += glm::cross(light.corners_ws[i - 1] - light.corners_ws[0],
                                      light.corners_ws[i] - light.corners_ws[0]);
            }
            return 0.5 * glm::length(doubled);
        }
        case LightKind::Sun:
        case LightKind::Line:
            return 0.0;
    }
    return 0.0;
}

glm::dvec3 longest_half_axis(const Light& light) {
    if (light.kind == LightKind::Polygon) {
        glm::dvec3 longest{0.0};
        for (const glm::dvec3& a : light.corners_ws) {
            for (const glm::dvec3& b : light.corners_ws) {
                if (glm::dot(b - a, b - a) > 4.0 * glm::dot(longest, longest)) {
                    longest = 0.5 * (b - a);
                }
            }
        }
        return longest;
    }
    // A flat parallelogram reaches the sum of its half axes, a flat ellipse the root of their squares.
    if (light.kind == LightKind::Rectangle) {
        const double sign = glm::dot(light.half_u_ws, light.half_v_ws) < 0.0 ? -1.0 : 1.0;
        return light.half_u_ws + sign * light.half_v_ws;
    }
    glm::dvec3 u = light.half_u_ws;
    glm::dvec3 v = light.half_v_ws;
    principal_axes(u, v);
    return u;
}

LightForm form_of(const Light& light) {
    switch (light.kind) {
        case LightKind::Point:
        case LightKind::Spot:
            return light.radius_m > kSmallest_m ? LightForm::Sphere : LightForm::Point;
        case LightKind::Sun:
            return light.sun_angle_rad > kSmallest_rad ? LightForm::Sun : LightForm::Direction;
        case LightKind::Line:
            return glm::length(light.half_u_ws) > kSmallest_m ? LightForm::Line : LightForm::Point;
        case LightKind::Rectangle:
        case LightKind::Ellipse:
        case LightKind::Polygon: {
            const glm::dvec3 half = longest_half_axis(light);
            const double size2 = glm::dot(half, half);
            if (!(size2 > kSmallest_m * kSmallest_m)) {
                return LightForm::FacingPoint;
            }
            if (!(emitting_area(light) > kFlat * size2)) {
                return LightForm::FacingLine;
            }
            return light.kind == LightKind::Ellipse ? LightForm::Ellipse : LightForm::Polygon;
        }
    }
    return LightForm::None;
}

double spot_attenuation(const Light& light, const glm::dvec3& p_ws) {
    if (light.kind != LightKind::Spot) {
        return 1.0;
    }
    const glm::dvec3 offset = p_ws - light.position_ws;
    const glm::dvec3 local{glm::dot(offset, light.half_u_ws) / light.spot_stretch.x,
                           glm::dot(offset, light.half_v_ws) / light.spot_stretch.y,
                           glm::dot(offset, light.direction_ws)};
    const double length = glm::length(local);
    if (!(length > 0.0)) {
        return 0.0;
    }
    const double rim = std::cos(0.5 * light.spot_angle_rad);
    const double inside = local.z / length - rim;
    const double soft = (1.0 - rim) * light.spot_blend;
    if (inside <= 0.0 || inside >= soft) {
        return inside > 0.0 ? 1.0 : 0.0;
    }
    const double t = inside / soft;
    return t * t * (3.0 - 2.0 * t);
}

}  // namespace penumbra
