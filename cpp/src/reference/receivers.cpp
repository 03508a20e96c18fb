#include "reference/receivers.h"

#include <array>

namespace penumbra {
namespace {

/// Where the i-th pixel of a tile lies in it.
struct Place {
    std::uint8_t x, y;
};

constexpr auto kPlaces = [] {
    constexpr int kBlock = 4;
    constexpr int kBlocks = Tiles::kWidth / kBlock;
    std::array<Place, Tiles::kWidth * Tiles::kHeight> places{};
    for (int i = 0; i < Tiles::kWidth * Tiles::kHeight; ++i) {
        const int block = i / (kBlock * kBlock);
        const int within = i % (kBlock * kBlock);
        places[static_cast<std::size_t>(i)] = {static_cast<std::uint8_t>(block % kBlocks * kBlock + within % kBlock),
                                               static_cast<std::uint8_t>(block / kBlocks * kBlock + within / kBlock)};
    }
    return places;
}();

}  // namespace

ReceiverMaker::ReceiverMaker(const RayScene& scene, const View& view) noexcept
    : scene_{scene},
      view_{view},
      per_unit_{1.0 / scene.frame().unit_m},
      eye_an_{(view.eye_ws - scene.frame().origin_ws) * per_unit_} {
    constexpr double kRatio = std::numeric_limits<double>::epsilon() / std::numeric_limits<float>::epsilon();
    const glm::dvec3 origin = glm::abs(scene.frame().origin_ws) * (per_unit_ * kRatio);
    world_size_an_ = static_cast<float>(std::max({origin.x, origin.y, origin.z}));
}

Tiles::Tiles(const RayScene& scene, const View& view) noexcept
    : make_{scene, view},
      view_{view},
      across_{(view.width + kWidth - 1) / kWidth},
      down_{(view.height + kHeight - 1) / kHeight} {}

void Tiles::collect(std::span<const std::uint8_t> mask, std::int64_t tile, std::vector<Receiver>& out) const {
    const int left = static_cast<int>(tile % across_) * kWidth;
    const int bottom = static_cast<int>(tile / across_) * kHeight;
    out.resize(kPlaces.size());
    std::size_t count = 0;
    for (const Place place : kPlaces) {
        const int x = left + place.x;
        const int y = bottom + place.y;
        if (x >= view_.width || y >= view_.height) {
            continue;
        }
        const std::size_t pixel = static_cast<std::size_t>(y) * static_cast<std::size_t>(view_.width) + x;
        if (mask[pixel] != 0 && view_.hit(pixel)) {
            out[count++] = make_(pixel);
        }
    }
    out.resize(count);
}

}  // namespace penumbra
