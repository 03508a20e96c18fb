#pragma once

#include <cstdint>
#include <glm/glm.hpp>

/// GLSL's type names for C++, so that a struct in cpp/shaders/shared is written once for both sides:
/// `namespace penumbra::gpu { #include "shared/light.h" }`. Mind std430: vec3 takes 16 bytes in GLSL and 12 here, so
/// shared structs use vec4 and scalars only, and check their size with static_assert.
namespace penumbra::gpu {

using uint = std::uint32_t;
using glm::dmat4;
using glm::dvec2;
using glm::dvec4;
using glm::ivec2;
using glm::ivec4;
using glm::mat4;
using glm::uvec2;
using glm::uvec4;
using glm::vec2;
using glm::vec4;

}  // namespace penumbra::gpu
