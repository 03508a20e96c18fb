#pragma once

#include <cstdint>
#include <glm/glm.hpp>
#include <vector>

namespace penumbra {

/// What the camera sees at the sample of each pixel: the G-buffer, in main memory. Row 0 is the bottom row.
/// Arrays have width * height entries, index y * width + x; the last two are empty inside the core until a picture asks
/// for them (geometry/seen_surfaces), and full in what Renderer::view() gives.
struct View {
    int width = 0;
    int height = 0;
    glm::dvec3 eye_ws{0.0};                    ///< origin of position_cr
    std::vector<glm::vec3> position_cr;        ///< metres, world axes, relative to eye_ws; made in float64
    std::vector<glm::vec3> normal_ws;          ///< geometric, unit, turned towards the camera
    std::vector<std::int32_t> instance;        ///< index into Scene::instances, -1 where nothing is seen
    std::vector<std::int32_t> triangle;        ///< index into Mesh::triangles, -1 where nothing is seen
    std::vector<glm::vec3> shading_normal_ws;  ///< interpolated, unit, turned like normal_ws
    std::vector<glm::vec3> albedo;             ///< linear

    [[nodiscard]] std::size_t size() const noexcept { return static_cast<std::size_t>(width) * height; }
    [[nodiscard]] bool hit(std::size_t i) const noexcept { return instance[i] >= 0; }
};

}  // namespace penumbra
