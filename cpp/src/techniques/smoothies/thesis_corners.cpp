#include "techniques/smoothies/thesis_corners.h"

#include <map>
#include <utility>

#include "passes/frame.h"

namespace penumbra {

std::vector<glm::vec4> thesis_tips(const Frame& frame, std::span<const gpu::SilhouetteRecord> records) {
    using Vertex = std::pair<std::uint32_t, std::uint32_t>;  // instance, welded vertex
    std::map<Vertex, int> edges_at;
    for (const gpu::SilhouetteRecord& record : records) {
        ++edges_at[{record.ids.x, record.ids.y}];
        ++edges_at[{record.ids.x, record.ids.z}];
    }
    std::map<Vertex, glm::dvec3> normals;
    std::map<std::uint32_t, bool> instances;
    for (const auto& [vertex, count] : edges_at) {
        if (count > 2) {
            normals[vertex] = glm::dvec3{0.0};
            instances[vertex.first] = true;
        }
    }
    const GpuScene& gpu_scene = frame.gpu_scene();
    for (const auto& [index, unused] : instances) {
        const Instance& instance = frame.scene().instances[index];
        const Mesh& mesh = *instance.mesh;
        const Adjacency& adjacency = frame.adjacency().of_mesh(gpu_scene.mesh_of_instance(index));
        const double winding = gpu_scene.mirrored(index) ? -1.0 : 1.0;
        const glm::dmat3 m{instance.world_from_local};
        for (const glm::uvec3& t : mesh.triangles) {
            for (int k = 0; k < 3; ++k) {
                const auto found = normals.find({index, adjacency.welded[t[k]]});
                if (found == normals.end()) {
                    continue;
                }
                const glm::dvec3 a{mesh.positions_local[t.x]};
                const glm::dvec3 n = winding * glm::cross(m * (glm::dvec3{mesh.positions_local[t.y]} - a),
                                                          m * (glm::dvec3{mesh.positions_local[t.z]} - a));
                const double length = glm::length(n);
                found->second += length > 0.0 ? n / length : glm::dvec3{0.0};
            }
        }
    }
    std::vector<glm::vec4> tips;
    tips.reserve(2 * records.size());
    for (const gpu::SilhouetteRecord& record : records) {
        for (const std::uint32_t end : {record.ids.y, record.ids.z}) {
            const auto found = normals.find({record.ids.x, end});
            tips.push_back(found == normals.end() ? glm::vec4{0.0F} : glm::vec4{glm::vec3{found->second}, 1.0F});
        }
    }
    return tips;
}

}  // namespace penumbra
