#include "passes/gpu_adjacency.h"

#include <map>
#include <span>

namespace penumbra {

void GpuAdjacency::update(const GpuScene& gpu_scene) {
    if (planes_ && gpu_scene.meshes() == meshes_ && gpu_scene.geometry_revision() == revision_) {
        return;
    }
    std::map<const Mesh*, std::shared_ptr<const Adjacency>> known;
    for (std::size_t i = 0; i < meshes_.size(); ++i) {
        known.emplace(meshes_[i].get(), adjacencies_[i]);
    }
    std::vector<std::shared_ptr<const Adjacency>> adjacencies;
    for (std::size_t i = 0; i < gpu_scene.meshes().size(); ++i) {
        const auto& mesh = gpu_scene.meshes()[i];
        const auto found = known.find(mesh.get());
        if (!gpu_scene.mesh_ranges()[i].sent) {
            adjacencies.push_back(std::make_shared<const Adjacency>());
        } else if (found != known.end() && !found->second->edges.empty()) {
            adjacencies.push_back(found->second);
        } else {
            adjacencies.push_back(std::make_shared<const Adjacency>(make_adjacency(*mesh)));
        }
    }

    std::vector<glm::vec4> planes;
    std::vector<Adjacency::Edge> edges;
    std::vector<glm::uvec3> triangle_edges;
    std::vector<std::uint32_t> more_sides;
    std::vector<MeshRange> ranges;
    for (std::size_t i = 0; i < adjacencies.size(); ++i) {
        const Mesh& mesh = *gpu_scene.meshes()[i];
        const GpuScene::MeshRange& placed = gpu_scene.mesh_ranges()[i];
        MeshRange range;
        range.first_plane = static_cast<std::uint32_t>(planes.size());
        range.first_edge = static_cast<std::uint32_t>(edges.size());
        range.first_more = static_cast<std::uint32_t>(more_sides.size());
        range.frame = FacingFrame{glm::dvec3{0.0}, placed.bounds_local.radius()};
        const auto position = [&](std::uint32_t v) {  // as the device has it
            return glm::dvec3{glm::vec3{glm::dvec3{mesh.positions_local[v]} - placed.centre_local}};
        };
        for (const glm::uvec3& v : std::span{mesh.triangles}.first(placed.index_count / 3)) {
            planes.emplace_back(range.frame.plane(position(v.x), position(v.y), position(v.z)));
        }
        const Adjacency& adjacency = *adjacencies[i];
        edges.insert(edges.end(), adjacency.edges.begin(), adjacency.edges.end());
        triangle_edges.insert(triangle_edges.end(), adjacency.triangle_edges.begin(), adjacency.triangle_edges.end());
        more_sides.insert(more_sides.end(), adjacency.more_sides.begin(), adjacency.more_sides.end());
        ranges.push_back(range);
    }
    planes_ = StorageBuffer::from(planes, "facing planes");
    edges_ = StorageBuffer::from(edges, "edges");
    triangle_edges_ = StorageBuffer::from(triangle_edges, "edges of triangles");
    more_sides_ = StorageBuffer::from(more_sides, "sides of crowded edges");
    textures_ = {BufferTexture{GL_RGBA32F, planes_, "facing planes"},
                 BufferTexture{GL_RGBA32UI, edges_, "edges"},
                 BufferTexture{GL_RGB32UI, triangle_edges_, "edges of triangles"},
                 BufferTexture{GL_R32UI, more_sides_, "sides of crowded edges"},
                 BufferTexture{GL_RGB32F, gpu_scene.positions(), "vertex positions"},
                 BufferTexture{GL_RGB32UI, gpu_scene.indices(), "triangle indices"}};
    meshes_ = gpu_scene.meshes();
    revision_ = gpu_scene.geometry_revision();
    adjacencies_ = std::move(adjacencies);
    ranges_ = std::move(ranges);
}

void GpuAdjacency::bind() const {
    for (GLuint unit = 0; unit < textures_.size(); ++unit) {
        textures_[unit].bind(unit);
    }
}

std::size_t GpuAdjacency::memory_bytes() const noexcept {
    std::size_t bytes = planes_.bytes() + edges_.bytes() + triangle_edges_.bytes() + more_sides_.bytes();
    for (const auto& adjacency : adjacencies_) {
        bytes += adjacency->bytes();
    }
    return bytes;
}

}  // namespace penumbra
