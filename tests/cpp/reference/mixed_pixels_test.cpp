#include "reference/mixed_pixels.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>
#include <vector>

#include "reference/sampling.h"

namespace penumbra {
namespace {

View empty_view(int width, int height) {
    View view;
    view.width = width;
    view.height = height;
    return view;
}

TEST(MixedPixels, AreThoseWithLightAndShadowInTheSquareAroundThem) {
    // Sizes that are no multiple of anything, smaller than the square, and a picture of nothing but holes among them.
    for (const auto& [width, height] : {std::pair{1, 1}, {3, 2}, {67, 131}, {200, 5}}) {
        for (const int radius : {0, 1, 2, 5}) {
            const View view = empty_view(width, height);
            std::vector<float> v(view.size());
            std::vector<std::uint8_t> open(view.size());
            for (std::size_t i = 0; i < v.size(); ++i) {
                const std::uint32_t random =
                    mix(static_cast<std::uint32_t>(i) * 7U + static_cast<std::uint32_t>(radius));
                const std::uint32_t kind = random % 64;
                v[i] = kind == 0 ? 0.0F : (kind == 1 ? 0.5F : (kind < 32 ? -1.0F : 1.0F));
                open[i] = random >> 8U & 1U;
            }
            std::vector<std::uint8_t> expected(view.size());
            for (int y = 0; y < height; ++y) {
                for (int x = 0; x < width; ++x) {
                    bool light = false;
                    bool shadow = false;
                    for (int ny = std::max(0, y - radius); ny <= std::min(height - 1, y + radius); ++ny) {
                        for (int nx = std::max(0, x - radius); nx <= std::min(width - 1, x + radius); ++nx) {
                            const float at = v[static_cast<std::size_t>(ny * width + nx)];
                            light = light || at > 0.0F;
                            shadow = shadow || (at >= 0.0F && at < 1.0F);
                        }
                    }
                    const auto i = static_cast<std::size_t>(y * width + x);
                    expected[i] = open[i] != 0 && light && shadow ? 1 : 0;
                }
            }
            Control control;
            keep_mixed(view, v, radius, open, control);
            EXPECT_EQ(open, expected) << width << " x " << height << ", radius " << radius;
        }
    }
}

}  // namespace
}  // namespace penumbra
