#include "reference/pilot_rays.h"

#include <algorithm>

#include "base/assert.h"
#include "reference/for_tiles.h"
#include "reference/mixed_pixels.h"
#include "reference/visibility_tracer.h"

namespace penumbra {
namespace {

/// Of random numbers; trace_masked() has those up to 5.
constexpr std::uint32_t kPilotStream = 6;
constexpr int kPilotStrata = 16;  // of the light: as many as a 4 x 4 block has pixels

}  // namespace

void find_penumbrae(const RayScene& rays, const View& view, const Light& light, std::span<const std::uint8_t> listed,
                    std::uint32_t seed, std::span<std::uint8_t> open, std::span<float> visibility, Control& control) {
    PENUMBRA_ASSERT(listed.size() == view.size() && visibility.size() == view.size() && open.size() == view.size());
    const LightPoints points{light, rays.frame()};
    std::ranges::fill(visibility, -1.0F);
    // The lanes of a packet are a block of pixels, and each lane has a stratum of its own.
    const Cells cells =
        make_cells(SamplePattern::Stratified, false, kPilotStrata, 0, kPilotStrata, points.one_dimensional());
    for_tiles(
        rays, view, points, listed, seed, kPilotStream, control,
        [&](TileTracer& tracer, const TileReceivers& receivers) { tracer.trace_one(receivers, cells, visibility); });
    std::ranges::transform(listed, open.begin(), [](std::uint8_t l) { return static_cast<std::uint8_t>(l != 0); });
    keep_mixed(view, visibility, kPilotRadius, open, control);
}

}  // namespace penumbra
