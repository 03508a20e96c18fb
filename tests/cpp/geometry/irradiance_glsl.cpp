// The shader's own text as C++: GLM gives GLSL's types and functions, -fsingle-precision-constant its literals.
#include "irradiance_glsl.h"

#include <glm/glm.hpp>

namespace penumbra::test {
namespace {

using namespace glm;  // NOLINT: the text below is GLSL
using gpu::LightBlock;

#include "lib/irradiance.glsl"

}  // namespace

float glsl_irradiance_per_radiance(const gpu::LightBlock& light, const glm::vec3& p_cr, const glm::vec3& n) {
    return irradiance_per_radiance(light, p_cr, n);
}

float glsl_spot_attenuation(const gpu::LightBlock& light, const glm::vec3& p_cr) {
    return spot_attenuation(light, p_cr);
}

}  // namespace penumbra::test
