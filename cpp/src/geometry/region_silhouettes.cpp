#include "geometry/region_silhouettes.h"

#include <cstddef>

#include "geometry/silhouettes.h"

namespace penumbra {

int facing_of(const glm::dvec3& a, const glm::dvec3& b, const glm::dvec3& c, const LightRegion& light) noexcept {
    const glm::dvec3 u = b - a;
    const glm::dvec3 v = c - a;
    const glm::dvec3 normal = glm::cross(u, v);
    const glm::dvec3 to_light = light.centre.w == 0.0 ? glm::dvec3{light.centre} : glm::dvec3{light.centre} - a;
    const double s = glm::dot(normal, to_light);
    const double reach = light.reach(normal) + kEdgeOn * glm::length(u) * glm::length(v) * glm::length(to_light);
    return static_cast<int>(s > reach) - static_cast<int>(s < -reach);
}

void find_region_silhouettes(const Mesh& mesh, const Adjacency& adjacency, const LightRegion& light_local,
                             std::vector<std::uint32_t>& out) {
    std::vector<std::int8_t> facing(mesh.triangles.size());
    for (std::size_t t = 0; t < facing.size(); ++t) {
        const glm::uvec3& v = mesh.triangles[t];
        facing[t] = static_cast<std::int8_t>(facing_of(glm::dvec3{mesh.positions_local[v.x]},
                                                       glm::dvec3{mesh.positions_local[v.y]},
                                                       glm::dvec3{mesh.positions_local[v.z]}, light_local));
    }
    // 1: the side's triangle lies left of v0 -> v1 for every observer on the light, -1 right, 0 it depends.
    const auto side_of = [&](std::uint32_t side) { return (side & 1U) != 0 ? -facing[side / 2] : facing[side / 2]; };
    for (std::size_t i = 0; i < adjacency.edges.size(); ++i) {
        const Adjacency::Edge& edge = adjacency.edges[i];
        bool between = false;
        if (edge.side1 != Adjacency::kNone) {
            if ((edge.side1 & Adjacency::kMany) == 0) {
                between = side_of(edge.side0) * side_of(edge.side1) < 0;
            } else {
                bool left = false;
                bool right = false;
                for (std::uint32_t k = 0; k < (edge.side1 & ~Adjacency::kMany); ++k) {
                    const int side = side_of(adjacency.more_sides[edge.side0 + k]);
                    left = left || side > 0;
                    right = right || side < 0;
                }
                between = left && right;
            }
        }
        if (!between) {
            out.push_back(static_cast<std::uint32_t>(i));
        }
    }
}

}  // namespace penumbra
