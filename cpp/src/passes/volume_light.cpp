#include "passes/volume_light.h"

#include <algorithm>

namespace penumbra {

namespace {

/// In an orthographic view what casts from nearer than this share of the farthest receiver's distance to the light
/// casts a shadow that ends before that receiver.
constexpr double kShortest = 1e-4;

}  // namespace

glm::dvec4 homogeneous_centre(const Light& light) {
    return light.kind == LightKind::Sun ? glm::dvec4{-light.direction_ws, 0.0} : glm::dvec4{light.position_ws, 1.0};
}

glm::dvec4 local_light(const glm::dmat4& world_from_recentred, const glm::dvec3& centre_local,
                       const glm::dvec4& light_ws) {
    // Relative to the instance first: the inverse's own translation would lose digits far from the origin.
    const glm::dvec3 towards = glm::dvec3{light_ws} - light_ws.w * glm::dvec3{world_from_recentred[3]};
    const glm::dvec3 local = glm::inverse(glm::dmat3{world_from_recentred}) * towards;
    return {light_ws.w == 0.0 ? glm::normalize(local) : local + centre_local, light_ws.w};
}

double far_share(const LightSummary& summary, const glm::dvec4& light_ws) {
    if (!summary.scene->camera.orthographic || summary.receivers_ws.empty()) {
        return 0.0;
    }
    if (light_ws.w == 0.0) {
        Bounds all = summary.receivers_ws;
        for (const Bounds& caster : summary.caster_bounds_ws) {
            all.add(caster);
        }
        return 1.0 / std::max(4.0 * all.radius(), 1e-20);
    }
    const glm::dvec3 light{light_ws};
    const glm::dvec3 to_middle = summary.receivers_ws.centre() - light;
    const double farthest = glm::length(to_middle) + summary.receivers_ws.radius();
    double nearest = farthest;
    for (std::size_t i = 0; i < summary.casters.size(); ++i) {
        const Bounds& caster = summary.caster_bounds_ws[i];
        if (summary.caster_needed[i] != 0) {
            nearest = std::min(nearest, glm::length(light - glm::clamp(light, caster.low, caster.high)));
        }
    }
    return std::max(0.5 * nearest / std::max(farthest, 1e-20), kShortest);
}

}  // namespace penumbra
