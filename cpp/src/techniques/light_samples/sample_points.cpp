#include "techniques/light_samples/sample_points.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>

namespace penumbra {

namespace {

constexpr double kPi = std::numbers::pi;

std::vector<glm::dvec2> unit_square(int count, std::string_view pattern, std::uint32_t seed) {
    std::mt19937_64 random{seed};
    std::uniform_real_distribution<double> uniform{0.0, 1.0};
    std::vector<glm::dvec2> points;
    points.reserve(static_cast<std::size_t>(count));
    const int side = static_cast<int>(std::lround(std::sqrt(static_cast<double>(count))));
    const bool square = side * side == count;
    if (pattern == "r2" || !square) {
        // R2 sequence: the plastic number's additive recurrence, shifted by the seed. [Roberts2018]
        const glm::dvec2 shift{uniform(random), uniform(random)};
        const glm::dvec2 step{0.7548776662466927, 0.5698402909980532};
        for (int i = 0; i < count; ++i) {
            points.push_back(glm::fract(shift + step * static_cast<double>(i + 1)));
        }
        return points;
    }
    const double cell = 1.0 / side;
    for (int j = 0; j < side; ++j) {
        for (int i = 0; i < side; ++i) {
            const glm::dvec2 inside =
                pattern == "grid" ? glm::dvec2{0.5} : glm::dvec2{uniform(random), uniform(random)};
            points.push_back((glm::dvec2{i, j} + inside) * cell);
        }
    }
    return points;
}

std::vector<double> unit_interval(int count, std::string_view pattern, std::uint32_t seed) {
    std::mt19937_64 random{seed};
    std::uniform_real_distribution<double> uniform{0.0, 1.0};
    std::vector<double> points;
    points.reserve(static_cast<std::size_t>(count));
    for (int i = 0; i < count; ++i) {
        points.push_back((i + (pattern == "grid" ? 0.5 : uniform(random))) / count);
    }
    return points;
}

/// Uniform in a convex polygon: a fan triangle chosen by area, then the square folded onto it.
glm::dvec3 in_polygon(const std::vector<glm::dvec3>& corners, glm::dvec2 u) {
    std::vector<double> area;
    double total = 0.0;
    for (std::size_t i = 2; i < corners.size(); ++i) {
        total += 0.5 * glm::length(glm::cross(corners[i - 1] - corners[0], corners[i] - corners[0]));
        area.push_back(total);
    }
    const double wanted = u.x * total;
    std::size_t k = 0;
    while (k + 1 < area.size() && area[k] <= wanted) {
        ++k;
    }
    const double before = k == 0 ? 0.0 : area[k - 1];
    const double span = area[k] - before;
    u.x = span > 0.0 ? std::clamp((wanted - before) / span, 0.0, 1.0) : 0.5;
    const double root = std::sqrt(u.x);
    return (1.0 - root) * corners[0] + root * (1.0 - u.y) * corners[k + 1] + root * u.y * corners[k + 2];
}

void frame_around(const glm::dvec3& axis, glm::dvec3& u, glm::dvec3& v) {
    const glm::dvec3 helper = std::abs(axis.z) < 0.9 ? glm::dvec3{0, 0, 1} : glm::dvec3{0, 1, 0};
    u = glm::normalize(glm::cross(helper, axis));
    v = glm::cross(axis, u);
}

}  // namespace

glm::dvec2 concentric_disc(const glm::dvec2& u) noexcept {
    const glm::dvec2 s = 2.0 * u - glm::dvec2{1.0};
    if (s.x == 0.0 && s.y == 0.0) {
        return {0.0, 0.0};
    }
    const bool wide = std::abs(s.x) > std::abs(s.y);
    const double radius = wide ? s.x : s.y;
    const double angle = wide ? kPi / 4.0 * (s.y / s.x) : kPi / 2.0 - kPi / 4.0 * (s.x / s.y);
    return radius * glm::dvec2{std::cos(angle), std::sin(angle)};
}

std::vector<LightSamplePoint> sample_points(const Light& light, int count, std::string_view pattern, std::uint32_t seed,
                                            const SphereCap& cap) {
    std::vector<LightSamplePoint> points;
    LightSamplePoint centre{light.position_ws, light.direction_ws, {}};
    if (has_no_extent(light) || count <= 1) {
        return {centre};
    }
    if (light.kind == LightKind::Line) {
        for (const double t : unit_interval(count, pattern, seed)) {
            centre.position_ws = light.position_ws + (2.0 * t - 1.0) * light.half_u_ws;
            points.push_back(centre);
        }
        return points;
    }
    glm::dvec3 sun_u;
    glm::dvec3 sun_v;
    frame_around(light.direction_ws, sun_u, sun_v);
    glm::dvec3 cap_u;
    glm::dvec3 cap_v;
    frame_around(cap.axis_ws, cap_u, cap_v);
    for (const glm::dvec2& u : unit_square(count, pattern, seed)) {
        LightSamplePoint point = centre;
        switch (light.kind) {
            case LightKind::Point:
            case LightKind::Spot: {
                // The disc's map onto the cap keeps areas: height falls with the square of the radius.
                const glm::dvec2 d = concentric_disc(u);
                const double height = 1.0 - (1.0 - cap.least_cosine) * glm::dot(d, d);
                const double ring = std::sqrt(std::max(0.0, 1.0 - height * height));
                const double radius = glm::length(d);
                const glm::dvec2 around = radius > 0.0 ? d * (ring / radius) : glm::dvec2{0.0};
                point.normal_ws = around.x * cap_u + around.y * cap_v + height * cap.axis_ws;
                point.position_ws = light.position_ws + light.radius_m * point.normal_ws;
                break;
            }
            case LightKind::Sun: {
                const glm::dvec2 d = std::tan(0.5 * std::min(light.sun_angle_rad, 3.1)) * concentric_disc(u);
                point.direction_ws = glm::normalize(light.direction_ws + d.x * sun_u + d.y * sun_v);
                break;
            }
            case LightKind::Rectangle:
                point.position_ws += (2.0 * u.x - 1.0) * light.half_u_ws + (2.0 * u.y - 1.0) * light.half_v_ws;
                break;
            case LightKind::Ellipse: {
                const glm::dvec2 d = concentric_disc(u);
                point.position_ws += d.x * light.half_u_ws + d.y * light.half_v_ws;
                break;
            }
            case LightKind::Polygon:
                point.position_ws = in_polygon(light.corners_ws, u);
                break;
            case LightKind::Line:
                break;
        }
        points.push_back(point);
    }
    return points;
}

}  // namespace penumbra
