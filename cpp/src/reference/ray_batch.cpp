#include "reference/ray_batch.h"

#include <algorithm>

namespace penumbra {

void RayBatch::trace() noexcept {
    if (streams_) {
        for (int p = 0; p < packet_count_; ++p) {
            const RayPacket& packet = packets_[p];
            embree::Ray* ray = &rays_[p * kRayLanes];
            for (int i = 0; i < kRayLanes; ++i, ++ray) {
                ray->org_x = packet.org_x[i];
                ray->org_y = packet.org_y[i];
                ray->org_z = packet.org_z[i];
                ray->tnear = packet.tnear[i];
                ray->dir_x = packet.dir_x[i];
                ray->dir_y = packet.dir_y[i];
                ray->dir_z = packet.dir_z[i];
                ray->tfar = packet.tfar[i];
            }
        }
        scene_.occluded_stream(rays_.data(), static_cast<unsigned>(count_));
        for (int i = 0; i < count_; ++i) {
            seen_[i] = rays_[i].tfar >= 0.0F ? 1U : 0U;
        }
    } else {
        for (int p = 0; p < packet_count_; ++p) {
            const int lanes = std::min(kRayLanes, count_ - p * kRayLanes);
            alignas(64) int valid[kRayLanes];
            for (int i = 0; i < kRayLanes; ++i) {
                valid[i] = i < lanes ? -1 : 0;
            }
            scene_.occluded(valid, packets_[p]);
            for (int i = 0; i < kRayLanes; ++i) {
                seen_[p * kRayLanes + i] = packets_[p].tfar[i] >= 0.0F ? 1U : 0U;
            }
        }
    }
    packet_count_ = 0;
    count_ = 0;
}

}  // namespace penumbra
