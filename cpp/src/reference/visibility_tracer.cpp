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
#include "reference/ray_batch.h"
#include "reference/receivers.h"
#include "reference/sampling.h"
#include "reference/vector_clones.h"

namespace penumbra {
namespace {

/// The cells of a run of samples, in the order in which they are cast, and once more from the beginning for as long as
/// a packet: 16 consecutive rays then find their cells in a row wherever they start.
struct Cells {
    std::vector<float> u, v, width, height;
    std::vector<std::uint32_t> index;  ///< of the sample in its pixel's random sequence
    int count = 0;

    void add(float new_u, float new_v, float new_width, float new_height, int new_index) {
        u.push_back(new_u);
        v.push_back(new_v);
        width.push_back(new_width);
        height.push_back(new_height);
        index.push_back(static_cast<std::uint32_t>(new_index));
    }
};

/// The samples [first, last) of `count`. With early-out any beginning of the order covers the light evenly, else the
/// order is row by row.
Cells make_cells(const TraceOptions& options, int count, int first, int last, bool one_dimensional) {
    Cells cells;
    cells.count = last - first;
    const Strata strata = make_strata(count, one_dimensional);
    // Steps near the golden section of a cycle without common divisor visit every cell once and evenly.
    int step = options.early_out ? std::max(1, static_cast<int>(0.6180339887 * count)) : 1;
    while (std::gcd(step, count) != 1) {
        ++step;
    }
    for (int i = 0; i < cells.count + kRayLanes; ++i) {
        const int sample = first + i % cells.count;
        if (options.pattern == SamplePattern::Random) {
            cells.add(0.0F, 0.0F, 1.0F, 1.0F, sample);
            continue;
        }
        const auto j = static_cast<std::size_t>(static_cast<std::int64_t>(sample) * step % count);
        cells.add(strata.u[j], strata.v[j], strata.width[j], strata.height[j], sample);
    }
    return cells;
}

/// Sample coordinates of 16 rays whose cells start at `first`.
PENUMBRA_VECTOR_CLONES void place_samples(const Cells& cells, int first, std::uint32_t base,
                                          const std::uint32_t* pixels, SampleLanes& samples) noexcept {
    const float* u = &cells.u[first];
    const float* v = &cells.v[first];
    const float* width = &cells.width[first];
    const float* height = &cells.height[first];
    const std::uint32_t* index = &cells.index[first];
    for (int i = 0; i < kRayLanes; ++i) {
        float a;
        float b;
        uniform_pair(sequence_key(pixels[i], base), index[i], a, b);
        samples.u[i] = u[i] + width[i] * a;
        samples.v[i] = v[i] + height[i] * b;
    }
}

/// One thread's workspace for a tile.
class TileTracer {
public:
    TileTracer(const RayScene& scene, const LightPoints& points, std::uint32_t seed)
        : batch_{scene}, points_{points}, base_{sequence_base(seed, 0)} {}

    /// Casts a single sample of every receiver of a tile, which lie in packets as rays want them, straight into V.
    void trace_one(const TileReceivers& receivers, const Cells& cells, std::span<float> visibility) noexcept {
        int done = 0;
        for (int first = 0; first < receivers.count(); first += kRayLanes) {
            place_samples(cells, 0, base_, receivers.load(first, lanes_), samples_);
            points_.aim(lanes_, samples_, batch_.next());
            batch_.added(std::min(kRayLanes, receivers.count() - first));
            if (batch_.full() || first + kRayLanes >= receivers.count()) {
                const int count = batch_.count();
                batch_.trace();
                for (int i = 0; i < count; ++i) {
                    visibility[receivers.pixel(done + i)] = static_cast<float>(batch_.seen(i));
                }
                done += count;
            }
        }
    }

    /// Adds the visible ones of the samples of `cells` of each listed receiver to `seen`.
    void trace(const TileReceivers& receivers, std::span<const std::uint16_t> listed, const Cells& cells,
               std::span<std::uint32_t> seen) {
        // Rays are numbered receiver by receiver, and packets are filled across receivers: no lane stays empty but in
        // the tile's last packet.
        std::size_t at = 0;
        int sample = 0;
        whole_ = -1;
        std::int64_t left = static_cast<std::int64_t>(listed.size()) * cells.count;
        while (left > 0) {
            const int lanes = static_cast<int>(std::min<std::int64_t>(kRayLanes, left));
            const int first_sample = sample;
            for (int lane = 0; lane < lanes;) {
                const std::uint16_t owner = listed[at];
                const int run = std::min(lanes - lane, cells.count - sample);
                fill(receivers, owner, lane, run);
                lane += run;
                sample += run;
                if (sample == cells.count) {
                    sample = 0;
                    ++at;
                }
            }
            if (lanes < kRayLanes) {  // idle lanes repeat a ray that is none
                fill(receivers, listed.back(), lanes, kRayLanes - lanes);
            }
            place_samples(cells, first_sample, base_, pixels_.data(), samples_);
            points_.aim(lanes_, samples_, batch_.next());
            batch_.added(lanes);
            left -= lanes;
            if (batch_.full() || left == 0) {
                flush(seen);
            }
        }
    }

private:
    void fill(const TileReceivers& receivers, std::uint16_t owner, int lane, int run) noexcept {
        std::fill_n(&owners_[static_cast<std::size_t>(batch_.count()) + lane], run, owner);
        if (run < kRayLanes) {
            fill_lanes(receivers[owner], lane, lane + run);
            whole_ = -1;
        } else if (whole_ != owner) {  // else the lanes hold it already: many rays per pixel
            fill_lanes(receivers[owner], 0, kRayLanes);
            whole_ = owner;
        }
    }

    PENUMBRA_INLINE void fill_lanes(const Receiver& receiver, int from, int to) noexcept {
        for (int i = from; i < to; ++i) {
            lanes_.px[i] = receiver.position_an.x;
            lanes_.py[i] = receiver.position_an.y;
            lanes_.pz[i] = receiver.position_an.z;
            lanes_.nx[i] = receiver.normal.x;
            lanes_.ny[i] = receiver.normal.y;
            lanes_.nz[i] = receiver.normal.z;
            lanes_.offset[i] = receiver.offset;
            pixels_[i] = receiver.pixel;
        }
    }

    void flush(std::span<std::uint32_t> seen) noexcept {
        const int count = batch_.count();
        batch_.trace();
        for (int i = 0; i < count; ++i) {
            seen[owners_[i]] += batch_.seen(i);
        }
    }

    RayBatch batch_;
    const LightPoints& points_;
    std::uint32_t base_;
    ReceiverLanes lanes_{};
    SampleLanes samples_{};
    alignas(64) std::array<std::uint32_t, kRayLanes> pixels_{};
    std::array<std::uint16_t, RayBatch::kCapacity> owners_{};
    int whole_ = -1;  ///< the receiver that fills all lanes, if one does
};

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
    const int count = points.single_point() ? 1 : options.rays_per_pixel;
    const int first_count = options.early_out ? std::min(count, options.early_out_rays) : count;
    const Cells first = make_cells(options, count, 0, first_count, points.one_dimensional());
    const Cells rest =
        first_count < count ? make_cells(options, count, first_count, count, points.one_dimensional()) : Cells{};
    const Tiles tiles{rays, view};
    std::atomic<std::uint64_t> cast{0};
    std::atomic<std::int64_t> tiles_done{0};

    parallel_for(
        tiles.count(), tiles_per_piece(count),
        [&](std::int64_t begin, std::int64_t end) {
            TileTracer tracer{rays, points, options.seed};
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
