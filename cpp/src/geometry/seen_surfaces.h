#pragma once

#include <glm/glm.hpp>
#include <span>

#include "penumbra/control.h"
#include "penumbra/scene.h"
#include "penumbra/view.h"

namespace penumbra {

/// A view of the scene's camera from what each pixel shows: where its ray meets the plane of that triangle, in float64,
/// so that neither large triangles nor a scene far from the origin cost precision; only what is relative to the eye
/// becomes float32. Without shading_normal_ws and albedo, which V does not need: shade_surfaces().
///
/// @param seen  per pixel, row 0 at the bottom: index of the instance + 1, or 0 where nothing is seen; triangle of its
///              mesh. A triangle without area is no surface: nothing is seen there.
/// @param spare  a view that nobody needs any more; its memory is used again, as new memory costs as much as the rays
/// @throws Cancelled
[[nodiscard]] View place_surfaces(const Scene& scene, std::span<const glm::uvec2> seen, Control& control,
                                  View spare = {});

/// Fills shading_normal_ws and albedo of a view of place_surfaces(), if they are not there. @throws Cancelled
void shade_surfaces(const Scene& scene, View& view, Control& control);

}  // namespace penumbra
