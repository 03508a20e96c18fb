#pragma once

#include <cstdint>
#include <glm/glm.hpp>

/// GLSL's type names for C++, so that a struct in cpp/shaders/shared is written once for both sides:
/// `namespace penumbra::gpu { #include "shared/light.h" }`. Mind std430: vec3 takes 16 bytes in GLSL and 12 here, so
/// shared structs use vec4 and scalars only, and check their size with static_assert.
namespace penumbra::gpu {

using uint = std::uint32_t;
using vec2 = glm::vec2;
using vec4 = glm::vec4;
using dvec2 = glm::dvec2;
using dvec4 = glm::dvec4;
using ivec2 = glm::ivec2;
using ivec4 = glm::ivec4;
using uvec2 = glm::uvec2;
using uvec4 = glm::uvec4;
using mat4 = glm::mat4;
using dmat4 = glm::dmat4;

}  // namespace penumbra::gpu
