#include "reference/mixed_pixels.h"

#include <algorithm>
#include <cstddef>

#include "base/parallel.h"
#include "reference/vector_clones.h"

namespace penumbra {
namespace {

constexpr std::uint8_t kSawLight = 1;
constexpr std::uint8_t kSawShadow = 2;

/// What the rays of each pixel saw; below 0: it has none.
PENUMBRA_VECTOR_CLONES void find_in(const float* visibility, std::int64_t begin, std::int64_t end,
                                    std::uint8_t* found) noexcept {
    for (std::int64_t i = begin; i < end; ++i) {
        const float v = visibility[i];
        const int light = v > 0.0F ? kSawLight : 0;
        const int known = v >= 0.0F ? kSawShadow : 0;
        const int less = v < 1.0F ? kSawShadow : 0;
        found[i] = static_cast<std::uint8_t>(light | (known & less));
    }
}

std::vector<std::uint8_t> found_by(std::span<const float> visibility, Control& control) {
    std::vector<std::uint8_t> found(visibility.size());
    parallel_for(
        static_cast<std::int64_t>(visibility.size()), 32768,
        [&](std::int64_t begin, std::int64_t end) { find_in(visibility.data(), begin, end, found.data()); }, control);
    return found;
}

/// Per column, what the rows up to `radius` away from y found.
PENUMBRA_VECTOR_CLONES void gather_rows(const std::uint8_t* found, int width, int height, int y, int radius,
                                        std::uint8_t* out) noexcept {
    std::fill_n(out, width, std::uint8_t{0});
    for (int row = std::max(0, y - radius); row <= std::min(height - 1, y + radius); ++row) {
        const std::uint8_t* const from = found + static_cast<std::ptrdiff_t>(row) * width;
        for (int x = 0; x < width; ++x) {
            out[x] |= from[x];
        }
    }
}

/// @param columns  `radius` more on either side, 0 there
PENUMBRA_VECTOR_CLONES void gather_columns(const std::uint8_t* columns, int width, int radius,
                                           std::uint8_t* out) noexcept {
    std::fill_n(out, width, std::uint8_t{0});
    for (int dx = 0; dx <= 2 * radius; ++dx) {
        for (int x = 0; x < width; ++x) {
            out[x] |= columns[x + dx];
        }
    }
}

}  // namespace

void keep_mixed(const View& view, std::span<const float> visibility, int radius, std::span<std::uint8_t> open,
                Control& control) {
    const std::vector<std::uint8_t> found = found_by(visibility, control);
    const auto width = static_cast<std::size_t>(view.width);
    parallel_for(
        view.height, 64,
        [&](std::int64_t begin, std::int64_t end) {
            std::vector<std::uint8_t> columns(width + 2 * static_cast<std::size_t>(radius), 0);
            std::vector<std::uint8_t> around(width);
            for (auto y = static_cast<int>(begin); y < static_cast<int>(end); ++y) {
                gather_rows(found.data(), view.width, view.height, y, radius, columns.data() + radius);
                gather_columns(columns.data(), view.width, radius, around.data());
                std::uint8_t* const row = &open[static_cast<std::size_t>(y) * width];
                for (std::size_t x = 0; x < width; ++x) {
                    const bool mixed = around[x] == (kSawLight | kSawShadow);
                    row[x] = mixed ? row[x] : std::uint8_t{0};
                }
            }
        },
        control);
}

}  // namespace penumbra
