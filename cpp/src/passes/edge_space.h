#pragma once

#include <glm/glm.hpp>

#include "gl/program.h"
#include "passes/map_frustum.h"

namespace penumbra {

/// Depths between which a silhouette edge can matter to a face (uniforms of lib/edge_space.glsl).
struct EdgeRange {
    double z_low = 0.0;   ///< metres; what is nearer to the light is cut off
    double z_high = 0.0;  ///< just behind the deepest receiver
    double w_far = 0.0;   ///< of z_high: 1 / z_high, orthographic -z_high
};

/// @param reach_per_w  largest half size of the light, metres (sun: tangent): edges nearer than 1/1000 of it would
///                     throw images too large for float32
[[nodiscard]] EdgeRange edge_range(const MapFace& face, double reach_per_w);

/// Sets what lib/edge_space.glsl needs for one face.
/// @param ip_from_unit  of positive determinant
void set_edge_space(const Program& program, int face, const EdgeRange& range, const glm::dmat2& ip_from_unit);

}  // namespace penumbra
