#pragma once

#include <glm/glm.hpp>
#include <span>
#include <vector>

#include "passes/silhouette_pass.h"

namespace penumbra {

class Frame;

/// The thesis' construction for vertices with more than two silhouette edges [Chan2004]: a tip along the average normal
/// of the triangles around the vertex, and a triangle from each edge's outer corner to it. Made on the CPU from records
/// that are read back: for reproduction, not for speed.
///
/// @return two entries per record, for its ends a and b: xyz the average normal, world axes; w = 1 if the end has more
///         than two silhouette edges, else 0
[[nodiscard]] std::vector<glm::vec4> thesis_tips(const Frame& frame, std::span<const gpu::SilhouetteRecord> records);

}  // namespace penumbra
