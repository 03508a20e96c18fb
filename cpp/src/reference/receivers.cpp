#include "reference/receivers.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>

#include "reference/four_lanes.h"
#include "reference/vector_clones.h"

namespace penumbra {
namespace {

constexpr float kOffsetPerSize = kOffsetRoundings * std::numeric_limits<float>::epsilon();

PENUMBRA_INLINE float largest(float x, float y, float z) noexcept {
    return std::max({std::abs(x), std::abs(y), std::abs(z)});
}

/// Whether four pixels in a row are in the mask and have geometry.
PENUMBRA_INLINE bool all_wanted(const std::uint8_t* mask, const std::int32_t* instance) noexcept {
    const bool in_mask = mask[0] != 0 && mask[1] != 0 && mask[2] != 0 && mask[3] != 0;
    return in_mask && (instance[0] | instance[1] | instance[2] | instance[3]) >= 0;
}

/// Whether none of four pixels in a row is in the mask.
PENUMBRA_INLINE bool none_wanted(const std::uint8_t* mask) noexcept {
    std::uint32_t four_pixels = 0;
    std::memcpy(&four_pixels, mask, sizeof(four_pixels));
    return four_pixels == 0;
}

}  // namespace

Tiles::Tiles(const RayScene& scene, const View& view) noexcept
    : scene_{scene},
      view_{view},
      across_{(view.width + kWidth - 1) / kWidth},
      down_{(view.height + kHeight - 1) / kHeight},
      per_unit_{static_cast<float>(1.0 / scene.frame().unit_m)},
      eye_an_{scene.frame().point(view.eye_ws)} {
    constexpr double kRatio = std::numeric_limits<double>::epsilon() / std::numeric_limits<float>::epsilon();
    const glm::dvec3 origin = glm::abs(scene.frame().vector(scene.frame().origin_ws)) * kRatio;
    world_size_an_ = static_cast<float>(std::max({origin.x, origin.y, origin.z}));
}

Tiles::Area Tiles::area(std::int64_t tile) const noexcept {
    const int left = static_cast<int>(tile % across_) * kWidth;
    const int bottom = static_cast<int>(tile / across_) * kHeight;
    return {left, bottom, std::min(kWidth, view_.width - left), std::min(kHeight, view_.height - bottom)};
}

void Tiles::fill(std::span<float> image, std::int64_t tile, float value) const noexcept {
    const Area here = area(tile);
    for (int y = here.bottom; y < here.bottom + here.height; ++y) {
        std::fill_n(image.begin() + static_cast<std::ptrdiff_t>(y) * view_.width + here.left, here.width, value);
    }
}

void Tiles::prefetch(std::int64_t tile) const noexcept {
    if (tile >= count()) {
        return;
    }
    const Area here = area(tile);
    const auto fetch = [&](const auto& array, std::size_t first) {
        const char* const row = reinterpret_cast<const char*>(array.data() + first);
        const auto bytes = static_cast<int>(sizeof(array[0])) * here.width;
        for (int line = 0; line < bytes; line += 64) {
            __builtin_prefetch(row + line);
        }
    };
    for (int y = here.bottom; y < here.bottom + here.height; ++y) {
        const std::size_t first = static_cast<std::size_t>(y) * static_cast<std::size_t>(view_.width) + here.left;
        fetch(view_.position_cr, first);
        fetch(view_.normal_ws, first);
        fetch(view_.instance, first);
        fetch(view_.triangle, first);
    }
}

PENUMBRA_VECTOR_CLONES void Tiles::place(const glm::dvec3& eye_an, float per_unit, float world_size_an,
                                         TileReceivers& out) noexcept {
    const int rounded_up = (out.count_ + kRayLanes - 1) / kRayLanes * kRayLanes;
    for (int i = 0; i < rounded_up; ++i) {
        // A power of two rounds nothing.
        const float x = out.px_[i] * per_unit;
        const float y = out.py_[i] * per_unit;
        const float z = out.pz_[i] * per_unit;
        const auto px = static_cast<float>(eye_an.x + static_cast<double>(x));
        const auto py = static_cast<float>(eye_an.y + static_cast<double>(y));
        const auto pz = static_cast<float>(eye_an.z + static_cast<double>(z));
        // A far camera rounds positions more coarsely than the scene's own coordinates do, and so does even float64
        // where a tiny scene lies far from the world's origin.
        const float size = std::max({largest(px, py, pz), largest(x, y, z), world_size_an});
        out.offset_[i] = kOffsetPerSize * std::max(size, out.offset_[i]);
        out.px_[i] = px;
        out.py_[i] = py;
        out.pz_[i] = pz;
    }
}

void Tiles::collect(std::span<const std::uint8_t> mask, std::int64_t tile, TileReceivers& out) const noexcept {
    // Copies of all pointers: what is stored could change the originals, for all the compiler knows.
    const std::uint8_t* const wanted = mask.data();
    const glm::vec3* const position_cr = view_.position_cr.data();
    const glm::vec3* const normal_ws = view_.normal_ws.data();
    const std::int32_t* const instance = view_.instance.data();
    const std::int32_t* const triangle = view_.triangle.data();
    const Area here = area(tile);
    int count = 0;
    std::int32_t last_instance = -1;
    float bound = 0.0F;
    std::span<const float> bounds;
    const auto add_rest = [&](std::uint32_t pixel, int i) {
        if (instance[pixel] != last_instance) {
            last_instance = instance[pixel];
            bound = scene_.reach(last_instance).all;
            bounds = scene_.reach(last_instance).per_triangle;
        }
        const auto t = static_cast<std::size_t>(triangle[pixel]);
        out.offset_[i] = t < bounds.size() ? bounds[t] : bound;
        out.pixel_[i] = pixel;
    };
    for (int left = here.left; left < here.left + here.width; left += kBlock) {
        const int columns = std::min(kBlock, here.left + here.width - left);
        for (int y = here.bottom; y < here.bottom + here.height; ++y) {
            const std::uint32_t first = static_cast<std::uint32_t>(y) * static_cast<std::uint32_t>(view_.width) +
                                        static_cast<std::uint32_t>(left);
            if (columns == kBlock && none_wanted(&wanted[first])) {
                continue;  // most rows, where a mask leaves few pixels
            }
            if (columns == kBlock && all_wanted(&wanted[first], &instance[first])) {
                split(&position_cr[first].x, &out.px_[count], &out.py_[count], &out.pz_[count]);
                split(&normal_ws[first].x, &out.nx_[count], &out.ny_[count], &out.nz_[count]);
                for (std::uint32_t k = 0; k < 4; ++k) {
                    add_rest(first + k, count++);
                }
                continue;
            }
            for (std::uint32_t pixel = first; pixel < first + static_cast<std::uint32_t>(columns); ++pixel) {
                if (wanted[pixel] != 0 && instance[pixel] >= 0) {
                    out.px_[count] = position_cr[pixel].x;
                    out.py_[count] = position_cr[pixel].y;
                    out.pz_[count] = position_cr[pixel].z;
                    out.nx_[count] = normal_ws[pixel].x;
                    out.ny_[count] = normal_ws[pixel].y;
                    out.nz_[count] = normal_ws[pixel].z;
                    add_rest(pixel, count++);
                }
            }
        }
    }
    out.count_ = count;
    for (int i = count; i % kRayLanes != 0; ++i) {
        out.px_[i] = out.py_[i] = out.pz_[i] = out.offset_[i] = 0.0F;
    }
    place(eye_an_, per_unit_, world_size_an_, out);
}

}  // namespace penumbra
