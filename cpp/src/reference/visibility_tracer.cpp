#include "reference/visibility_tracer.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <cstddef>
#include <numeric>
#include <vector>

#include "base/assert.h"
#include "base/parallel.h"
#include "reference/light_points.h"
#include "reference/receivers.h"
#include "reference/tile_tracer.h"

namespace penumbra {
namespace {

/// Pixels of a piece of parallel work: few rays per pixel make large pieces, many rays a single tile.
std::int64_t tiles_per_piece(int rays_per_pixel) noexcept {
    return std::clamp(16 / rays_per_pixel, 1, 16);
}

}  // namespace

std::uint64_t trace_visibility(const RayScene& rays, const Scene& /*scene*/, const View& view, const Light& light,
                               std::span<const std::uint8_t> mask, const TraceOptions& options,
                               std::span<float> visibility, Control& control) {
    PENUMBRA_ASSERT(mask.size() == view.size() && visibility.size() == view.size());
    PENUMBRA_ASSERT(options.rays_per_pixel >= 1 && options.early_out_rays >= 1);
    if (rays.empty() || !light.casts_shadow) {
        std::ranges::fill(visibility, 1.0F);
        return 0;
    }
    const LightPoints points{light, rays.frame()};
    const int count = points.single_point() && !options.repeat_single_point ? 1 : options.rays_per_pixel;
    const int first_count = options.early_out ? std::min(count, options.early_out_rays) : count;
    const Cells first = make_cells(options.pattern, options.early_out, count, 0, first_count, points.one_dimensional());
    const Cells rest = first_count < count ? make_cells(options.pattern, options.early_out, count, first_count, count,
                                                        points.one_dimensional())
                                           : Cells{};
    const Tiles tiles{rays, view};
    std::atomic<std::uint64_t> cast{0};
    std::atomic<std::int64_t> tiles_done{0};

    parallel_for(
        tiles.count(), tiles_per_piece(count),
        [&](std::int64_t begin, std::int64_t end) {
            TileTracer tracer{rays, points, options.seed, 0};
            TileReceivers receivers;
            std::vector<std::uint16_t> listed;
            std::array<std::uint32_t, TileReceivers::kCapacity> seen;
            std::uint64_t cast_here = 0;
            for (std::int64_t tile = begin; tile < end; ++tile) {
                control.check();
                tiles.collect(mask, tile, receivers);
                tiles.prefetch(tile + 1);
                if (receivers.count() < TileReceivers::kCapacity) {
                    tiles.fill(visibility, tile, 1.0F);
                }
                cast_here += static_cast<std::uint64_t>(receivers.count()) * static_cast<std::uint64_t>(first_count);
                if (count == 1) {
                    tracer.trace_one(receivers, first, visibility);
                    continue;
                }
                listed.resize(static_cast<std::size_t>(receivers.count()));
                std::iota(listed.begin(), listed.end(), std::uint16_t{0});
                seen.fill(0);
                tracer.trace(receivers, listed, first, seen);
                // Counts are whole and below 2^24, so these quotients are rounded once.
                for (const std::uint16_t i : listed) {
                    visibility[receivers.pixel(i)] = static_cast<float>(seen[i]) / static_cast<float>(first_count);
                }
                if (first_count < count) {
                    std::erase_if(listed, [&](std::uint16_t i) {
                        return seen[i] == 0 || seen[i] == static_cast<std::uint32_t>(first_count);
                    });
                    tracer.trace(receivers, listed, rest, seen);
                    cast_here += listed.size() * static_cast<std::size_t>(count - first_count);
                    for (const std::uint16_t i : listed) {
                        visibility[receivers.pixel(i)] = static_cast<float>(seen[i]) / static_cast<float>(count);
                    }
                }
            }
            cast += cast_here;
            const std::int64_t done = tiles_done += end - begin;
            control.report(static_cast<float>(done) / static_cast<float>(tiles.count()));
        },
        control);
    return cast;
}

}  // namespace penumbra
