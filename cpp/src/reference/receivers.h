#pragma once

#include <cstdint>
#include <glm/glm.hpp>
#include <span>
#include <vector>

#include "penumbra/view.h"
#include "reference/ray_scene.h"

namespace penumbra {

/// Points that ask for light, one per lane, in anchor units.
struct alignas(64) ReceiverLanes {
    float px[kRayLanes], py[kRayLanes], pz[kRayLanes];
    float nx[kRayLanes], ny[kRayLanes], nz[kRayLanes];  ///< unit geometric normal
    float offset[kRayLanes];                            ///< how far off the surface a ray starts
};

/// One point that asks for light.
struct Receiver {
    glm::vec3 position_an;
    glm::vec3 normal;
    float offset;
    std::uint32_t pixel;
};

/// Makes receivers of the pixels of a view.
class ReceiverMaker {
public:
    ReceiverMaker(const RayScene& scene, const View& view) noexcept;
    /// The receiver of a pixel that has geometry.
    [[nodiscard]] Receiver operator()(std::size_t pixel) const noexcept;

private:
    const RayScene& scene_;
    const View& view_;
    double per_unit_;  ///< 1 / unit of the anchor frame
    glm::dvec3 eye_an_;
    float world_size_an_;  ///< what float64 rounds of world coordinates, as a size that float32 would round so
};

/// Pixels of a 16 x 16 tile, 4 x 4 blocks one after the other: 16 pixels in a row are neighbours, so that the rays of
/// a packet stay close to each other.
class Tiles {
public:
    static constexpr int kSide = 16;
    Tiles(const RayScene& scene, const View& view) noexcept;
    [[nodiscard]] std::int64_t count() const noexcept { return static_cast<std::int64_t>(across_) * down_; }
    /// Appends the receivers of the tile's pixels whose mask is not 0; clears `out` first.
    void collect(std::span<const std::uint8_t> mask, std::int64_t tile, std::vector<Receiver>& out) const;

private:
    ReceiverMaker make_;
    const View& view_;
    int across_, down_;
};

}  // namespace penumbra
