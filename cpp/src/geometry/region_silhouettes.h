#pragma once

#include <cstdint>
#include <glm/glm.hpp>
#include <vector>

#include "geometry/adjacency.h"
#include "geometry/light_region.h"
#include "penumbra/scene.h"

namespace penumbra {

/// How a triangle faces a region of light points: 1 all of them see its front, -1 all its back, 0 some each or within
/// rounding (kEdgeOn of the lengths involved). Winding: front is where (b - a) x (c - a) points.
[[nodiscard]] int facing_of(const glm::dvec3& a, const glm::dvec3& b, const glm::dvec3& c,
                            const LightRegion& light) noexcept;

/// The edges that may be a silhouette from some point of the light: a superset of what find_silhouettes() finds from
/// any of them. An edge is left out only if two of its triangles keep to opposite sides of it wherever on the light the
/// observer stands. Borders, and all edges of triangles whose plane meets the light, are therefore in.
/// Appends indices into Adjacency::edges, ascending.
/// @param light_local  light_region().in(local from world); mirrored transforms need no care
void find_region_silhouettes(const Mesh& mesh, const Adjacency& adjacency, const LightRegion& light_local,
                             std::vector<std::uint32_t>& out);

}  // namespace penumbra
