#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "reference/light_points.h"
#include "reference/ray_batch.h"
#include "reference/receivers.h"

namespace penumbra {

enum class SamplePattern;

/// The cells of a run of samples, in the order in which they are cast, and once more from the beginning for as long as
/// a packet: 16 consecutive rays then find their cells in a row wherever they start.
struct Cells {
    std::vector<float> u, v, width, height;
    std::vector<std::uint32_t> index;  ///< of the sample in its pixel's random sequence
    int count = 0;
};

/// The samples [first, last) of `count`.
/// @param even_beginnings  any beginning of the order covers the light evenly, else the order is row by row
[[nodiscard]] Cells make_cells(SamplePattern pattern, bool even_beginnings, int count, int first, int last,
                               bool one_dimensional);

/// One sample of one receiver of a tile, anywhere on the light.
struct CellRay {
    std::uint16_t receiver = 0;
    std::uint32_t index = 0;   ///< in its pixel's random sequence
    float u = 0.0F, v = 0.0F;  ///< lower left corner of the cell
    float width = 1.0F, height = 1.0F;
};

/// One thread's workspace for casting the samples of the receivers of a tile.
class TileTracer {
public:
    /// @param stream  keeps the random numbers of several passes over the same pixels apart
    TileTracer(const RayScene& scene, const LightPoints& points, std::uint32_t seed, std::uint32_t stream);

    /// Casts a single sample of every receiver of a tile, which lie in packets as rays want them, straight into V.
    void trace_one(const TileReceivers& receivers, const Cells& cells, std::span<float> visibility) noexcept;

    /// Adds the visible ones of the samples of `cells` of each listed receiver to `seen`, by the receiver's number.
    void trace(const TileReceivers& receivers, std::span<const std::uint16_t> listed, const Cells& cells,
               std::span<std::uint32_t> seen);

    /// Casts the samples that next(CellRay&) makes, until it returns false, and tells found(receiver, seen)
    /// of each in that order.
    template <class Next, class Found>
    void trace_cells(const TileReceivers& receivers, const Next& next, const Found& found) noexcept {
        lane_owner_.fill(-1);
        bool more = true;
        while (more) {
            int lanes = 0;
            CellRay ray;
            while (lanes < kRayLanes) {
                more = next(ray);
                if (!more) {
                    break;
                }
                set_lane(receivers, ray, lanes++);
            }
            for (int lane = lanes; lanes > 0 && lane < kRayLanes; ++lane) {  // idle lanes repeat a ray that is none
                set_lane(receivers, ray, lane);
            }
            if (lanes > 0) {
                place_lanes();
                batch_.added(lanes);
            }
            if (batch_.full() || (!more && batch_.count() > 0)) {
                const int count = batch_.count();
                batch_.trace();
                for (int i = 0; i < count; ++i) {
                    found(owners_[i], batch_.seen(i));
                }
            }
        }
    }

private:
    void set_lane(const TileReceivers& receivers, const CellRay& ray, int lane) noexcept {
        const auto at = static_cast<std::size_t>(batch_.count()) + static_cast<std::size_t>(lane);
        owners_[at] = ray.receiver;
        cell_u_[lane] = ray.u;
        cell_v_[lane] = ray.v;
        cell_width_[lane] = ray.width;
        cell_height_[lane] = ray.height;
        cell_index_[lane] = ray.index;
        if (lane_owner_[lane] != ray.receiver) {
            lane_owner_[lane] = ray.receiver;
            fill_lanes(receivers[ray.receiver], lane, lane + 1);
        }
    }
    void place_lanes() noexcept;
    void fill(const TileReceivers& receivers, std::uint16_t owner, int lane, int run) noexcept;
    void fill_lanes(const Receiver& receiver, int from, int to) noexcept;
    void flush(std::span<std::uint32_t> seen) noexcept;

    RayBatch batch_;
    const LightPoints& points_;
    std::uint32_t base_;
    ReceiverLanes lanes_{};
    SampleLanes samples_{};
    alignas(64) std::array<std::uint32_t, kRayLanes> pixels_{};
    std::array<std::uint16_t, RayBatch::kCapacity> owners_{};
    std::array<int, kRayLanes> lane_owner_{};
    alignas(64) std::array<float, kRayLanes> cell_u_{}, cell_v_{}, cell_width_{}, cell_height_{};
    alignas(64) std::array<std::uint32_t, kRayLanes> cell_index_{};
    int whole_ = -1;  ///< the receiver that fills all lanes, if one does
};

}  // namespace penumbra
