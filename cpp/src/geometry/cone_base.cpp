#include "geometry/cone_base.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "geometry/light_shape.h"

namespace penumbra {

namespace {

constexpr double kPi = std::numbers::pi;
// A sun's disc of directions of half a turn has no image on a plane.
constexpr double kWidestSun_rad = 85.0 * kPi / 180.0;

bool is_area(LightKind kind) {
    return kind == LightKind::Rectangle || kind == LightKind::Ellipse || kind == LightKind::Polygon;
}

ConeBase disc(double radius) {
    ConeBase base;
    base.ip_from_unit = glm::dmat2{radius};
    base.reach = radius;
    return base;
}

ConeBase polygon(std::vector<glm::dvec2> corners) {
    ConeBase base;
    base.kind = ConeBase::Kind::Polygon;
    double area = 0.0;
    for (std::size_t i = 0; i < corners.size(); ++i) {
        const glm::dvec2& a = corners[i];
        const glm::dvec2& b = corners[(i + 1) % corners.size()];
        area += a.x * b.y - a.y * b.x;
        base.reach = std::max(base.reach, glm::length(a));
    }
    if (area < 0.0) {
        std::ranges::reverse(corners);
    }
    if (corners.size() > 2 && !(std::abs(area) > 1e-6 * base.reach * base.reach)) {
        return disc(base.reach);  // seen edge on: what is left is no shape to build on
    }
    base.corners = std::move(corners);
    return base;
}

}  // namespace

double ConeBase::support(const glm::dvec2& n) const noexcept {
    if (kind == Kind::Sphere) {
        return reach;
    }
    if (kind == Kind::Ellipse) {
        return glm::length(glm::transpose(ip_from_unit) * n);
    }
    double most = -reach;
    for (const glm::dvec2& corner : corners) {
        most = std::max(most, glm::dot(corner, n));
    }
    return most;
}

double disc_radius(const Light& light) {
    switch (light.kind) {
        case LightKind::Point:
        case LightKind::Spot:
            return light.radius_m;
        case LightKind::Sun:
            return std::tan(std::min(0.5 * light.sun_angle_rad, kWidestSun_rad));
        default:
            break;
    }
    const double area = is_area(light.kind) ? emitting_area(light) : 0.0;
    const double longest = glm::length(longest_half_axis(light));
    return area > 1e-9 * longest * longest ? std::sqrt(area / kPi) : 2.0 / kPi * longest;
}

ConeBase cone_base(const Light& light, ConeShape shape, const glm::dmat3& ls_from_world) {
    const double radius = disc_radius(light);
    if (shape == ConeShape::Sphere && (light.kind == LightKind::Point || light.kind == LightKind::Spot)) {
        ConeBase base = disc(radius);
        base.kind = ConeBase::Kind::Sphere;
        base.ip_from_unit = glm::dmat2{1.0};
        return base;
    }
    if (shape != ConeShape::Light) {
        return disc(radius);
    }
    const auto image = [&](const glm::dvec3& offset_ws) { return glm::dvec2{ls_from_world * offset_ws}; };
    const double area = is_area(light.kind) ? emitting_area(light) : 0.0;
    const glm::dvec3 longest_ws = light.kind == LightKind::Line ? light.half_u_ws
                                  : is_area(light.kind)         ? longest_half_axis(light)
                                                                : glm::dvec3{0.0};
    const bool flat = area > 1e-9 * glm::dot(longest_ws, longest_ws);
    if (light.kind == LightKind::Line || (is_area(light.kind) && !flat)) {
        const glm::dvec2 half = image(longest_ws);
        return glm::length(half) > 1e-6 * glm::length(longest_ws) ? polygon({-half, half}) : disc(radius);
    }
    switch (light.kind) {
        case LightKind::Rectangle: {
            const glm::dvec2 u = image(light.half_u_ws);
            const glm::dvec2 v = image(light.half_v_ws);
            return polygon({-u - v, u - v, u + v, -u + v});
        }
        case LightKind::Polygon: {
            std::vector<glm::dvec2> corners;
            corners.reserve(light.corners_ws.size());
            for (const glm::dvec3& corner_ws : light.corners_ws) {
                corners.push_back(image(corner_ws - light.position_ws));
            }
            return polygon(std::move(corners));
        }
        case LightKind::Ellipse: {
            ConeBase base;
            base.ip_from_unit = glm::dmat2{image(light.half_u_ws), image(light.half_v_ws)};
            if (glm::determinant(base.ip_from_unit) < 0.0) {
                base.ip_from_unit[1] = -base.ip_from_unit[1];
            }
            const glm::dvec2 u = base.ip_from_unit[0];
            const glm::dvec2 v = base.ip_from_unit[1];
            const double mean = 0.5 * (glm::dot(u, u) + glm::dot(v, v));
            base.reach = std::sqrt(mean + std::hypot(mean - glm::dot(v, v), glm::dot(u, v)));
            if (!(glm::determinant(base.ip_from_unit) > 1e-6 * base.reach * base.reach)) {
                return disc(radius);
            }
            return base;
        }
        default:
            return disc(radius);
    }
}

double published_intensity(double t, double kappa) noexcept {
    return t / (t + (1.0 - t) * kappa);
}

double smoothstep_falloff(double x) noexcept {
    return x * x * (3.0 - 2.0 * x);
}

double disc_fraction(double u) noexcept {
    const double x = std::clamp(u, -1.0, 1.0);
    return 0.5 + (x * std::sqrt(1.0 - x * x) + std::asin(x)) / kPi;
}

}  // namespace penumbra
