#pragma once

#include <cstddef>

#include "geometry/adjacency.h"
#include "passes/gpu_scene.h"

namespace penumbra {

/// Adjacency of all meshes of a GpuScene, made when first asked for and kept until the meshes change; instances share
/// their mesh's. Lives on the render thread; techniques that use none never cause it.
class GpuAdjacency {
public:
    /// Makes what is missing for the scene's meshes. Cheap when nothing changed.
    void update(const GpuScene& gpu_scene);
    [[nodiscard]] std::size_t memory_bytes() const noexcept;
};

}  // namespace penumbra
