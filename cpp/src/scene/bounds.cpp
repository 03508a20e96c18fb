#include "scene/bounds.h"

#include <unordered_map>

namespace penumbra {

Bounds bounds_of(const Mesh& mesh) {
    // float32 comparisons are exact, so the widening can wait until the end.
    glm::vec3 low{std::numeric_limits<float>::infinity()};
    glm::vec3 high{-std::numeric_limits<float>::infinity()};
    for (const glm::uvec3& triangle : mesh.triangles) {
        const glm::vec3& a = mesh.positions_local[triangle.x];
        const glm::vec3& b = mesh.positions_local[triangle.y];
        const glm::vec3& c = mesh.positions_local[triangle.z];
        low = glm::min(low, glm::min(a, glm::min(b, c)));
        high = glm::max(high, glm::max(a, glm::max(b, c)));
    }
    return {glm::dvec3{low}, glm::dvec3{high}};
}

Bounds transformed(const Bounds& local, const glm::dmat4& world_from_local) {
    if (local.empty()) {
        return {};
    }
    const glm::dmat3 linear{world_from_local};
    const glm::dvec3 centre = linear * local.centre() + glm::dvec3{world_from_local[3]};
    const glm::dvec3 half = local.half_size();
    const glm::dvec3 reach = glm::abs(linear[0]) * half.x + glm::abs(linear[1]) * half.y + glm::abs(linear[2]) * half.z;
    // A few units in the last place outwards, so that rounding cannot leave a vertex outside.
    const glm::dvec3 margin = (glm::abs(centre) + reach) * 1e-15;
    return {centre - reach - margin, centre + reach + margin};
}

Bounds bounds_of(const Instance& instance) {
    return transformed(bounds_of(*instance.mesh), instance.world_from_local);
}

Bounds bounds_of(const Light& light) {
    Bounds bounds;
    const auto around_centre = [&](const glm::dvec3& reach) {
        bounds.add(light.position_ws - reach);
        bounds.add(light.position_ws + reach);
    };
    switch (light.kind) {
        case LightKind::Point:
        case LightKind::Spot:
            around_centre(glm::dvec3{light.radius_m});
            break;
        case LightKind::Sun:
            break;
        case LightKind::Rectangle:
            around_centre(glm::abs(light.half_u_ws) + glm::abs(light.half_v_ws));
            break;
        case LightKind::Ellipse:  // the extent of a cos t + b sin t is sqrt(a^2 + b^2), per axis
            around_centre(glm::sqrt(light.half_u_ws * light.half_u_ws + light.half_v_ws * light.half_v_ws));
            break;
        case LightKind::Line:
            around_centre(glm::abs(light.half_u_ws));
            break;
        case LightKind::Polygon:
            for (const glm::dvec3& corner : light.corners_ws) {
                bounds.add(corner);
            }
            break;
    }
    return bounds;
}

Bounds bounds_of(const Scene& scene) {
    std::unordered_map<const Mesh*, Bounds> local_bounds;
    Bounds bounds;
    for (const Instance& instance : scene.instances) {
        const auto [entry, is_new] = local_bounds.try_emplace(instance.mesh.get());
        if (is_new) {
            entry->second = bounds_of(*instance.mesh);
        }
        bounds.add(transformed(entry->second, instance.world_from_local));
    }
    return bounds;
}

}  // namespace penumbra
