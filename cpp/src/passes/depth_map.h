#pragma once

#include <cstdint>
#include <span>
#include <string_view>

#include "gl/framebuffer.h"
#include "gl/texture.h"
#include "passes/gpu_blocks.h"
#include "passes/gpu_scene.h"
#include "passes/map_frustum.h"
#include "passes/map_layers.h"

namespace penumbra {

class Frame;

/// What the lookup shaders need to know of a frustum (binding 1, see lib/map_lookup.glsl).
[[nodiscard]] gpu::MapBlock make_map_block(const MapFrustum& frustum, const Light& light,
                                           const glm::dvec3& light_direction_ws, const glm::dvec3& eye_ws, int size_px);

/// Layers of float32 depth as a light point sees the casters: reversed (1 near, 0 nothing), linear in 1/z for
/// perspective faces and in z for orthographic ones. What is nearer than the near plane is clamped to it.
class DepthMap {
public:
    /// @param shared  takes its layers from there, unless nullptr
    /// @throws InvalidSettings or OutOfMemory with size and layers
    void allocate(int size_px, int layers, std::string_view what, MapLayers* shared = nullptr);
    /// Draws one face into one layer; clears it first.
    /// @param instances of `gpu_scene`, whose transforms MapSetup has bound
    /// @param peel a map of the same size whose layer `layer` is peeled off, or nullptr
    void render(Frame& frame, GpuScene& gpu_scene, std::span<const std::uint32_t> instances, std::size_t face,
                int layer, Cull cull, const DepthMap* peel = nullptr);

    /// Another one when shared layers have moved: not to be kept from pass to pass.
    [[nodiscard]] const TextureImage& texture() const noexcept { return lease_ ? lease_.texture() : texture_; }
    [[nodiscard]] TextureImage& texture() noexcept { return lease_ ? lease_.texture() : texture_; }
    [[nodiscard]] std::size_t bytes() const noexcept { return texture() ? texture().bytes() : 0; }

private:
    void attach();

    TextureImage texture_;
    MapLayers::Lease lease_;
    unsigned attached_ = 0;  ///< generation of the lease that the targets hold
    std::vector<RenderTarget> targets_;
};

/// Instances and block of one light point, bound for depth passes and lookups.
class MapSetup {
public:
    /// Composes all instances relative to the frustum's origin in float64 and binds storage 0 and uniform 1.
    void bind_for_depth(const GpuScene& gpu_scene, const MapFrustum& frustum, const gpu::MapBlock& block);
    void bind_for_lookup(const gpu::MapBlock& block);

private:
    StorageBuffer instances_, block_;
};

}  // namespace penumbra
