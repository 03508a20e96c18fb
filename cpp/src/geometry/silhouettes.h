#pragma once

#include <cstdint>
#include <glm/glm.hpp>
#include <vector>

#include "geometry/adjacency.h"
#include "penumbra/scene.h"

namespace penumbra {

/// Which edges a technique asks for.
enum class EdgeChoice {
    Silhouettes,  ///< all voting triangles on one side of the edge, as the light sees it; none voting: both ways round
    LightFacing,  ///< every edge of every light-facing triangle, as the triangle runs it
    All,          ///< every edge, both ways round
};

/// An edge as the light sees it from outside the mesh's winding: walking from a to b, what blocks lies on the LEFT of
/// an observer at the light, the lit side on the right. (In a map's (x_ls, y_ls), whose z points away from the light,
/// the picture is mirrored: there the blocker lies to the right of a->b and the outer normal is (-e.y, e.x).)
struct SilhouetteEdge {
    std::uint32_t a = 0, b = 0;  ///< welded vertices
    /// Start of the silhouette edge z->a that bounds, together with a->b, one fan of triangles around a of equal
    /// facing; so that (z, a, b) is one corner of the outline. z = a if there is none (non-manifold, EdgeChoice::All).
    std::uint32_t z = 0;
    friend bool operator==(const SilhouetteEdge&, const SilhouetteEdge&) = default;
    friend auto operator<=>(const SilhouetteEdge&, const SilhouetteEdge&) = default;
};

/// Facing of a triangle towards the light: 1 light-facing, -1 averted, 0 within the rounding of edge-on (no vote).
/// n = (b - a) x (c - a); facing = sign of dot(n, light - a), 0 if |.| <= kEdgeOn |b-a| |c-a| |light - a|.
inline constexpr double kEdgeOn = 1e-6;

/// The oracle: float64, straight from the definition; order by edge index.
/// @param light_local  the light point in the mesh's space, w = 1; a sun: direction towards it, w = 0
/// @param mirrored     the instance's transform mirrors, so winding means the opposite
[[nodiscard]] std::vector<SilhouetteEdge> find_silhouettes(const Mesh& mesh, const Adjacency& adjacency,
                                                           const glm::dvec4& light_local, bool mirrored,
                                                           EdgeChoice choice = EdgeChoice::Silhouettes);

/// The same in a flat layout made once per mesh: plane and edge arrays that are read front to back
/// (research: 600+ M edges/s and core). Float planes decide where they can, float64 decides near edge-on, so that the
/// answer is find_silhouettes'.
class FlatSilhouettes {
public:
    FlatSilhouettes(const Mesh& mesh, const Adjacency& adjacency);
    /// Appends to `out`. Not thread-safe for one object (it keeps the facings).
    void find(const glm::dvec4& light_local, bool mirrored, EdgeChoice choice, std::vector<SilhouetteEdge>& out);
    [[nodiscard]] std::size_t bytes() const noexcept;

private:
    const Mesh* mesh_;
    const Adjacency* adjacency_;
    std::vector<float> nx_, ny_, nz_, d_, tolerance_;  ///< per triangle
    std::vector<std::int8_t> facing_;
};

}  // namespace penumbra
