#pragma once

#include <glm/glm.hpp>
#include <limits>

#include "penumbra/scene.h"

namespace penumbra {

/// Axis-aligned box in float64; starts empty (low > high).
struct Bounds {
    glm::dvec3 low{std::numeric_limits<double>::infinity()};
    glm::dvec3 high{-std::numeric_limits<double>::infinity()};

    [[nodiscard]] bool empty() const noexcept { return low.x > high.x; }
    void add(const glm::dvec3& point) noexcept {
        low = glm::min(low, point);
        high = glm::max(high, point);
    }
    void add(const Bounds& other) noexcept {
        low = glm::min(low, other.low);
        high = glm::max(high, other.high);
    }
    /// Middle of the box; the origin if it is empty.
    [[nodiscard]] glm::dvec3 centre() const noexcept { return empty() ? glm::dvec3{0.0} : 0.5 * low + 0.5 * high; }
    /// Half the lengths of the edges; zero if it is empty.
    [[nodiscard]] glm::dvec3 half_size() const noexcept { return empty() ? glm::dvec3{0.0} : 0.5 * high - 0.5 * low; }
    /// Radius of the sphere around the centre that holds the box; zero if it is empty.
    [[nodiscard]] double radius() const noexcept { return glm::length(half_size()); }
};

/// Box of the vertices that triangles use (loose vertices do not count), in the mesh's own space. One pass over the
/// triangles: keep the result where a mesh has several instances or frames.
[[nodiscard]] Bounds bounds_of(const Mesh& mesh);

/// World box around `local` under an affine transform: contains the transformed box, and is tight around that box
/// though not always around the mesh in it. Empty stays empty. Source: [Arvo1990].
[[nodiscard]] Bounds transformed(const Bounds& local, const glm::dmat4& world_from_local);

/// transformed(bounds_of(*instance.mesh), instance.world_from_local).
[[nodiscard]] Bounds bounds_of(const Instance& instance);

/// Box of the light's own surface; empty for Sun, which is nowhere. Expects a light that validate() has passed.
[[nodiscard]] Bounds bounds_of(const Light& light);

/// World box of all instances, seen or not (lights not included); reads each mesh once.
[[nodiscard]] Bounds bounds_of(const Scene& scene);

}  // namespace penumbra
