#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <span>

namespace penumbra {

/// Nearest-rank percentile: the smallest value that at least the share `q` of all values do not exceed, so that it is
/// always one of them. Reorders `values`. @param q 0 < q <= 1 @return 0 for no values
template <typename T>
[[nodiscard]] T percentile(std::span<T> values, double q) {
    if (values.empty()) {
        return T{};
    }
    const double rank = std::ceil(q * static_cast<double>(values.size()));
    const auto index = static_cast<std::size_t>(std::clamp(rank, 1.0, static_cast<double>(values.size()))) - 1;
    std::nth_element(values.begin(), values.begin() + static_cast<std::ptrdiff_t>(index), values.end());
    return values[index];
}

}  // namespace penumbra
