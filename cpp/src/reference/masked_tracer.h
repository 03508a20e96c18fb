#pragma once

#include <cstdint>
#include <span>

#include "penumbra/control.h"
#include "penumbra/view.h"
#include "reference/ray_scene.h"

namespace penumbra {

struct MaskedTraceOptions {
    int rays = 64;         ///< >= 1: of a pixel in the penumbra; a light without extent gets 1
    int pilot_rays = 16;   ///< >= 1: of every listed pixel, before that
    bool adaptive = true;  ///< false: `rays` and the pilot's for every listed pixel
    std::uint32_t seed = 1;
};

struct MaskedTraceCounts {
    std::uint64_t rays = 0;
    std::uint64_t pixels = 0;       ///< that got a pilot
    std::uint64_t full_pixels = 0;  ///< that got all rays
};

/// V of some pixels by shadow rays, whose number follows what is found around them.
///
/// Every listed pixel casts a pilot of stratified rays. Where the pilots of the pixels around it (not its own) and the
/// classes of those not listed agree that all is lit or all dark, that is all; else it casts `rays` more. Both
/// estimates are kept, weighted by count^(3/2) (lines: count^2), which is by the inverse of their variances. A pixel's
/// own rays never decide how many it gets nor how they are weighted, so V is unbiased.
///
/// @param listed      1 where V is asked
/// @param visibility  view.size() entries; those not listed are read (as V around the others) and left alone
/// @throws Cancelled
MaskedTraceCounts trace_masked(const RayScene& rays, const View& view, const Light& light,
                               std::span<const std::uint8_t> listed, const MaskedTraceOptions& options,
                               std::span<float> visibility, Control& control);

}  // namespace penumbra
