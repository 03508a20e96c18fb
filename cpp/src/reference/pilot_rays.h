#pragma once

#include <cstdint>
#include <span>

#include "penumbra/control.h"
#include "penumbra/view.h"
#include "reference/ray_scene.h"

namespace penumbra {

inline constexpr int kPilotRadius = 2;  ///< pixels

/// Which of the listed pixels may lie in a penumbra, by one ray each in place of a map's edges: the pixels of a 4 x 4
/// block aim at different parts of the light [Keller2001], and where all rays of the pixels up to kPilotRadius away
/// agree, V is taken to be what they found. That misses what none of them met: it is not right on average, unlike the
/// rays that follow.
///
/// @param listed      1 where V is asked; view.size() entries
/// @param open        set to 1 where V has to be found out, else 0; view.size() entries
/// @param visibility  set to 0 or 1 for each listed pixel, right where that is sure, and to -1 for the others;
///                    view.size() entries
/// @throws Cancelled
void find_penumbrae(const RayScene& rays, const View& view, const Light& light, std::span<const std::uint8_t> listed,
                    std::uint32_t seed, std::span<std::uint8_t> open, std::span<float> visibility, Control& control);

}  // namespace penumbra
