#pragma once

#include <cstddef>

#include "reference/vector_clones.h"

namespace penumbra {

/// One vector register of four numbers, wherever they lie in memory. For moves between arrays of structs and structs of
/// arrays, of which the compiler makes scalar code; at one ray per pixel that shows.
using FourLanes [[gnu::vector_size(16), gnu::aligned(4), gnu::may_alias]] = float;

PENUMBRA_INLINE FourLanes four(const float* from) noexcept {
    return *reinterpret_cast<const FourLanes*>(from);
}
PENUMBRA_INLINE void store(const FourLanes& lanes, float* to) noexcept {
    *reinterpret_cast<FourLanes*>(to) = lanes;
}

/// x, y, z, w of four things become four in a row: (x0, y0, z0, w0) at `to`, the next one `stride` numbers further on.
PENUMBRA_INLINE void interleave(const float* x, const float* y, const float* z, const float* w, float* to,
                                std::size_t stride) noexcept {
    const FourLanes xy_low = __builtin_shufflevector(four(x), four(y), 0, 4, 1, 5);
    const FourLanes xy_high = __builtin_shufflevector(four(x), four(y), 2, 6, 3, 7);
    const FourLanes zw_low = __builtin_shufflevector(four(z), four(w), 0, 4, 1, 5);
    const FourLanes zw_high = __builtin_shufflevector(four(z), four(w), 2, 6, 3, 7);
    store(__builtin_shufflevector(xy_low, zw_low, 0, 1, 4, 5), to);
    store(__builtin_shufflevector(xy_low, zw_low, 2, 3, 6, 7), to + stride);
    store(__builtin_shufflevector(xy_high, zw_high, 0, 1, 4, 5), to + 2 * stride);
    store(__builtin_shufflevector(xy_high, zw_high, 2, 3, 6, 7), to + 3 * stride);
}

/// Four times (x, y, z) in a row become three times four.
PENUMBRA_INLINE void split(const float* xyz, float* x, float* y, float* z) noexcept {
    const FourLanes a = four(xyz);                                   // x0 y0 z0 x1
    const FourLanes b = four(xyz + 4);                               // y1 z1 x2 y2
    const FourLanes c = four(xyz + 8);                               // z2 x3 y3 z3
    const FourLanes xy = __builtin_shufflevector(b, c, 2, 3, 5, 6);  // x2 y2 x3 y3
    const FourLanes yz = __builtin_shufflevector(a, b, 1, 2, 4, 5);  // y0 z0 y1 z1
    store(__builtin_shufflevector(a, xy, 0, 3, 4, 6), x);
    store(__builtin_shufflevector(yz, xy, 0, 2, 5, 7), y);
    store(__builtin_shufflevector(yz, c, 1, 3, 4, 7), z);
}

}  // namespace penumbra
