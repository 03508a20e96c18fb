#pragma once

#include <glm/glm.hpp>
#include <vector>

#include "gl/glsl_types.h"
#include "passes/map_frustum.h"

namespace penumbra {

namespace gpu {
#include "shared/mask_edge.h"
}  // namespace gpu

/// Depth in the penumbra mask's maps: positive and larger the nearer, affine in the image. 1 / z_ls; orthographic:
/// far_m - z_ls.
[[nodiscard]] double mask_w(const MapFace& face, double z_ls) noexcept;

/// A face of the mask's map, and what of space its receivers ask about: the hull of light and receivers.
struct MaskFace {
    MapFace face;
    glm::dvec2 low{0.0}, high{0.0};  ///< extent of the receivers in the face's coordinates, without any margin
    glm::dvec2 per_w{0.0};           ///< half a window's width per difference in w, at most, in the same coordinates
    double nearest_m = 0.0;          ///< perspective: depth z_ls from which on edges are kept
};

/// Puts an edge into a face of the mask's map, as far as it lies in the hull of light and receivers. What lies outside
/// the face is drawn onto its border, on the side where it lies, so that a window that reaches beyond the map meets it
/// there: clamping to a box keeps the order along both axes.
/// @returns false if a part of the edge lies nearer than nearest_m, or beside or behind the light point
bool add_mask_edge(const MaskFace& mask_face, int size_px, const glm::dvec3& a_ls, const glm::dvec3& b_ls,
                   std::vector<gpu::MaskEdge>& out);

/// True if a part of a segment lies before a flat light, nearer to it than nearest_m, within the hull of light and
/// receivers: no depth of the map tells whom it hides.
[[nodiscard]] bool passes_close(const MaskFace& mask_face, const glm::dvec3& a_ls, const glm::dvec3& b_ls) noexcept;

}  // namespace penumbra
