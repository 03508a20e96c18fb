#pragma once

#include <array>
#include <glm/glm.hpp>

#include "penumbra/light.h"

namespace penumbra {

/// A convex region that holds all points of a light: centre + sum of s_i half_i with every |s_i| <= 1 or, if `round`,
/// sum of s_i^2 <= 1. Exact for sphere, disc, ellipse, rectangle and line; a polygon gets the rectangle around it,
/// along its first edge. A sun is a disc of directions: directions towards it (w = 0) in place of points.
struct LightRegion {
    glm::dvec4 centre{0.0};            ///< w 1; sun: 0 and a unit direction towards it
    std::array<glm::dvec3, 3> half{};  ///< unused ones are zero; sun: across the axis, tangent of half its angle
    bool round = false;

    /// How far the region reaches from its centre along `axis` (times its length): exact.
    [[nodiscard]] double reach(const glm::dvec3& axis) const noexcept;
    /// No point is farther from the centre.
    [[nodiscard]] double radius() const noexcept;
    /// The same region in other coordinates, e.g. a mesh's own. @param to affine, not singular
    [[nodiscard]] LightRegion in(const glm::dmat4& to_from_here) const noexcept;
};

/// @param light  validated; a sun's half angle is held below 89 degrees
[[nodiscard]] LightRegion light_region(const Light& light) noexcept;

}  // namespace penumbra
