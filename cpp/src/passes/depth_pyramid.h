#pragma once

#include <vector>

#include "gl/framebuffer.h"
#include "gl/texture.h"

namespace penumbra {

class Frame;

/// The nearest and the farthest depth of ever larger squares of a depth map: whether a whole window is in front of a
/// receiver, or behind it, is then known from a few texels.
class DepthPyramid {
public:
    /// All layers of a depth map (reversed depth).
    void update(Frame& frame, const TextureImage& depth_map);

    /// For lib/depth_pyramid.glsl: RG32F of half the map's size, x the largest (nearest) stored depth, y the smallest.
    [[nodiscard]] const TextureImage& texture() const noexcept { return texture_; }
    [[nodiscard]] std::size_t bytes() const noexcept { return texture_ ? texture_.bytes() : 0; }

private:
    TextureImage texture_;
    std::vector<std::vector<RenderTarget>> levels_;  ///< per layer
};

}  // namespace penumbra
