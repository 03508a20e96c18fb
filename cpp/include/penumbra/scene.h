#pragma once

#include <cstdint>
#include <glm/glm.hpp>
#include <memory>
#include <string>
#include <vector>

#include "penumbra/light.h"

namespace penumbra {

/// Triangles in their own space. Shared by all instances, never copied.
struct Mesh {
    std::string name;
    std::vector<glm::vec3> positions_local;        ///< any unit; the instance's transform makes metres of it
    std::vector<glm::uvec3> triangles;             ///< indices into positions_local
    std::vector<glm::vec3> corner_normals_local;   ///< empty (flat), or 3 per triangle, any length
    std::vector<std::uint16_t> triangle_material;  ///< empty (all 0), or 1 per triangle: index into Instance::albedo
};

/// One placement of a mesh.
struct Instance {
    std::string name;
    std::shared_ptr<const Mesh> mesh;
    glm::dmat4 world_from_local{1.0};                   ///< affine, not singular; mirrored and sheared are fine
    std::vector<glm::vec3> albedo{{0.8F, 0.8F, 0.8F}};  ///< linear, per material slot; the last one serves the rest
    bool casts = true;                                  ///< blocks light
    bool receives = true;                               ///< false: seen, but V is not asked there (outside the mask)
    bool visible = true;                                ///< seen by the camera

    /// Of equal members and the same mesh: one of equal content is another.
    friend bool operator==(const Instance&, const Instance&) = default;
};

/// Camera looking along its local -z with +y up; row 0 of every image is at the bottom.
struct Camera {
    std::string name;
    glm::dmat4 world_from_camera{1.0};  ///< rigid; scale is taken out by validate()
    bool orthographic = false;
    double tan_half_width = 0.36;  ///< perspective: half the image's width at distance 1
    double half_width_m = 3.0;     ///< orthographic: half the image's width
    glm::dvec2 shift{0.0};         ///< offset of the image's centre, in image widths (Blender's lens shift)
    double pixel_aspect = 1.0;     ///< height of a pixel over its width
    double near_m = 0.1;           ///< > 0; nothing nearer is seen
    double far_m = 1000.0;         ///< > near_m; nothing farther is seen
    int width_px = 512;
    int height_px = 512;
    glm::dvec2 pixel_offset{0.0};  ///< sub-pixel shift of the sample, in pixels, 0 = pixel centres

    friend bool operator==(const Camera&, const Camera&) = default;
};

/// What is rendered. Knows neither Blender nor OpenGL.
struct Scene {
    std::vector<Instance> instances;
    std::vector<Light> lights;
    Camera camera;
};

/// Checks everything that crosses the border and normalises what has a defined meaning.
/// @throws InvalidScene with one sentence: object, member, index and value, what to do.
void validate(const Mesh& mesh);
void validate(const Instance& instance);
void validate(Camera& camera);
void validate(Scene& scene);

}  // namespace penumbra
