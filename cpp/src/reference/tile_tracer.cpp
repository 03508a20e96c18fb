#include "reference/tile_tracer.h"

#include <algorithm>
#include <cstddef>
#include <numeric>

#include "reference/sampling.h"
#include "reference/vector_clones.h"
#include "reference/visibility_tracer.h"

namespace penumbra {
namespace {

/// Sample coordinates of 16 rays in the cells given.
PENUMBRA_VECTOR_CLONES void place_samples(const float* u, const float* v, const float* width, const float* height,
                                          const std::uint32_t* index, std::uint32_t base, const std::uint32_t* pixels,
                                          SampleLanes& samples) noexcept {
    for (int i = 0; i < kRayLanes; ++i) {
        float a;
        float b;
        uniform_pair(sequence_key(pixels[i], base), index[i], a, b);
        samples.u[i] = u[i] + width[i] * a;
        samples.v[i] = v[i] + height[i] * b;
    }
}

/// Of rays whose cells start at `first`.
void place_samples(const Cells& cells, int first, std::uint32_t base, const std::uint32_t* pixels,
                   SampleLanes& samples) noexcept {
    place_samples(&cells.u[first], &cells.v[first], &cells.width[first], &cells.height[first], &cells.index[first],
                  base, pixels, samples);
}

void add(Cells& cells, float u, float v, float width, float height, int index) {
    cells.u.push_back(u);
    cells.v.push_back(v);
    cells.width.push_back(width);
    cells.height.push_back(height);
    cells.index.push_back(static_cast<std::uint32_t>(index));
}

}  // namespace

Cells make_cells(SamplePattern pattern, bool even_beginnings, int count, int first, int last, bool one_dimensional) {
    Cells cells;
    cells.count = last - first;
    const Strata strata = make_strata(count, one_dimensional);
    // Steps near the golden section of a cycle without common divisor visit every cell once and evenly.
    int step = even_beginnings ? std::max(1, static_cast<int>(0.6180339887 * count)) : 1;
    while (std::gcd(step, count) != 1) {
        ++step;
    }
    for (int i = 0; i < cells.count + kRayLanes; ++i) {
        const int sample = first + i % cells.count;
        if (pattern == SamplePattern::Random) {
            add(cells, 0.0F, 0.0F, 1.0F, 1.0F, sample);
            continue;
        }
        const auto j = static_cast<std::size_t>(static_cast<std::int64_t>(sample) * step % count);
        add(cells, strata.u[j], strata.v[j], strata.width[j], strata.height[j], sample);
    }
    return cells;
}

TileTracer::TileTracer(const RayScene& scene, const LightPoints& points, std::uint32_t seed, std::uint32_t stream)
    : batch_{scene}, points_{points}, base_{sequence_base(seed, stream)} {}

void TileTracer::trace_one(const TileReceivers& receivers, const Cells& cells, std::span<float> visibility) noexcept {
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

void TileTracer::trace(const TileReceivers& receivers, std::span<const std::uint16_t> listed, const Cells& cells,
                       std::span<std::uint32_t> seen) {
    // Rays are numbered receiver by receiver, and packets are filled across receivers: no lane stays empty but in the
    // tile's last packet.
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

void TileTracer::place_lanes() noexcept {
    place_samples(cell_u_.data(), cell_v_.data(), cell_width_.data(), cell_height_.data(), cell_index_.data(), base_,
                  pixels_.data(), samples_);
    points_.aim(lanes_, samples_, batch_.next());
}

void TileTracer::fill(const TileReceivers& receivers, std::uint16_t owner, int lane, int run) noexcept {
    std::fill_n(&owners_[static_cast<std::size_t>(batch_.count()) + lane], run, owner);
    if (run < kRayLanes) {
        fill_lanes(receivers[owner], lane, lane + run);
        whole_ = -1;
    } else if (whole_ != owner) {  // else the lanes hold it already: many rays per pixel
        fill_lanes(receivers[owner], 0, kRayLanes);
        whole_ = owner;
    }
}

void TileTracer::fill_lanes(const Receiver& receiver, int from, int to) noexcept {
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

void TileTracer::flush(std::span<std::uint32_t> seen) noexcept {
    const int count = batch_.count();
    batch_.trace();
    for (int i = 0; i < count; ++i) {
        seen[owners_[i]] += batch_.seen(i);
    }
}

}  // namespace penumbra
