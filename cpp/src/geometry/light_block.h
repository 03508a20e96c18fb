#pragma once

#include <glm/glm.hpp>

#include "penumbra/light.h"

namespace penumbra::gpu {

using glm::vec4;  // as gl/glsl_types.h says, without an arrow to gl

#include "shared/light.h"

static_assert(sizeof(LightBlock) == (6 + PENUMBRA_MAX_LIGHT_CORNERS) * sizeof(vec4), "std140: vec4 only");

}  // namespace penumbra::gpu

namespace penumbra {

/// The light as shaders see it: float32, positions relative to the eye, degenerate cases told apart.
/// @param eye_ws the camera's position; subtracted in float64
[[nodiscard]] gpu::LightBlock light_block(const Light& light, const glm::dvec3& eye_ws);

}  // namespace penumbra
