#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "measure/classes.h"

namespace penumbra {

/// 1 for every pixel at most `radius_px` rows and columns away from a shadow edge of the reference: a penumbra pixel,
/// or an umbra pixel that touches a lit one. Tells an edge in the wrong place from a surface that is wrong all over.
[[nodiscard]] std::vector<std::uint8_t> edge_zone(std::span<const PixelClass> classes, int width, int radius_px);

}  // namespace penumbra
