#pragma once

#include <glm/glm.hpp>

#include "penumbra/light.h"

namespace penumbra {

/// Replaces conjugate half axes of an ellipse (any centre + a u + b v, a^2 + b^2 <= 1) by its perpendicular ones, the
/// longer one first; the ellipse stays the same.
void principal_axes(glm::dvec3& u, glm::dvec3& v);

/// Area of the light's emitting surface in m^2: both half axes spanned (Rectangle 4 |u x v|, Ellipse pi |u x v|), the
/// polygon's area, the sphere's whole surface 4 pi r^2; 0 for the other kinds.
[[nodiscard]] double emitting_area(const Light& light);

/// The half segment that an area light without width collapses to: from its middle to an end; zero if it has no
/// extent at all.
[[nodiscard]] glm::dvec3 longest_half_axis(const Light& light);

}  // namespace penumbra
