#pragma once

#include <glm/glm.hpp>

#include "geometry/light_block.h"

namespace penumbra::test {

/// shaders/lib/irradiance.glsl, compiled as C++ in float32.
[[nodiscard]] float glsl_irradiance_per_radiance(const gpu::LightBlock& light, const glm::vec3& p_cr,
                                                 const glm::vec3& n);
[[nodiscard]] float glsl_spot_attenuation(const gpu::LightBlock& light, const glm::vec3& p_cr);

}  // namespace penumbra::test
