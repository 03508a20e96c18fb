#include "passes/volume_eye.h"

#include <algorithm>
#include <cmath>
#include <glm/glm.hpp>
#include <limits>
#include <vector>

#include "passes/volume_light.h"

namespace penumbra {

namespace {

/// Light and eye's near rectangle, as far as they may hide a caster: convex hull of points, open towards a sun.
struct EyeHull {
    std::vector<glm::dvec3> points;
    glm::dvec3 open{0.0};

    [[nodiscard]] bool apart_from(const Bounds& box, const glm::dvec3& axis) const {
        double low = std::numeric_limits<double>::infinity();
        double high = -low;
        for (const glm::dvec3& p : points) {
            low = std::min(low, glm::dot(p, axis));
            high = std::max(high, glm::dot(p, axis));
        }
        const double along = glm::dot(open, axis);
        low = along < 0.0 ? -std::numeric_limits<double>::infinity() : low;
        high = along > 0.0 ? std::numeric_limits<double>::infinity() : high;
        const double middle = glm::dot(box.centre(), axis);
        const double reach = glm::dot(box.half_size(), glm::abs(axis));
        // Rounding of positions relative to the eye must not decide.
        const double slack = 1e-5 * (glm::length(axis) * glm::length(box.centre() - points.front()) + reach);
        return middle - reach > high + slack || middle + reach < low - slack;
    }
};

}  // namespace

bool eye_is_outside(const Bounds& caster_ws, const Camera& camera, const Light& light) {
    if (camera.orthographic) {
        return false;
    }
    const glm::dvec3 eye_ws{camera.world_from_camera[3]};
    const glm::dvec3 right_ws{camera.world_from_camera[0]};
    const glm::dvec3 up_ws{camera.world_from_camera[1]};
    const glm::dvec3 forward_ws = -glm::dvec3{camera.world_from_camera[2]};
    const double half_width = camera.tan_half_width;
    const double half_height = half_width * camera.height_px * camera.pixel_aspect / camera.width_px;
    const glm::dvec2 middle = 2.0 * half_width * camera.shift;
    EyeHull hull;
    hull.points.push_back(eye_ws);
    for (const double x : {-1.1, 1.1}) {
        for (const double y : {-1.1, 1.1}) {
            hull.points.push_back(eye_ws + camera.near_m * (forward_ws + (middle.x + x * half_width) * right_ws +
                                                            (middle.y + y * half_height) * up_ws));
        }
    }
    const glm::dvec4 light_ws = homogeneous_centre(light);
    if (light_ws.w == 0.0) {
        hull.open = glm::dvec3{light_ws};
    } else {
        hull.points.emplace_back(light_ws);
    }
    const glm::dvec3 to_light = light_ws.w == 0.0 ? hull.open : glm::normalize(glm::dvec3{light_ws} - eye_ws);
    std::vector<glm::dvec3> axes{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
    for (int i = 0; i < 3; ++i) {
        for (const glm::dvec3& edge : {to_light, right_ws, up_ws}) {
            axes.push_back(glm::cross(axes[static_cast<std::size_t>(i)], edge));
        }
    }
    // Around the long way from the eye to the light, which is a thin pyramid.
    const glm::dvec3 u = glm::cross(to_light, std::abs(to_light.x) < 0.7 ? glm::dvec3{1, 0, 0} : glm::dvec3{0, 1, 0});
    axes.push_back(to_light);
    axes.push_back(u);
    axes.push_back(glm::cross(to_light, u));
    axes.push_back(forward_ws);
    return std::ranges::any_of(axes, [&](const glm::dvec3& axis) {
        return glm::dot(axis, axis) > 1e-12 && hull.apart_from(caster_ws, glm::normalize(axis));
    });
}

}  // namespace penumbra
