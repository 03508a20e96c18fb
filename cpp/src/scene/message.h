#pragma once

#include <cmath>
#include <glm/glm.hpp>
#include <sstream>
#include <string>

#include "penumbra/error.h"

namespace penumbra::message {

/// The largest coordinate that crosses the border, in metres: beyond it the squares of lengths leave float32.
inline constexpr double kLargest_m = 1e18;

/// (x, y, z) with enough digits to recognise the value.
template <glm::length_t N, typename T>
std::ostream& operator<<(std::ostream& out, const glm::vec<N, T>& value) {
    out << '(';
    for (glm::length_t i = 0; i < N; ++i) {
        out << (i > 0 ? ", " : "") << value[i];
    }
    return out << ')';
}

/// All parts written one after another.
template <typename... Parts>
[[nodiscard]] std::string join(const Parts&... parts) {
    std::ostringstream out;
    out.precision(9);
    ((out << parts), ...);
    return out.str();
}

template <typename... Parts>
[[noreturn]] void refuse(const Parts&... parts) {
    throw InvalidScene{join(parts...)};
}

[[nodiscard]] inline bool is_finite(const glm::dvec3& value) noexcept {
    return std::isfinite(value.x) && std::isfinite(value.y) && std::isfinite(value.z);
}

}  // namespace penumbra::message
