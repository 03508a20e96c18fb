#pragma once

#include <glm/glm.hpp>

#include "passes/light_summary.h"

namespace penumbra {

/// The light's centre; w = 0: direction towards a sun.
[[nodiscard]] glm::dvec4 homogeneous_centre(const Light& light);

/// In an instance's own space.
[[nodiscard]] glm::dvec4 local_light(const glm::dmat4& world_from_recentred, const glm::dvec3& centre_local,
                                     const glm::dvec4& light_ws);

/// Where volumes end: 0 at infinity; else as far as the light's distance over this (a sun: as a metre over this). All
/// rays of an orthographic camera end in one point at infinity, and float32 cannot clip what is near it: there volumes
/// end beyond the farthest receiver.
[[nodiscard]] double far_share(const LightSummary& summary, const glm::dvec4& light_ws);

}  // namespace penumbra
