#pragma once

#include <cstdint>

namespace penumbra {

/// Which of 8 x 8 strata of a light a point sees, a bit each, row by row; lines: 64 intervals in a row.
using Board = std::uint64_t;
inline constexpr int kBoardSide = 8;
inline constexpr int kBoardStrata = kBoardSide * kBoardSide;

/// The set and the four neighbours of each (lines: two).
[[nodiscard]] constexpr Board spread(Board set, bool one_dimensional) noexcept {
    if (one_dimensional) {
        return set | (set << 1U) | (set >> 1U);
    }
    constexpr Board kFirstColumn = 0x0101010101010101ULL;
    constexpr Board kLastColumn = 0x8080808080808080ULL;
    const Board row = set | ((set & ~kLastColumn) << 1U) | ((set & ~kFirstColumn) >> 1U);
    return row | (set << 8U) | (set >> 8U);
}

/// Strata in whose neighbourhood, themselves included, some are seen and some are not.
/// @param all  seen by all points asked; @param any  seen by at least one
[[nodiscard]] constexpr Board disagreeing(Board all, Board any, bool one_dimensional) noexcept {
    return spread(any, one_dimensional) & spread(~all, one_dimensional);
}

}  // namespace penumbra
