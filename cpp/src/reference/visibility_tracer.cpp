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
#include "reference/sampling.h"

namespace penumbra {
namespace {

/// Cells in the order in which they are sampled.
struct Cells {
    std::vector<float> u, v, width, height;
};

/// @param spread  any beginning of the order covers the light evenly (for early-out) instead of row by row
Cells make_cells(const TraceOptions& options, int count, bool one_dimensional) {
    if (options.pattern == SamplePattern::Random) {
        const auto n = static_cast<std::size_t>(count);
        return {std::vector<float>(n, 0.0F), std::vector<float>(n, 0.0F), std::vector<float>(n, 1.0F),
                std::vector<float>(n, 1.0F)};
    }
    const Strata strata = make_strata(count, one_dimensional);
    if (!options.early_out) {
        return {strata.u, strata.v, strata.width, strata.height};
    }
    // Steps near the golden section of a cycle without common divisor visit every cell once and evenly.
    int step = std::max(1, static_cast<int>(0.6180339887 * count));
    while (std::gcd(step, count) != 1) {
        ++step;
    }
    Cells cells;
    for (int i = 0; i < count; ++i) {
        const auto j = static_cast<std::size_t>(static_cast<std::int64_t>(i) * step % count);
        cells.u.push_back(strata.u[j]);
        cells.v.push_back(strata.v[j]);
        cells.width.push_back(strata.width[j]);
        cells.height.push_back(strata.height[j]);
    }
    return cells;
}

/// One thread's workspace for a tile.
class TileTracer {
public:
    TileTracer(const RayScene& scene, const LightPoints& points, const Cells& cells, std::uint32_t seed)
        : scene_{scene}, points_{points}, cells_{cells}, seed_{seed} {
        std::fill(std::begin(rays_.time), std::end(rays_.time), 0.0F);
        std::fill(std::begin(rays_.mask), std::end(rays_.mask), ~0U);
        std::fill(std::begin(rays_.id), std::end(rays_.id), 0U);
        std::fill(std::begin(rays_.flags), std::end(rays_.flags), 0U);
    }

    /// Adds the visible ones of the samples [first, last) of each listed receiver to `seen`.
    void trace(std::span<const Receiver> receivers, std::span<const std::uint16_t> listed, int first, int last,
               std::span<std::uint32_t> seen) {
        const int per_receiver = last - first;
        // Rays are numbered receiver by receiver, and packets are filled across receivers: no lane stays empty but in
        // the tile's last packet.
        std::size_t at = 0;
        int sample = first;
        std::array<std::uint16_t, kRayLanes> owner{};
        std::int64_t left = static_cast<std::int64_t>(listed.size()) * per_receiver;
        while (left > 0) {
            const int lanes = static_cast<int>(std::min<std::int64_t>(kRayLanes, left));
            int lane = 0;
            while (lane < lanes) {
                const std::uint16_t index = listed[at];
                const int run = std::min(lanes - lane, last - sample);
                fill(receivers[index], index, sample, lane, run, owner);
                lane += run;
                sample += run;
                if (sample == last) {
                    sample = first;
                    ++at;
                }
            }
            for (; lane < kRayLanes; ++lane) {  // idle lanes repeat the first ray, switched off
                fill(receivers[owner[0]], owner[0], first, lane, 1, owner);
            }
            shoot(lanes, owner, seen);
            left -= lanes;
        }
    }

private:
    void fill(const Receiver& receiver, std::uint16_t index, int sample, int lane, int run,
              std::array<std::uint16_t, kRayLanes>& owner) noexcept {
        const std::uint32_t key = sequence_key(receiver.pixel, seed_, 0);
        for (int i = 0; i < run; ++i) {
            const int to = lane + i;
            owner[to] = index;
            lanes_.px[to] = receiver.position_an.x;
            lanes_.py[to] = receiver.position_an.y;
            lanes_.pz[to] = receiver.position_an.z;
            lanes_.nx[to] = receiver.normal.x;
            lanes_.ny[to] = receiver.normal.y;
            lanes_.nz[to] = receiver.normal.z;
            lanes_.offset[to] = receiver.offset;
            float a;
            float b;
            uniform_pair(key, static_cast<std::uint32_t>(sample + i), a, b);
            samples_.u[to] = cells_.u[sample + i] + cells_.width[sample + i] * a;
            samples_.v[to] = cells_.v[sample + i] + cells_.height[sample + i] * b;
        }
    }

    void shoot(int lanes, const std::array<std::uint16_t, kRayLanes>& owner, std::span<std::uint32_t> seen) noexcept {
        points_.aim(lanes_, samples_, rays_);
        alignas(64) int valid[kRayLanes];
        for (int i = 0; i < kRayLanes; ++i) {
            valid[i] = i < lanes ? -1 : 0;
        }
        scene_.occluded(valid, rays_);
        for (int i = 0; i < lanes; ++i) {
            seen[owner[i]] += rays_.tfar[i] >= 0.0F ? 1U : 0U;
        }
    }

    const RayScene& scene_;
    const LightPoints& points_;
    const Cells& cells_;
    std::uint32_t seed_;
    ReceiverLanes lanes_{};
    SampleLanes samples_{};
    RayPacket rays_{};
};

}  // namespace

std::uint64_t trace_visibility(const RayScene& rays, const Scene&, const View& view, const Light& light,
                               std::span<const std::uint8_t> mask, const TraceOptions& options,
                               std::span<float> visibility, Control& control) {
    PENUMBRA_ASSERT(mask.size() == view.size() && visibility.size() == view.size());
    PENUMBRA_ASSERT(options.rays_per_pixel >= 1 && options.early_out_rays >= 1);
    std::fill(visibility.begin(), visibility.end(), 1.0F);
    if (rays.empty() || !light.casts_shadow) {
        return 0;
    }
    const LightPoints points{light, rays.frame()};
    const int count = points.single_point() ? 1 : options.rays_per_pixel;
    const int first_count = options.early_out ? std::min(count, options.early_out_rays) : count;
    const Cells cells = make_cells(options, count, points.one_dimensional());
    const Tiles tiles{view};
    std::atomic<std::uint64_t> cast{0};
    std::atomic<std::int64_t> tiles_done{0};

    parallel_for(
        tiles.count(), 1,
        [&](std::int64_t begin, std::int64_t end) {
            TileTracer tracer{rays, points, cells, options.seed};
            std::vector<Receiver> receivers;
            std::vector<std::uint16_t> listed;
            std::vector<std::uint32_t> seen;
            for (std::int64_t tile = begin; tile < end; ++tile) {
                tiles.collect(rays, view, mask, tile, receivers);
                listed.resize(receivers.size());
                std::iota(listed.begin(), listed.end(), std::uint16_t{0});
                seen.assign(receivers.size(), 0);
                tracer.trace(receivers, listed, 0, first_count, seen);
                cast += listed.size() * static_cast<std::size_t>(first_count);
                std::vector<int> divisor(receivers.size(), first_count);
                if (first_count < count) {
                    std::erase_if(listed, [&](std::uint16_t i) {
                        return seen[i] == 0 || seen[i] == static_cast<std::uint32_t>(first_count);
                    });
                    tracer.trace(receivers, listed, first_count, count, seen);
                    cast += listed.size() * static_cast<std::size_t>(count - first_count);
                    for (const std::uint16_t i : listed) {
                        divisor[i] = count;
                    }
                }
                for (std::size_t i = 0; i < receivers.size(); ++i) {
                    visibility[receivers[i].pixel] =
                        static_cast<float>(static_cast<double>(seen[i]) / static_cast<double>(divisor[i]));
                }
                const std::int64_t done = ++tiles_done;
                control.report(static_cast<float>(done) / static_cast<float>(tiles.count()));
            }
        },
        control);
    return cast;
}

}  // namespace penumbra
