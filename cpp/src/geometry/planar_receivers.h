#pragma once

#include <cstdint>
#include <glm/glm.hpp>
#include <span>
#include <string>
#include <vector>

#include "penumbra/scene.h"
#include "penumbra/view.h"

namespace penumbra {

/// A plane on which the camera sees receivers, and the rectangle of it that is seen.
struct PlanarReceiver {
    std::string name;  ///< of the instance with most pixels on it
    glm::dvec3 origin_ws{0.0};
    glm::dvec3 axis_x{1.0, 0.0, 0.0}, axis_y{0.0, 1.0, 0.0};  ///< unit, in the plane
    glm::dvec3 normal{0.0, 0.0, 1.0};                         ///< unit, axis_x x axis_y, to the side that is seen
    glm::dvec2 low_m{0.0}, high_m{0.0};                       ///< of the pixels on it, along the axes from the origin
    std::uint64_t pixels = 0;

    [[nodiscard]] double height(const glm::dvec3& p_ws) const noexcept { return glm::dot(p_ws - origin_ws, normal); }
};

struct PlanarReceiverOptions {
    int most = 8;               ///< planes, largest in pixels first; at most 15
    double tolerance_m = 0.0;   ///< a triangle lies on a plane if its corners are this near to it
    double least_share = 0.01;  ///< of the mask's pixels; a smaller plane is not worth a texture
    bool whole = false;         ///< the rectangle holds all of the instances' triangles on the plane, seen or not
    std::string only;           ///< name of the one instance whose planes count; empty: all
};

struct PlanarReceivers {
    static constexpr std::uint8_t kNone = 255;
    std::vector<PlanarReceiver> planes;
    std::vector<std::uint8_t> plane_of_pixel;  ///< index into planes, or kNone; as View
    std::uint64_t pixels_on_none = 0;          ///< of the mask
};

/// Planes of the view's pixels, in float64 from the seen triangles themselves, so that neither the view's rounding nor
/// its normals blur them: triangles are gathered by (normal, offset) over all instances, the fullest cells become
/// planes, and every triangle within tolerance of a plane and turned like it joins. A plane's two sides are two planes.
/// @param mask 1 where the pixel counts; as View
[[nodiscard]] PlanarReceivers find_planar_receivers(const Scene& scene, const View& view,
                                                    std::span<const std::uint8_t> mask,
                                                    const PlanarReceiverOptions& options);

}  // namespace penumbra
