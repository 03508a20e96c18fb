#include "reference/light_mask.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "base/parallel.h"

namespace penumbra {
namespace {

constexpr std::int64_t kPixelGrain = 16384;
/// The position rounds once and the normal once per component; two of each in the worst direction.
constexpr double kSlackRoundings = 4.0;

double largest(const glm::dvec3& v) noexcept {
    return std::max({std::abs(v.x), std::abs(v.y), std::abs(v.z)});
}

/// Of the height of a light over the plane of what a pixel sees, metres.
double rounding_of(const Light& light, const View& view, std::size_t i) noexcept {
    const glm::dvec3 position_cr{view.position_cr[i]};
    const double size_m = largest(position_cr) + largest(light.position_ws - (view.eye_ws + position_cr));
    return kSlackRoundings * std::numeric_limits<float>::epsilon() * size_m;
}

/// Beyond half the full angle Blender's spot is dark, whatever the blend.
bool inside_cone(const Light& light, const glm::dvec3& from_light) noexcept {
    const glm::dvec3 axis_y = glm::cross(light.direction_ws, light.half_u_ws);
    const double x = glm::dot(from_light, light.half_u_ws) / light.spot_stretch.x;
    const double y = glm::dot(from_light, axis_y) / light.spot_stretch.y;
    const double z = glm::dot(from_light, light.direction_ws);
    return z > std::cos(0.5 * light.spot_angle_rad) * std::sqrt(x * x + y * y + z * z);
}

}  // namespace

bool faces_light(const Light& light, const glm::dvec3& p, const glm::dvec3& n, double slack_m) noexcept {
    const glm::dvec3 to_light = light.position_ws - p;
    const double height = glm::dot(n, to_light);
    const double along_u = glm::dot(n, light.half_u_ws);
    const double along_v = glm::dot(n, light.half_v_ws);
    const bool lit_side = glm::dot(light.direction_ws, to_light) < -slack_m;
    switch (light.kind) {
        case LightKind::Point:
            return height + light.radius_m > slack_m;
        case LightKind::Spot:
            return height + light.radius_m > slack_m && inside_cone(light, -to_light);
        case LightKind::Sun:
            return glm::dot(n, light.direction_ws) < std::sin(0.5 * light.sun_angle_rad);
        case LightKind::Rectangle:
            return lit_side && height + std::abs(along_u) + std::abs(along_v) > slack_m;
        case LightKind::Ellipse:
            return lit_side && height + std::sqrt(along_u * along_u + along_v * along_v) > slack_m;
        case LightKind::Line:
            return height + std::abs(along_u) > slack_m;
        case LightKind::Polygon: {
            double highest = -std::numeric_limits<double>::infinity();
            for (const glm::dvec3& corner : light.corners_ws) {
                highest = std::max(highest, glm::dot(n, corner - p));
            }
            return lit_side && highest > slack_m;
        }
    }
    return false;
}

bool dips_under(const Light& light, const View& view, std::size_t i) noexcept {
    const glm::dvec3 p = view.eye_ws + glm::dvec3{view.position_cr[i]};
    const glm::dvec3 n{view.normal_ws[i]};
    const glm::dvec3 to_light = light.position_ws - p;
    const double slack_m = rounding_of(light, view, i);
    const double height = glm::dot(n, to_light);
    const double along_u = glm::dot(n, light.half_u_ws);
    const double along_v = glm::dot(n, light.half_v_ws);
    switch (light.kind) {
        case LightKind::Point:
        case LightKind::Spot:
            return height - light.radius_m < -slack_m;
        case LightKind::Sun:
            return glm::dot(n, light.direction_ws) > -std::sin(0.5 * light.sun_angle_rad) + 1e-6;
        case LightKind::Rectangle:
            return height - std::abs(along_u) - std::abs(along_v) < -slack_m;
        case LightKind::Ellipse:
            return height - std::sqrt(along_u * along_u + along_v * along_v) < -slack_m;
        case LightKind::Line:
            return height - std::abs(along_u) < -slack_m;
        case LightKind::Polygon:
            return std::ranges::any_of(light.corners_ws,
                                       [&](const glm::dvec3& corner) { return glm::dot(n, corner - p) < -slack_m; });
    }
    return false;
}

std::vector<std::uint8_t> light_mask(const Scene& scene, const View& view, const Light& light) {
    std::vector<std::uint8_t> mask(view.size(), 0);
    Control control;
    parallel_for(
        static_cast<std::int64_t>(view.size()), kPixelGrain,
        [&](std::int64_t begin, std::int64_t end) {
            for (std::int64_t i = begin; i < end; ++i) {
                if (!view.hit(i) || !scene.instances[view.instance[i]].receives) {
                    continue;
                }
                const glm::dvec3 position_ws = view.eye_ws + glm::dvec3{view.position_cr[i]};
                const double slack_m = rounding_of(light, view, static_cast<std::size_t>(i));
                mask[i] = faces_light(light, position_ws, glm::dvec3(view.normal_ws[i]), slack_m) ? 1 : 0;
            }
        },
        control);
    return mask;
}

}  // namespace penumbra
