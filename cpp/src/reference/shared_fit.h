#pragma once

#include <cstddef>
#include <span>

#include "penumbra/view.h"

namespace penumbra {

struct SharedFit {
    float visibility = 0.0F;  ///< 0 .. 1
    float slope = 0.0F;       ///< of V, per pixel
    float scatter = 0.0F;     ///< standard deviation around the plane; infinite where too few pixels are there to tell
};

/// V of a pixel from that of the pixels up to `radius` away that see the same surface: the plane a + b x + c y fitted
/// to them by least squares, at the pixel itself. Exact where V is linear, however the surface ends; where it bends,
/// off by its second derivative times radius (radius + 1) / 6 in each direction.
///
/// @param visibility  below 0 where nothing is known
SharedFit fit_around(const View& view, std::span<const float> visibility, std::size_t pixel, int radius) noexcept;

}  // namespace penumbra
