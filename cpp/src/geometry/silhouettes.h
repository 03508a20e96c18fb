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
/// n = (b - a) x (c - a); facing = sign of dot(n, light - a), 0 if |.| <= kEdgeOn |b-a| |c-a| |light - a|; for a sun
/// the direction stands for light - a.
inline constexpr double kEdgeOn = 1e-6;
[[nodiscard]] int facing_of(const glm::dvec3& a, const glm::dvec3& b, const glm::dvec3& c,
                            const glm::dvec4& light) noexcept;

/// Corners have this many triangles at most; wider fans count as not paired. It ends the walk on topology that would
/// lead it round for ever, and on the device it bounds the time of one invocation.
inline constexpr int kMostFanSteps = 4096;

/// Planes that decide most facings in float32. Positions are centred and scaled into the unit ball, by a power of two;
/// plane = (n, dot(n, a)) with n as above over |b-a| |c-a|, so that no mesh over- or underflows; zero if degenerate.
/// With s = dot(plane.xyz, light.xyz) - plane.w * light.w: facing = sign of s where |s| > kSureFacing, else ask
/// facing_of().
struct FacingFrame {
    FacingFrame() = default;
    /// @param radius  no used position is farther from `middle`
    FacingFrame(const glm::dvec3& middle, double radius) noexcept;
    [[nodiscard]] glm::dvec4 plane(const glm::dvec3& a, const glm::dvec3& b, const glm::dvec3& c) const noexcept;
    /// The light over (its distance + 1): within the unit ball, w in [0, 1], 0 for a sun.
    [[nodiscard]] glm::dvec4 light(const glm::dvec4& light_local) const noexcept;

    glm::dvec3 centre{0.0};
    double scale = 1.0;
};
/// kEdgeOn and the rounding of s: 6.1 half ulps of 1 (planes, light, products and sums).
inline constexpr float kSureFacing = 1.5e-6F;

/// The oracle: float64, straight from the definition; order by edge index.
/// @param light_local  the light point in the mesh's space, w = 1; a sun: direction towards it, w = 0
/// @param mirrored     the instance's transform mirrors, so winding means the opposite
[[nodiscard]] std::vector<SilhouetteEdge> find_silhouettes(const Mesh& mesh, const Adjacency& adjacency,
                                                           const glm::dvec4& light_local, bool mirrored,
                                                           EdgeChoice choice = EdgeChoice::Silhouettes);

/// The same in a flat layout made once per mesh: plane and side arrays that are read front to back. Float planes decide
/// where they can, float64 decides near edge-on, so that the answer is find_silhouettes', in the same order.
class FlatSilhouettes {
public:
    /// Both must outlive this.
    FlatSilhouettes(const Mesh& mesh, const Adjacency& adjacency);
    /// Appends to `out`. Not thread-safe for one object (it keeps the facings).
    void find(const glm::dvec4& light_local, bool mirrored, EdgeChoice choice, std::vector<SilhouetteEdge>& out);
    [[nodiscard]] std::size_t bytes() const noexcept;

private:
    void decide_facings(const glm::dvec4& light_local);
    void find_turns();
    /// The walk of `z` from an edge of a triangle, 4 * triangle + k. @return false: topology that the turns do not know
    [[nodiscard]] bool arriving(std::uint32_t from, std::uint32_t a, bool a_first, std::uint32_t& z) const;

    const Mesh* mesh_;
    const Adjacency* adjacency_;
    FacingFrame frame_;
    std::vector<float> nx_, ny_, nz_, d_;  ///< per triangle
    std::vector<std::uint32_t> across_;    ///< per triangle 4, for its edges: the same edge in the triangle beyond
    std::vector<glm::uvec2> sides_;        ///< per edge, 2 * (4 * triangle + k) + reversed; not two: one without vote
    std::vector<std::int8_t> facing_;      ///< per triangle; one more that never votes
};

}  // namespace penumbra
