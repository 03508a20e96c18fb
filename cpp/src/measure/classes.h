#pragma once

#include <cstdint>

namespace penumbra {

/// What the reference says of a pixel.
enum class PixelClass : std::uint8_t { Outside, Umbra, Penumbra, Lit };

/// A reference within this of 0 or 1 is umbra or lit: one ray in ten thousand.
inline constexpr float kClassMargin = 1e-4F;

[[nodiscard]] inline PixelClass class_of(float reference, bool in_mask) noexcept {
    if (!in_mask) {
        return PixelClass::Outside;
    }
    if (reference <= kClassMargin) {
        return PixelClass::Umbra;
    }
    return reference >= 1.0F - kClassMargin ? PixelClass::Lit : PixelClass::Penumbra;
}

}  // namespace penumbra
