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

private:
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
    int whole_ = -1;  ///< the receiver that fills all lanes, if one does
};

}  // namespace penumbra
