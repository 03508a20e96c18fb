#pragma once

#include <cstdint>
#include <glm/glm.hpp>
#include <memory>
#include <span>
#include <vector>

#include "gl/buffer.h"
#include "passes/gpu_blocks.h"
#include "penumbra/scene.h"
#include "scene/bounds.h"

namespace penumbra {

enum class Cull { None, Front, Back };

/// The scene's meshes on the device: one copy of each, however many instances. Lives on the render thread.
class GpuScene {
public:
    /// Where a mesh lies in the shared buffers. Its positions there are relative to `centre_local`.
    struct MeshRange {
        std::uint32_t first_index = 0, index_count = 0, first_vertex = 0;
        glm::dvec3 centre_local{0.0};
        Bounds bounds_local;
        bool sent = true;  ///< false: index_count is 0, for no instance is seen or casts
    };

    /// Sends positions and triangles, and only if the meshes changed: nothing else of a mesh is drawn with. Transforms
    /// stay here, since each pass wants them relative to an origin of its own.
    /// @return true if geometry was sent again
    bool update(const Scene& scene);

    /// Another number each time that geometry was sent.
    [[nodiscard]] std::uint64_t geometry_revision() const noexcept { return revision_; }
    /// Boxes of the instances, world, in their order.
    [[nodiscard]] const std::vector<Bounds>& instance_bounds_ws() const noexcept { return instance_bounds_ws_; }
    [[nodiscard]] std::size_t instance_count() const noexcept { return world_from_recentred_.size(); }

    /// The different meshes, and where each lies.
    [[nodiscard]] const std::vector<std::shared_ptr<const Mesh>>& meshes() const noexcept { return meshes_; }
    [[nodiscard]] const std::vector<MeshRange>& mesh_ranges() const noexcept { return ranges_; }
    /// Index into both.
    [[nodiscard]] std::uint32_t mesh_of_instance(std::size_t i) const noexcept { return mesh_of_instance_[i]; }
    [[nodiscard]] const glm::dmat4& world_from_recentred(std::size_t i) const noexcept {
        return world_from_recentred_[i];
    }
    [[nodiscard]] bool mirrored(std::size_t i) const noexcept { return mirrored_[i] != 0; }

    /// Transforms of all instances relative to `origin_ws`, composed in float64.
    [[nodiscard]] std::vector<gpu::InstanceBlock> relative_to(const glm::dvec3& origin_ws) const;

    /// Draws instances with the program in use; attributes: 0 recentred local position, 1 instance index.
    /// Mirrored instances are wound the other way round, so that culling means the same for all.
    void draw(std::span<const std::uint32_t> instances, Cull cull);

    [[nodiscard]] const StorageBuffer& positions() const noexcept { return positions_; }
    [[nodiscard]] const StorageBuffer& indices() const noexcept { return indices_; }
    [[nodiscard]] std::size_t memory_bytes() const noexcept;
    /// Of meshes that somebody sees or that cast: no other is sent (rule instance-without-effect).
    [[nodiscard]] std::size_t triangles_sent() const noexcept { return indices_.bytes() / sizeof(glm::uvec3); }

private:
    /// @return true if each instance has the mesh that it had
    [[nodiscard]] bool has_meshes_of(const Scene& scene) const noexcept;
    /// By mesh: 1 if some instance of it is visible or casts. Of a scene with the meshes of mesh_of_instance_.
    [[nodiscard]] std::vector<std::uint8_t> meshes_needed(const Scene& scene, std::size_t meshes) const;
    void send_geometry();
    void place(const Scene& scene);
    void make_vertex_array();

    std::vector<std::shared_ptr<const Mesh>> meshes_;  ///< kept, so that a pointer names the same mesh as before
    std::uint64_t revision_ = 0;
    std::vector<std::uint8_t> mesh_needed_;  ///< some instance of it is visible or casts
    std::vector<MeshRange> ranges_;
    std::vector<std::uint32_t> mesh_of_instance_;
    std::vector<glm::dmat4> world_from_recentred_;
    std::vector<std::uint8_t> mirrored_;
    std::vector<Bounds> instance_bounds_ws_;

    VertexArray vertex_array_;
    StorageBuffer positions_, indices_, instance_indices_, commands_;
};

}  // namespace penumbra
