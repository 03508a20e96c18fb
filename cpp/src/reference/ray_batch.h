#pragma once

#include <array>
#include <cstdint>

#include "reference/ray_scene.h"

namespace penumbra {

/// Collects occlusion rays, casts them together and tells which got through. Embree 3 gets them as a stream of single
/// rays, which it sorts by direction: 1.2 to 1.5 times as fast here as packets of 16 (ray_bench.cpp). Embree 4 has no
/// streams and gets packets.
class RayBatch {
public:
    static constexpr int kPackets = 16;
    static constexpr int kCapacity = kPackets * kRayLanes;

    explicit RayBatch(const RayScene& scene) noexcept : RayBatch{scene, scene.has_streams()} {}
    /// @param streams  false: packets though Embree has streams (for tests)
    RayBatch(const RayScene& scene, bool streams) noexcept;

    /// Room for the next 16 rays; write org, dir, tnear and tfar of all lanes, then call added().
    [[nodiscard]] RayPacket& next() noexcept { return packets_[streams_ ? 0 : packet_count_]; }
    /// @param lanes  how many of the packet's lanes are rays, the first ones; only the last packet before trace() may
    ///               have fewer than 16
    void added(int lanes) noexcept {
        if (streams_) {
            append_to_stream();
        }
        ++packet_count_;
        count_ += lanes;
    }
    [[nodiscard]] bool full() const noexcept { return packet_count_ == kPackets; }
    [[nodiscard]] int count() const noexcept { return count_; }

    /// Casts what was added and empties the batch; seen() is valid until next() is written to.
    void trace() noexcept;
    /// 1 if the i-th ray got through, else 0.
    [[nodiscard]] std::uint32_t seen(int i) const noexcept {
        const float tfar = streams_ ? rays_[i].tfar : packets_[i / kRayLanes].tfar[i % kRayLanes];
        return tfar >= 0.0F ? 1U : 0U;
    }

private:
    void append_to_stream() noexcept;

    const RayScene& scene_;
    bool streams_;
    int packet_count_ = 0;
    int count_ = 0;
    // One of the two is in use. Streams are filled packet by packet, so they need room for one packet only.
    alignas(64) std::array<RayPacket, kPackets> packets_;
    alignas(64) std::array<embree::Ray, kCapacity> rays_;
};

}  // namespace penumbra
