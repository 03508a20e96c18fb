#pragma once

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>
#include <functional>
#include <random>
#include <span>
#include <vector>

#include "penumbra/measure.h"

namespace penumbra::test {

using Image = std::vector<float>;

/// Columns umbra | ramp | lit: what a straight edge under a line-like light casts, V linear from 0 to 1 across the
/// ramp.
struct Ramp {
    int umbra_px = 256;
    int ramp_px = 256;
    int lit_px = 256;
    int rows = 1;

    [[nodiscard]] int width() const noexcept { return umbra_px + ramp_px + lit_px; }
    /// Position across the penumbra: below 0 in the umbra, above 1 where lit.
    [[nodiscard]] double at(int column) const noexcept { return (column - umbra_px + 0.5) / ramp_px; }

    /// An image from V as a function of the position across the penumbra and of the row.
    [[nodiscard]] Image image(const std::function<double(double, int)>& v) const {
        Image pixels;
        for (int y = 0; y < rows; ++y) {
            for (int x = 0; x < width(); ++x) {
                pixels.push_back(static_cast<float>(v(at(x), y)));
            }
        }
        return pixels;
    }
    [[nodiscard]] Image image(const std::function<double(double)>& v) const {
        return image([&](double t, int) { return v(t); });
    }
    [[nodiscard]] Image reference() const {
        return image([](double t) { return std::clamp(t, 0.0, 1.0); });
    }
};

inline ErrorSummary measure(const std::vector<Image>& seeds, const Image& reference, int width,
                            const Image& standard_error = {}, std::vector<std::uint8_t> mask = {}) {
    std::vector<std::span<const float>> images(seeds.begin(), seeds.end());
    if (mask.empty()) {
        mask.assign(reference.size(), 1);
    }
    return measure_errors(images, reference, standard_error, mask, width);
}

inline double sum_of_parts(const ErrorSummary& s) {
    return s.parts.noise + s.parts.leak + s.parts.over_darkening + s.parts.bias + s.parts.aliasing;
}

}  // namespace penumbra::test
