#pragma once

#include <cmath>
#include <cstdint>
#include <vector>

#include "reference/vector_clones.h"

namespace penumbra {

/// Mixes all bits of a word: the finaliser of MurmurHash3 (public domain).
[[nodiscard]] PENUMBRA_INLINE constexpr std::uint32_t mix(std::uint32_t x) noexcept {
    x ^= x >> 16;
    x *= 0x85EBCA6BU;
    x ^= x >> 13;
    x *= 0xC2B2AE35U;
    x ^= x >> 16;
    return x;
}

/// What the random sequences of an image have in common. `stream` keeps the phases of one estimate apart.
[[nodiscard]] constexpr std::uint32_t sequence_base(std::uint32_t seed, std::uint32_t stream) noexcept {
    return mix(seed ^ mix(stream + 0x9E3779B9U));
}

/// Start of the random sequence of one pixel. Depends on nothing but its arguments, so that neither threads nor the
/// order of the work change an image.
[[nodiscard]] PENUMBRA_INLINE constexpr std::uint32_t sequence_key(std::uint32_t pixel, std::uint32_t base) noexcept {
    return mix(pixel ^ base);
}

/// Two independent numbers in (0, 1) for the i-th sample of a sequence: 16 bits each place a point within its
/// stratum, which is finer than float32 resolves on the light once there are more than a few strata.
PENUMBRA_INLINE constexpr void uniform_pair(std::uint32_t key, std::uint32_t index, float& a, float& b) noexcept {
    const std::uint32_t bits = mix(key + index * 0x9E3779B9U);
    a = (static_cast<float>(static_cast<std::int32_t>(bits & 0xFFFFU)) + 0.5F) * (1.0F / 65536.0F);
    b = (static_cast<float>(static_cast<std::int32_t>(bits >> 16)) + 0.5F) * (1.0F / 65536.0F);
}

/// The unit square cut into n cells of equal area 1/n, one sample each (jittered sampling, [Cook1984], any n).
///
/// About sqrt(n) rows share the n cells as evenly as whole numbers allow, each row as high as its share; for a square
/// number this is the k x k grid. Only cells that the shadow's edge crosses contribute noise, hence an RMSE of
/// n^-3/4 instead of n^-1/2 [Mitchell1996]. In one dimension (line lights) the cells are n intervals of u: n^-1.
struct Strata {
    std::vector<float> u, v;           ///< lower left corners
    std::vector<float> width, height;  ///< of the cells
    [[nodiscard]] int count() const noexcept { return static_cast<int>(u.size()); }
};

[[nodiscard]] inline Strata make_strata(int count, bool one_dimensional) {
    Strata strata;
    const int rows = one_dimensional ? 1 : static_cast<int>(std::lround(std::sqrt(static_cast<double>(count))));
    int below = 0;  // cells in the rows done so far
    for (int row = 0; row < rows; ++row) {
        const int next = static_cast<int>(static_cast<std::int64_t>(count) * (row + 1) / rows);
        const int columns = next - below;
        for (int column = 0; column < columns; ++column) {
            strata.u.push_back(static_cast<float>(static_cast<double>(column) / columns));
            strata.v.push_back(static_cast<float>(static_cast<double>(below) / count));
            strata.width.push_back(static_cast<float>(1.0 / columns));
            strata.height.push_back(static_cast<float>(static_cast<double>(columns) / count));
        }
        below = next;
    }
    return strata;
}

}  // namespace penumbra
