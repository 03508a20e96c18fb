#pragma once

#include <array>

#include "gl/framebuffer.h"
#include "gl/texture.h"

namespace penumbra {

class Frame;

/// For every texel of a depth map the nearest and the farthest depth of the window of exactly N x N texels that begins
/// there (erosion and dilation): one texel then tells whether a whole filter kernel lies on one side of a receiver. A
/// pyramid's windows are up to twice as wide as asked, and on slanted surfaces never on one side.
class WindowRange {
public:
    /// All layers of a depth map (reversed depth); 2 ceil(log2 N) passes. @param window_px 1 .. the map's width
    void update(Frame& frame, const TextureImage& depth_map, int window_px);

    /// RG32F of the map's size, x the largest (nearest) stored depth, y the smallest. After update().
    [[nodiscard]] const TextureImage& texture() const noexcept { return textures_[last_]; }
    [[nodiscard]] std::size_t bytes() const noexcept { return 2 * (textures_[0] ? textures_[0].bytes() : 0); }

private:
    std::array<TextureImage, 2> textures_;
    std::array<std::vector<RenderTarget>, 2> targets_;  ///< per layer
    std::size_t last_ = 0;
};

}  // namespace penumbra
