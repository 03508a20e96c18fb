#pragma once

#include <cstdint>
#include <glm/glm.hpp>
#include <vector>

#include "penumbra/scene.h"

namespace penumbra {

/// Which triangles meet at which edge. Made once per mesh, whatever its topology: open, non-manifold, wound
/// inconsistently, vertices doubled for normals or UVs (they are welded by position).
///
/// A side is a triangle as one edge sees it: `2 * triangle + reversed`, reversed = 1 if the triangle runs the edge from
/// v1 to v0. Triangles that have two corners at one place have no sides and no edges of their own.
struct Adjacency {
    static constexpr std::uint32_t kNone = 0xffffffffU;
    static constexpr std::uint32_t kMany = 0x80000000U;

    /// v0 < v1, both welded. One triangle: side1 = kNone. Two: both sides. More: side0 is the first of `more_sides`
    /// and side1 = kMany | count. Sides are in the order of
    /// their triangles' third corners, not of the triangles.
    struct Edge {
        std::uint32_t v0 = 0, v1 = 0;
        std::uint32_t side0 = kNone, side1 = kNone;
    };

    std::vector<std::uint32_t> welded;       ///< per vertex of the mesh: the first vertex at the same place
    std::vector<Edge> edges;                 ///< sorted by (v0, v1)
    std::vector<std::uint32_t> more_sides;   ///< sides of the edges with more than two triangles
    std::vector<glm::uvec3> triangle_edges;  ///< per triangle: its edges corner 0-1, 1-2, 2-0; kNone if degenerate
    std::uint64_t border_edges = 0;          ///< with one triangle
    std::uint64_t many_edges = 0;            ///< with more than two

    [[nodiscard]] bool closed_manifold() const noexcept { return border_edges == 0 && many_edges == 0; }
    [[nodiscard]] std::size_t bytes() const noexcept;
};

/// Positions count as equal if all their bits do (-0 is 0).
[[nodiscard]] Adjacency make_adjacency(const Mesh& mesh);

}  // namespace penumbra
