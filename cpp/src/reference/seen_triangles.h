#pragma once

#include <glm/glm.hpp>
#include <span>

#include "penumbra/control.h"
#include "penumbra/scene.h"
#include "reference/ray_scene.h"

namespace penumbra {

/// What a camera sees, by rays instead of a rasteriser: for place_surfaces() (geometry/seen_surfaces), and as exact as
/// float32 is in the scene's own frame, while rasterisers move vertices to a grid of 1/256 pixel.
///
/// @param rays  of RayTargets::Visible, or of Casting where the same instances do both
/// @param seen  set per pixel, row 0 at the bottom: index of the instance + 1, or 0 where nothing is seen; triangle of
///              its mesh @throws Cancelled
void find_seen(const RayScene& rays, const Camera& camera, std::span<glm::uvec2> seen, Control& control);

}  // namespace penumbra
