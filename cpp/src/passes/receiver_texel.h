#pragma once

#include <glm/glm.hpp>
#include <span>

#include "penumbra/control.h"
#include "penumbra/view.h"

namespace penumbra {

/// Position and geometric normal of a pixel in one texel, as lib/receiver.glsl reads them.
/// @param normal_ws  unit
[[nodiscard]] glm::uvec4 receiver_texel(const glm::vec3& position_cr, const glm::vec3& normal_ws) noexcept;

/// Of all pixels; 0 where nothing is seen. @param texels  view.size() entries @throws Cancelled
void receiver_texels(const View& view, std::span<glm::uvec4> texels, Control& control);

}  // namespace penumbra
