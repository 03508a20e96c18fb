#include "passes/gpu_adjacency.h"

#include <map>

#include "penumbra/error.h"

namespace penumbra {

void GpuAdjacency::update(const GpuScene& gpu_scene) {
    if (planes_ && gpu_scene.meshes() == meshes_) {
        return;
    }
    std::map<const Mesh*, std::shared_ptr<const Adjacency>> known;
    for (std::size_t i = 0; i < meshes_.size(); ++i) {
        known.emplace(meshes_[i].get(), adjacencies_[i]);
    }
    std::vector<std::shared_ptr<const Adjacency>> adjacencies;
    std::uint64_t words = 0;
    for (const auto& mesh : gpu_scene.meshes()) {
        const auto found = known.find(mesh.get());
        adjacencies.push_back(found != known.end() ? found->second
                                                   : std::make_shared<const Adjacency>(make_adjacency(*mesh)));
        words += 3 * mesh->triangles.size() + adjacencies.back()->more_sides.size();
    }
    if (words > 0xffffffffULL) {
        throw InvalidScene("the scene's meshes have " + std::to_string(words / 3) +
                           " triangles together, more than silhouettes can be found on; simplify or hide some");
    }

    std::vector<glm::vec4> planes;
    std::vector<Adjacency::Edge> edges;
    std::vector<std::uint32_t> triangle_edges;
    std::vector<MeshRange> ranges;
    for (std::size_t i = 0; i < adjacencies.size(); ++i) {
        const Mesh& mesh = *gpu_scene.meshes()[i];
        const GpuScene::MeshRange& placed = gpu_scene.mesh_ranges()[i];
        MeshRange range;
        range.first_plane = static_cast<std::uint32_t>(planes.size());
        range.first_edge = static_cast<std::uint32_t>(edges.size());
        range.first_corner = static_cast<std::uint32_t>(triangle_edges.size());
        range.frame = FacingFrame{glm::dvec3{0.0}, placed.bounds_local.radius()};
        const auto position = [&](std::uint32_t v) {  // as the device has it
            return glm::dvec3{glm::vec3{glm::dvec3{mesh.positions_local[v]} - placed.centre_local}};
        };
        for (const glm::uvec3& v : mesh.triangles) {
            planes.emplace_back(range.frame.plane(position(v.x), position(v.y), position(v.z)));
        }
        const Adjacency& adjacency = *adjacencies[i];
        edges.insert(edges.end(), adjacency.edges.begin(), adjacency.edges.end());
        for (const glm::uvec3& e : adjacency.triangle_edges) {
            triangle_edges.insert(triangle_edges.end(), {e.x, e.y, e.z});
        }
        range.first_more = static_cast<std::uint32_t>(triangle_edges.size());
        triangle_edges.insert(triangle_edges.end(), adjacency.more_sides.begin(), adjacency.more_sides.end());
        ranges.push_back(range);
    }
    planes_ = StorageBuffer::from(planes, "facing planes");
    edges_ = StorageBuffer::from(edges, "edges");
    triangle_edges_ = StorageBuffer::from(triangle_edges, "edges of triangles");
    meshes_ = gpu_scene.meshes();
    adjacencies_ = std::move(adjacencies);
    ranges_ = std::move(ranges);
}

void GpuAdjacency::bind() const {
    planes_.bind_storage(3);
    edges_.bind_storage(4);
    triangle_edges_.bind_storage(5);
}

std::size_t GpuAdjacency::memory_bytes() const noexcept {
    std::size_t bytes = planes_.bytes() + edges_.bytes() + triangle_edges_.bytes();
    for (const auto& adjacency : adjacencies_) {
        bytes += adjacency->bytes();
    }
    return bytes;
}

}  // namespace penumbra
