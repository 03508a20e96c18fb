#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <glm/glm.hpp>
#include <limits>
#include <span>
#include <vector>

#include "penumbra/view.h"
#include "reference/ray_scene.h"

namespace penumbra {

/// Offset of a ray's start in float32 roundings of the coordinates involved.
///
/// What can be wrong is the height of the point above its triangle: the View's position and its conversion round once
/// each, Embree's robust test subtracts origin from vertex (once) and, through an instance, transforms the origin (up
/// to kLargestCondition times a rounding). With the worst orientation (factor sqrt 3) that is some 10 roundings in the
/// worst case. Measured on grazing lit spheres, cubes, turned planes and instances over all scales and places
/// (visibility_tracer_test.cpp): acne at 1.0, none from 1.5 on. 16 leaves room and is still 2e-6 of the scene's size.
inline constexpr float kOffsetRoundings = 16.0F;

/// Points that ask for light, one per lane, in anchor units.
struct alignas(64) ReceiverLanes {
    float px[kRayLanes], py[kRayLanes], pz[kRayLanes];
    float nx[kRayLanes], ny[kRayLanes], nz[kRayLanes];  ///< unit geometric normal: which side of the surface it is
    float sx[kRayLanes], sy[kRayLanes], sz[kRayLanes];  ///< unit shading normal: for weights only
    float offset[kRayLanes];                            ///< how far off the surface a ray starts
};

/// One point that asks for light.
struct Receiver {
    glm::vec3 position_an;
    glm::vec3 normal;  ///< geometric
    float offset;
    std::uint32_t pixel;
};

/// Makes receivers of the pixels of a view.
class ReceiverMaker {
public:
    ReceiverMaker(const RayScene& scene, const View& view) noexcept;
    /// The receiver of a pixel that has geometry.
    [[nodiscard]] Receiver operator()(std::size_t pixel) const noexcept {
        const glm::dvec3 from_eye_an = glm::dvec3(view_.position_cr[pixel]) * per_unit_;
        const glm::vec3 position_an{eye_an_ + from_eye_an};
        // A far camera rounds positions more coarsely than the scene's own coordinates do, and so does even float64
        // where a tiny scene lies far from the world's origin.
        const float size = std::max({largest(position_an), largest(glm::vec3(from_eye_an)), world_size_an_,
                                     scene_.coordinate_bound(view_.instance[pixel], view_.triangle[pixel])});
        return {position_an, view_.normal_ws[pixel], offset_per_size() * size, static_cast<std::uint32_t>(pixel)};
    }

private:
    static float largest(const glm::vec3& v) noexcept {
        return std::max({std::abs(v.x), std::abs(v.y), std::abs(v.z)});
    }
    static constexpr float offset_per_size() noexcept {
        return kOffsetRoundings * std::numeric_limits<float>::epsilon();
    }

    const RayScene& scene_;
    const View& view_;
    double per_unit_;  ///< 1 / unit of the anchor frame
    glm::dvec3 eye_an_;
    float world_size_an_;  ///< what float64 rounds of world coordinates, as a size that float32 would round so
};

/// Pixels of a tile of 64 x 4, 4 x 4 blocks one after the other: 16 pixels in a row are neighbours, so that the rays of
/// a packet stay close to each other. The tile is flat because the View lies in memory row by row: with 16 x 16 pixels
/// reading it took a quarter of the time at one ray per pixel.
class Tiles {
public:
    static constexpr int kWidth = 64;
    static constexpr int kHeight = 4;
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
