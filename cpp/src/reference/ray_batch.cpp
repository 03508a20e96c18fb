#include "reference/ray_batch.h"

#include <algorithm>
#include <array>
#include <cstddef>

#include "reference/four_lanes.h"

namespace penumbra {

RayBatch::RayBatch(const RayScene& scene, bool streams) noexcept : scene_{scene}, streams_{streams} {
    for (int p = 0; p < (streams ? 1 : kPackets); ++p) {
        packets_[p] = {};
        packets_[p].mask.fill(~0U);
    }
    if (streams) {
        for (embree::Ray& ray : rays_) {
            ray = {};
            ray.mask = ~0U;
        }
    }
}

void RayBatch::append_to_stream() noexcept {
    const RayPacket& packet = packets_[0];
    embree::Ray* ray = &rays_[static_cast<std::size_t>(packet_count_) * kRayLanes];
    constexpr std::size_t kStride = sizeof(embree::Ray) / sizeof(float);
    constexpr std::size_t kDirection = offsetof(embree::Ray, dir_x) / sizeof(float);
    for (int i = 0; i < kRayLanes; i += 4, ray += 4) {
        auto* const numbers = reinterpret_cast<float*>(ray);  // of the ray as a whole, not of its first member
        interleave(&packet.org_x[i], &packet.org_y[i], &packet.org_z[i], &packet.tnear[i], numbers, kStride);
        interleave(&packet.dir_x[i], &packet.dir_y[i], &packet.dir_z[i], &packet.time[i], numbers + kDirection,
                   kStride);
        for (int k = 0; k < 4; ++k) {
            ray[k].tfar = packet.tfar[i + k];
        }
    }
}

void RayBatch::trace() noexcept {
    if (streams_) {
        scene_.occluded_stream(rays_.data(), static_cast<unsigned>(count_));
    } else {
        for (int p = 0; p < packet_count_; ++p) {
            const int lanes = std::min(kRayLanes, count_ - p * kRayLanes);
            alignas(64) std::array<int, kRayLanes> valid;
            for (int i = 0; i < kRayLanes; ++i) {
                valid[i] = i < lanes ? -1 : 0;
            }
            scene_.occluded(valid.data(), packets_[p]);
        }
    }
    packet_count_ = 0;
    count_ = 0;
}

}  // namespace penumbra
