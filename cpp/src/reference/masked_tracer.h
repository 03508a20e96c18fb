#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "penumbra/control.h"
#include "penumbra/view.h"
#include "reference/ray_scene.h"

namespace penumbra {

struct MaskedTraceOptions {
    int rays = 256;       ///< >= 1: strata of the light that count where its visibility changes
    int first_rays = 16;  ///< >= 1: of every listed pixel, before that
    int share = 0;        ///< >= 0: pixels around whose first rays count too, radius; 0: each stands alone
    std::uint32_t seed = 1;
};

struct MaskedTraceCounts {
    std::uint64_t rays = 0;
    std::uint64_t pixels = 0;       ///< that were listed
    std::uint64_t full_pixels = 0;  ///< that got more than the first rays
};

/// V of some pixels by shadow rays that go where they are needed: to pixels, and to parts of the light, around which
/// others find visibility to change.
///
/// 1. Every listed pixel casts `first_rays`, stratified. Where those of the pixels around it, within two pixels, and
/// the
///    V of those not listed agree that all is lit or all dark, that is all.
/// 2. The others cast 64 rays, one in each of 8 x 8 strata (lines: 64 intervals).
/// 3. A stratum in which, or beside which, the eight pixels around disagree is cut into rays / 64, with a ray in each.
///
/// With `share` there is another step between 1 and 2: V is the plane fitted to what all pixels of the same surface
/// around found, and only those go on whose penumbra is too narrow for that (steeper than kSteep per pixel). The pixels
/// of a 4 x 4 block then cast their first rays to different parts of the light [Keller2001]. Where step 2 is the last
/// and both counts are powers of two, first rays count there as well.
///
/// Without it a pixel's own rays never decide how many it gets nor where, so V is unbiased: it is the mean over strata
/// of their own means, and the strata are weighted by their size alone. With `rays` up to 64 there are steps 1 and 2
/// alone, with that many strata; with no more than `first_rays`, step 1 alone.
///
/// @param listed      1 where V is asked
/// @param visibility  view.size() entries; those not listed are left alone, and read where they are not below 0, as V
///                    around the others
/// @throws Cancelled
MaskedTraceCounts trace_masked(const RayScene& rays, const View& view, const Light& light,
                               std::span<const std::uint8_t> listed, const MaskedTraceOptions& options,
                               std::span<float> visibility, Control& control);

}  // namespace penumbra
