#include <chrono>

#include "penumbra/reference.h"
#include "reference/light_mask.h"

namespace penumbra {

namespace {

/// Where the line of sight through a pixel's float32 position meets the plane of the triangle it shows, in float64.
glm::dvec3 point_on_triangle(const Scene& scene, const View& view, std::size_t i) {
    const Instance& instance = scene.instances[static_cast<std::size_t>(view.instance[i])];
    const glm::uvec3& t = instance.mesh->triangles[static_cast<std::size_t>(view.triangle[i])];
    const auto corner = [&](glm::uint k) {
        return glm::dvec3{instance.world_from_local * glm::dvec4{glm::dvec3{instance.mesh->positions_local[k]}, 1.0}};
    };
    const glm::dvec3 a = corner(t.x);
    const glm::dvec3 normal = glm::cross(corner(t.y) - a, corner(t.z) - a);
    const glm::dvec3 p = view.eye_ws + glm::dvec3{view.position_cr[i]};
    const double area = glm::dot(normal, normal);
    if (!(area > 0.0)) {
        return p;
    }
    return p - normal * (glm::dot(normal, p - a) / area);  // the nearest point: within rounding of the line of sight
}

}  // namespace

Reference exact_reference(const Scene& scene, const View& view, const Light& light, Control& control) {
    const auto started = std::chrono::steady_clock::now();
    Reference result;
    result.method = "exact";
    result.mask = light_mask(scene, view, light);
    std::vector<std::size_t> pixels;
    std::vector<glm::dvec3> positions_ws;
    std::vector<glm::dvec3> normals_ws;
    for (std::size_t i = 0; i < view.size(); ++i) {
        if (result.mask[i] != 0) {
            pixels.push_back(i);
            positions_ws.push_back(point_on_triangle(scene, view, i));
            normals_ws.emplace_back(view.shading_normal_ws[i]);  // weighs the irradiance; V knows no normal
        }
    }
    const ExactResult exact = light.casts_shadow ? exact_visibility(scene, light, positions_ws, normals_ws, control)
                                                 : ExactResult{std::vector<double>(pixels.size(), 1.0),
                                                               std::vector<double>(pixels.size(), 1.0)};
    result.area.assign(view.size(), 1.0F);
    result.irradiance.assign(view.size(), 1.0F);
    result.standard_error.assign(view.size(), 0.0F);
    result.irradiance_standard_error.assign(view.size(), 0.0F);
    for (std::size_t k = 0; k < pixels.size(); ++k) {
        result.area[pixels[k]] = static_cast<float>(exact.area[k]);
        result.irradiance[pixels[k]] = static_cast<float>(exact.irradiance[k]);
    }
    result.pixels_skipped = view.size() - pixels.size();
    result.time_ms = std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - started).count();
    return result;
}

}  // namespace penumbra
