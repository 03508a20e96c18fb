#pragma once

#include <array>
#include <cstdint>
#include <glm/glm.hpp>
#include <span>

#include "penumbra/view.h"
#include "reference/four_lanes.h"
#include "reference/ray_scene.h"

namespace penumbra {

/// Offset of a ray's start in float32 roundings of the coordinates involved.
///
/// What can be wrong is the height of the point above its triangle: the View's position and its conversion round once
/// each, Embree's robust test subtracts origin from vertex (once) and, through an instance, transforms the origin (up
/// to kLargestCondition times a rounding). Measured on grazing lit spheres, cubes, turned planes and instances over all
/// scales and places (visibility_tracer_test.cpp): acne at 1.0, none from 1.5 on. What is too much costs truth: the
/// lifted point sees past an edge that is close to it. At 16 a dozen pixels of the example `courtyard` were 0.005 to
/// 0.015 too bright, at 4 none could be told from noise.
inline constexpr float kOffsetRoundings = 4.0F;

/// Points that ask for light, one per lane, in anchor units.
struct alignas(64) ReceiverLanes {
    using Floats = std::array<float, kRayLanes>;
    Floats px, py, pz;
    Floats nx, ny, nz;  ///< unit geometric normal: which side of the surface it is
    Floats sx, sy, sz;  ///< unit shading normal: for weights only
    Floats offset;      ///< how far off the surface a ray starts
};

/// One point that asks for light.
struct Receiver {
    glm::vec3 position_an;
    glm::vec3 normal;  ///< geometric
    float offset;
    std::uint32_t pixel;
};

/// The receivers of one tile, side by side.
class TileReceivers {
public:
    static constexpr int kCapacity = 256;

    [[nodiscard]] int count() const noexcept { return count_; }
    [[nodiscard]] std::uint32_t pixel(int i) const noexcept { return pixel_[i]; }
    [[nodiscard]] Receiver operator[](int i) const noexcept {
        return {{px_[i], py_[i], pz_[i]}, {nx_[i], ny_[i], nz_[i]}, offset_[i], pixel_[i]};
    }
    /// Receivers [first, first + 16) become the lanes, but for their shading normals; those beyond the last are none,
    /// yet finite. Their pixels lie at the place returned.
    const std::uint32_t* load(int first, ReceiverLanes& lanes) const noexcept {
        for (int i = 0; i < kRayLanes; i += 4) {
            store(four(&px_[first + i]), &lanes.px[i]);
            store(four(&py_[first + i]), &lanes.py[i]);
            store(four(&pz_[first + i]), &lanes.pz[i]);
            store(four(&nx_[first + i]), &lanes.nx[i]);
            store(four(&ny_[first + i]), &lanes.ny[i]);
            store(four(&nz_[first + i]), &lanes.nz[i]);
            store(four(&offset_[first + i]), &lanes.offset[i]);
        }
        return &pixel_[first];
    }

private:
    friend class Tiles;
    // Four pixels are written at a time, sixteen read.
    template <class T>
    using Lanes = std::array<T, kCapacity + kRayLanes>;
    int count_ = 0;
    alignas(64) Lanes<float> px_{}, py_{}, pz_{}, nx_{}, ny_{}, nz_{}, offset_{};
    alignas(64) Lanes<std::uint32_t> pixel_{};
};

/// Pixels of a tile of 64 x 4, 4 x 4 blocks one after the other: 16 pixels in a row are neighbours, so that the rays of
/// a packet stay close to each other. The tile is flat because the View lies in memory row by row: with 16 x 16 pixels
/// reading it took a quarter of the time at one ray per pixel.
class Tiles {
public:
    static constexpr int kWidth = 64;
    static constexpr int kHeight = 4;
    static constexpr int kBlock = 4;
    static_assert(kWidth * kHeight == TileReceivers::kCapacity);

    Tiles(const RayScene& scene, const View& view) noexcept;
    [[nodiscard]] std::int64_t count() const noexcept { return static_cast<std::int64_t>(across_) * down_; }
    /// The receivers of the tile's pixels whose mask is not 0 and that have geometry.
    void collect(std::span<const std::uint8_t> mask, std::int64_t tile, TileReceivers& out) const noexcept;
    /// Asks for the tile's part of the View before it is needed: rows of a tile lie too far apart for the processor to
    /// see them coming.
    void prefetch(std::int64_t tile) const noexcept;
    /// Sets the tile's pixels in an image of the view's size.
    void fill(std::span<float> image, std::int64_t tile, float value) const noexcept;

private:
    /// Lower left pixel of a tile, and how much of it lies in the view.
    struct Area {
        int left, bottom, width, height;
    };
    [[nodiscard]] Area area(std::int64_t tile) const noexcept;
    /// Makes receivers of positions relative to the eye in metres and of triangles' bounds, in place.
    static void place(const glm::dvec3& eye_an, float per_unit, float world_size_an, TileReceivers& out) noexcept;

    const RayScene& scene_;
    const View& view_;
    int across_, down_;
    float per_unit_;  ///< 1 / unit of the anchor frame, a power of two
    glm::dvec3 eye_an_;
    float world_size_an_;  ///< what float64 rounds of world coordinates, as a size that float32 would round so
};

}  // namespace penumbra
