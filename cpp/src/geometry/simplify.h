#pragma once

#include <cstddef>
#include <memory>

#include "penumbra/scene.h"

namespace penumbra {

struct SimplifiedMesh {
    std::shared_ptr<const Mesh> mesh;  ///< the given one if there was nothing to leave out
    /// How far the two surfaces lie apart, in the mesh's unit: the largest distance of a used vertex of the full mesh
    /// from the reduced surface, and of corners, edge middles and centres of the reduced triangles from the full one.
    double deviation = 0.0;
};

/// Casters need no more triangles than their shadow shows. Vertices are welded by position and only left out, never
/// moved; open borders are kept as far as the library can. For casting only: normals and materials are dropped.
/// @param triangles  how many to aim for; shapes that would fall apart keep more
[[nodiscard]] SimplifiedMesh simplify(const std::shared_ptr<const Mesh>& mesh, std::size_t triangles);

}  // namespace penumbra
