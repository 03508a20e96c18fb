#pragma once

#include <cstdint>
#include <glm/glm.hpp>
#include <vector>

#include "geometry/adjacency.h"
#include "penumbra/scene.h"
#include "scene/bounds.h"

namespace penumbra {

/// Which triangles bound a mesh's shadow volume [Crow1977, Bergeron1986]. A point p is in shadow if the segment from
/// the light to p crosses one of them. Averted triangles are turned round, so that all of them face the light.
enum class VolumeFaces {
    Towards,  ///< those whose front faces the light
    Averted,  ///< those whose back does
    All,      ///< every triangle: right for whatever mesh, at twice the work
};

/// What the light sees of a triangle. Of one that it sees edge-on, nothing: it shades nothing, and its volume is none.
enum TriangleFacing : std::uint8_t { FacesAway = 0, FacesLight = 1, SeenEdgeOn = 2 };
[[nodiscard]] constexpr bool bounds_volume(std::uint8_t facing, VolumeFaces faces) noexcept {
    return facing != SeenEdgeOn &&
           (faces == VolumeFaces::All || (facing == FacesLight) == (faces == VolumeFaces::Towards));
}

/// How far a mesh is a solid.
struct Closure {
    bool closed = false;       ///< every edge is run as often one way as the other, so "inside" has a meaning
    int outwards = 0;          ///< closed: 1 if the normals of every shell look out, -1 in, 0 some here and some there
    std::uint32_t shells = 0;  ///< connected pieces
    /// Per triangle, closed meshes: the number of its shell, from 1, if that is convex, so that no ray enters it twice;
    /// else 0.
    std::vector<std::uint32_t> convex_shell;
};
[[nodiscard]] Closure closure_of(const Mesh& mesh, const Adjacency& adjacency);

/// How often the closed mesh winds around p: the sum of solid angles over 4 pi; an integer but for rounding.
[[nodiscard]] double winding_number(const Mesh& mesh, const glm::dvec3& p) noexcept;

/// The fewest triangles that give the truth, by which every triangle blocks from both sides. Of a solid that the light
/// is outside of, the first thing a ray crosses faces the light; from inside, it is averted. All others need all.
/// @param light_local  the light point in the mesh's space, w = 1; a sun: direction towards it, w = 0
[[nodiscard]] VolumeFaces volume_faces(const Closure& closure, const Mesh& mesh, const Bounds& bounds_local,
                                       const glm::dvec4& light_local) noexcept;

/// Signed multiplicity of an edge: how often the sides of the volume run it from v0 to v1 (negative: from v1 to v0).
/// Non-zero on silhouettes of solids (1, with VolumeFaces::All 2), on borders and where triangles crowd.
/// @param towards  per triangle, a TriangleFacing
[[nodiscard]] int edge_multiplicity(const Adjacency& adjacency, const Adjacency::Edge& edge,
                                    const std::uint8_t* towards, VolumeFaces faces) noexcept;

/// Sides that the mesh's edges can have at most, whatever the light.
[[nodiscard]] std::uint64_t most_sides(const Adjacency& adjacency, VolumeFaces faces) noexcept;

/// The oracle: how many triangles of the volume the open segment from the light to p crosses.
/// @param except  a triangle that does not count: the one that p lies on; -1 for none
[[nodiscard]] int count_crossings(const Mesh& mesh, const glm::dvec4& light_local, const glm::dvec3& p_local,
                                  VolumeFaces faces, std::int64_t except = -1) noexcept;

/// A volume as an index list over vertices that stand twice: 2 v in place, 2 v + 1 cast to infinity.
struct VolumeIndices {
    std::vector<std::uint32_t> wound;    ///< triangles whose outer side the mesh's own winding shows
    std::vector<std::uint32_t> flipped;  ///< averted near caps in the mesh's own vertex order, so outer side reversed
    void clear() {
        wound.clear();
        flipped.clear();
    }
};

/// Makes volumes of one mesh, from arrays that are read front to back. Facing is decided once per triangle, in float64,
/// and used for caps and edges alike, so that volumes are closed whatever rounding decides near edge-on.
class VolumeMaker {
public:
    struct Options {
        bool near_caps = true;
        bool far_caps = true;   ///< false: the far ends meet in one point (a sun seen in perspective)
        bool far_edges = true;  ///< false likewise: sides are triangles
    };
    /// Both must outlive this.
    VolumeMaker(const Mesh& mesh, const Adjacency& adjacency);
    /// Appends. Not thread-safe for one object (it keeps the facings).
    /// @param first_vertex  of the mesh among all
    void append(const glm::dvec4& light_local, VolumeFaces faces, const Options& options, std::uint32_t first_vertex,
                VolumeIndices& out);

    /// Decides which triangles face the light; append() does it as well.
    void face(const glm::dvec4& light_local);
    /// As last faced: calls f(triangle) for each triangle of the volume.
    template <class F>
    void for_triangles(VolumeFaces faces, const F& f) const {
        for (std::uint32_t t = 0; t < towards_.size(); ++t) {
            if (bounds_volume(towards_[t], faces)) {
                f(t);
            }
        }
    }
    [[nodiscard]] const Closure& closure() const noexcept { return closure_; }
    [[nodiscard]] const Bounds& bounds_local() const noexcept { return bounds_; }
    [[nodiscard]] std::size_t bytes() const noexcept;

private:
    const Mesh* mesh_;
    const Adjacency* adjacency_;
    Bounds bounds_;
    Closure closure_;
    glm::dvec3 centre_;
    std::vector<glm::dvec4> planes_;  ///< per triangle: normal, and its product with a corner, about centre_
    std::vector<std::uint8_t> towards_;
};

}  // namespace penumbra
