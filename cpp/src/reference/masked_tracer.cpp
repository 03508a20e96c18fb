#include "reference/masked_tracer.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <numeric>
#include <vector>

#include "base/assert.h"
#include "base/parallel.h"
#include "reference/light_points.h"
#include "reference/receivers.h"
#include "reference/tile_tracer.h"
#include "reference/visibility_tracer.h"

namespace penumbra {
namespace {

constexpr std::uint32_t kPilotStream = 3;
constexpr std::uint32_t kFinalStream = 4;
constexpr int kTilesPerPiece = 4;

/// Calls work(tracer, receivers, listed, seen) for every tile that has listed pixels.
template <class Work>
void for_tiles(const RayScene& rays, const View& view, const LightPoints& points, std::span<const std::uint8_t> listed,
               std::uint32_t seed, std::uint32_t stream, Control& control, const Work& work) {
    const Tiles tiles{rays, view};
    parallel_for(
        tiles.count(), kTilesPerPiece,
        [&](std::int64_t begin, std::int64_t end) {
            TileTracer tracer{rays, points, seed, stream};
            TileReceivers receivers;
            std::array<std::uint32_t, TileReceivers::kCapacity> seen;
            for (std::int64_t tile = begin; tile < end; ++tile) {
                control.check();
                tiles.collect(listed, tile, receivers);
                if (receivers.count() > 0) {
                    seen.fill(0);
                    work(tracer, receivers, seen);
                }
            }
        },
        control);
}

/// Whether the pixels around, not this one, leave it open whether all is lit or all dark.
bool penumbra_around(const View& view, std::span<const float> visibility, std::uint32_t pixel) noexcept {
    const int x = static_cast<int>(pixel % static_cast<std::uint32_t>(view.width));
    const int y = static_cast<int>(pixel / static_cast<std::uint32_t>(view.width));
    float least = 2.0F;
    float most = -1.0F;
    for (int ny = std::max(0, y - 1); ny <= std::min(view.height - 1, y + 1); ++ny) {
        for (int nx = std::max(0, x - 1); nx <= std::min(view.width - 1, x + 1); ++nx) {
            const std::size_t i = static_cast<std::size_t>(ny) * static_cast<std::size_t>(view.width) + nx;
            if (i != pixel && view.hit(i)) {
                least = std::min(least, visibility[i]);
                most = std::max(most, visibility[i]);
            }
        }
    }
    return least != most || (most > 0.0F && most < 1.0F) || most < 0.0F;
}

}  // namespace

MaskedTraceCounts trace_masked(const RayScene& rays, const View& view, const Light& light,
                               std::span<const std::uint8_t> listed, const MaskedTraceOptions& options,
                               std::span<float> visibility, Control& control) {
    PENUMBRA_ASSERT(listed.size() == view.size() && visibility.size() == view.size());
    PENUMBRA_ASSERT(options.rays >= 1 && options.pilot_rays >= 1);
    const LightPoints points{light, rays.frame()};
    const bool line = points.one_dimensional();
    // Few rays: the pilot is all.
    const bool pilot_only = points.single_point() || options.rays <= options.pilot_rays;
    const int pilot_count = points.single_point() ? 1 : std::min(options.rays, options.pilot_rays);
    const Cells pilot = make_cells(SamplePattern::Stratified, false, pilot_count, 0, pilot_count, line);
    std::atomic<std::uint64_t> pixels{0};
    std::vector<float> pilot_mean(visibility.begin(), visibility.end());
    for_tiles(rays, view, points, listed, options.seed, kPilotStream, control,
              [&](TileTracer& tracer, const TileReceivers& receivers, std::span<std::uint32_t> seen) {
                  std::vector<std::uint16_t> all(static_cast<std::size_t>(receivers.count()));
                  std::iota(all.begin(), all.end(), std::uint16_t{0});
                  tracer.trace(receivers, all, pilot, seen);
                  for (const std::uint16_t i : all) {
                      pilot_mean[receivers.pixel(i)] = static_cast<float>(seen[i]) / static_cast<float>(pilot_count);
                  }
                  pixels += all.size();
              });
    MaskedTraceCounts counts{pixels * static_cast<std::uint64_t>(pilot_count), pixels, 0};
    std::ranges::copy(pilot_mean, visibility.begin());
    if (pilot_only) {
        return counts;
    }

    const double power = line ? 2.0 : 1.5;
    const double pilot_weight = std::pow(pilot_count, power);
    const double final_weight = std::pow(options.rays, power);
    const auto share = static_cast<float>(pilot_weight / (pilot_weight + final_weight));
    const Cells rest = make_cells(SamplePattern::Stratified, false, options.rays, 0, options.rays, line);
    std::atomic<std::uint64_t> full{0};
    for_tiles(rays, view, points, listed, options.seed, kFinalStream, control,
              [&](TileTracer& tracer, const TileReceivers& receivers, std::span<std::uint32_t> seen) {
                  std::vector<std::uint16_t> open;
                  for (std::uint16_t i = 0; i < receivers.count(); ++i) {
                      if (!options.adaptive || penumbra_around(view, pilot_mean, receivers.pixel(i))) {
                          open.push_back(i);
                      }
                  }
                  if (open.empty()) {
                      return;
                  }
                  tracer.trace(receivers, open, rest, seen);
                  for (const std::uint16_t i : open) {
                      const float mean = static_cast<float>(seen[i]) / static_cast<float>(options.rays);
                      const std::uint32_t pixel = receivers.pixel(i);
                      visibility[pixel] = mean + share * (pilot_mean[pixel] - mean);
                  }
                  full += open.size();
              });
    counts.full_pixels = full;
    counts.rays += full * static_cast<std::uint64_t>(options.rays);
    return counts;
}

}  // namespace penumbra
