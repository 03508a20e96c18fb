#pragma once

#include <array>
#include <cstddef>
#include <memory>
#include <vector>

#include "geometry/adjacency.h"
#include "geometry/silhouettes.h"
#include "gl/buffer.h"
#include "gl/buffer_texture.h"
#include "passes/gpu_scene.h"

namespace penumbra {

/// Adjacency of all meshes of a GpuScene, made when first asked for and kept until the meshes change; instances share
/// their mesh's. Lives on the render thread; techniques that use none never cause it.
class GpuAdjacency {
public:
    /// Where a mesh lies in the shared buffers.
    struct MeshRange {
        std::uint32_t first_plane = 0, first_edge = 0, first_more = 0;
        FacingFrame frame;  ///< of the recentred positions
    };

    /// Makes what is missing for the scene's meshes. Cheap when nothing changed.
    void update(const GpuScene& gpu_scene);

    /// Of the mesh with this index in GpuScene::meshes(), as it was at the last update().
    [[nodiscard]] const Adjacency& of_mesh(std::size_t mesh) const noexcept { return *adjacencies_[mesh]; }
    [[nodiscard]] const MeshRange& range(std::size_t mesh) const noexcept { return ranges_[mesh]; }

    /// Facing planes, edges, and edges of triangles (then the sides of edges that have many) at storage bindings 3
    /// .. 5.
    void bind() const;
    /// On the device and in main memory.
    [[nodiscard]] std::size_t memory_bytes() const noexcept;

private:
    std::uint64_t revision_ = 0;
    std::vector<std::shared_ptr<const Mesh>> meshes_;  ///< kept, so that a pointer names the same mesh as before
    std::vector<std::shared_ptr<const Adjacency>> adjacencies_;
    std::vector<MeshRange> ranges_;
    StorageBuffer planes_, edges_, triangle_edges_, more_sides_;
    std::array<BufferTexture, 6> textures_;
};

}  // namespace penumbra
