#include "reference/receivers.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace penumbra {
namespace {

/// Offset of a ray's start in float32 roundings of the coordinates involved.
///
/// What can be wrong is the height of the point above its triangle: the View's position and its conversion round once
/// each, Embree's robust test subtracts origin from vertex (once) and, through an instance, transforms the origin (up
/// to kLargestCondition times a rounding). With the worst orientation (factor sqrt 3) that is some 10 roundings in the
/// worst case. Measured on grazing lit spheres, cubes, turned planes and instances over all scales and places
/// (visibility_tracer_test.cpp): acne at 1.0, none from 1.5 on. 16 leaves room and is still 2e-6 of the scene's size.
constexpr float kOffsetRoundings = 16.0F;
constexpr float kRounding = std::numeric_limits<float>::epsilon();
constexpr double kRoundingRatio = std::numeric_limits<double>::epsilon() / std::numeric_limits<float>::epsilon();

float largest(const glm::vec3& v) noexcept {
    return std::max({std::abs(v.x), std::abs(v.y), std::abs(v.z)});
}

}  // namespace

ReceiverMaker::ReceiverMaker(const RayScene& scene, const View& view) noexcept
    : scene_{scene},
      view_{view},
      per_unit_{1.0 / scene.frame().unit_m},
      eye_an_{(view.eye_ws - scene.frame().origin_ws) * per_unit_} {
    const glm::dvec3 origin = glm::abs(scene.frame().origin_ws) * (per_unit_ * kRoundingRatio);
    world_size_an_ = static_cast<float>(std::max({origin.x, origin.y, origin.z}));
}

Receiver ReceiverMaker::operator()(std::size_t pixel) const noexcept {
    const glm::dvec3 from_eye_an = glm::dvec3(view_.position_cr[pixel]) * per_unit_;
    const glm::vec3 position_an{eye_an_ + from_eye_an};
    // A far camera rounds positions more coarsely than the scene's own coordinates do, and so does even float64 where
    // a tiny scene lies far from the world's origin.
    const float size = std::max({largest(position_an), largest(glm::vec3(from_eye_an)), world_size_an_,
                                 scene_.coordinate_bound(view_.instance[pixel], view_.triangle[pixel])});
    return {position_an, view_.normal_ws[pixel], kOffsetRoundings * kRounding * size,
            static_cast<std::uint32_t>(pixel)};
}

Tiles::Tiles(const RayScene& scene, const View& view) noexcept
    : make_{scene, view},
      view_{view},
      across_{(view.width + kSide - 1) / kSide},
      down_{(view.height + kSide - 1) / kSide} {}

void Tiles::collect(std::span<const std::uint8_t> mask, std::int64_t tile, std::vector<Receiver>& out) const {
    out.clear();
    const int left = static_cast<int>(tile % across_) * kSide;
    const int bottom = static_cast<int>(tile / across_) * kSide;
    constexpr int kBlock = 4;
    constexpr int kBlocks = kSide / kBlock;
    for (int i = 0; i < kSide * kSide; ++i) {
        const int block = i / (kBlock * kBlock);
        const int within = i % (kBlock * kBlock);
        const int x = left + block % kBlocks * kBlock + within % kBlock;
        const int y = bottom + block / kBlocks * kBlock + within / kBlock;
        if (x >= view_.width || y >= view_.height) {
            continue;
        }
        const std::size_t pixel = static_cast<std::size_t>(y) * static_cast<std::size_t>(view_.width) + x;
        if (mask[pixel] != 0 && view_.hit(pixel)) {
            out.push_back(make_(pixel));
        }
    }
}

}  // namespace penumbra
