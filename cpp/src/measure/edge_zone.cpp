#include "measure/edge_zone.h"

#include <cstddef>

namespace penumbra {

namespace {

/// Widens every 1 to both sides along one line of `count` pixels that lie `stride` apart.
void widen(std::uint8_t* line, int count, std::ptrdiff_t stride, int radius_px) {
    std::vector<std::uint8_t> before(static_cast<std::size_t>(count));
    for (int i = 0; i < count; ++i) {
        before[static_cast<std::size_t>(i)] = line[i * stride];
    }
    int since = radius_px + 1;  // pixels since the last 1
    for (int i = 0; i < count; ++i) {
        since = before[static_cast<std::size_t>(i)] != 0 ? 0 : since + 1;
        line[i * stride] = since <= radius_px ? 1 : 0;
    }
    since = radius_px + 1;
    for (int i = count - 1; i >= 0; --i) {
        since = before[static_cast<std::size_t>(i)] != 0 ? 0 : since + 1;
        line[i * stride] |= static_cast<std::uint8_t>(since <= radius_px);
    }
}

bool opposite(PixelClass a, PixelClass b) noexcept {
    return (a == PixelClass::Umbra && b == PixelClass::Lit) || (a == PixelClass::Lit && b == PixelClass::Umbra);
}

}  // namespace

std::vector<std::uint8_t> edge_zone(std::span<const PixelClass> classes, int width, int radius_px) {
    const int height = width > 0 ? static_cast<int>(classes.size() / static_cast<std::size_t>(width)) : 0;
    std::vector<std::uint8_t> zone(classes.size(), 0);
    for (int y = 0; y < height; ++y) {
        for (int x = 0; x < width; ++x) {
            const std::size_t i = static_cast<std::size_t>(y) * static_cast<std::size_t>(width) + x;
            if (classes[i] == PixelClass::Penumbra) {
                zone[i] = 1;
            }
            if (x + 1 < width && opposite(classes[i], classes[i + 1])) {
                zone[i] = zone[i + 1] = 1;
            }
            const std::size_t above = i + static_cast<std::size_t>(width);
            if (y + 1 < height && opposite(classes[i], classes[above])) {
                zone[i] = zone[above] = 1;
            }
        }
    }
    for (int y = 0; y < height; ++y) {
        widen(zone.data() + static_cast<std::ptrdiff_t>(y) * width, width, 1, radius_px);
    }
    for (int x = 0; x < width; ++x) {
        widen(zone.data() + x, height, width, radius_px);
    }
    return zone;
}

}  // namespace penumbra
