#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "penumbra/control.h"
#include "penumbra/view.h"

namespace penumbra {

/// Which pixels have both light and shadow around them.
///
/// @param visibility  V by a pixel's rays, view.size() entries; below 0: it has none
/// @param radius      pixels around that are looked at, in a square
/// @param open        0 or 1 each; those are set to 0 around which all rays found light, or all found shadow, or none
/// are
/// @throws Cancelled
void keep_mixed(const View& view, std::span<const float> visibility, int radius, std::span<std::uint8_t> open,
                Control& control);

}  // namespace penumbra
