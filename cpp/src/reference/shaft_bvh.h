#pragma once

#include <array>
#include <cstdint>
#include <glm/glm.hpp>
#include <span>
#include <vector>

#include "penumbra/scene.h"
#include "scene/bounds.h"

namespace penumbra {

/// A casting triangle, its corners in metres relative to the tree's anchor.
struct CastingTriangle {
    std::array<glm::dvec3, 3> corner;
};

/// All casting triangles of a scene in float64, in a tree of boxes that is asked for what a shaft can meet.
/// Built once per scene; asking is const and safe from several threads.
class ShaftBvh {
public:
    /// @param anchor_ws   subtracted from the transforms before any position is computed, so that a scene far from
    ///                    the origin keeps its digits
    /// @param region_ws   triangles whose box does not touch it are left out; an empty box keeps all
    /// Triangles with a corner that is not finite are left out.
    ShaftBvh(const Scene& scene, const glm::dvec3& anchor_ws, const Bounds& region_ws = {});

    [[nodiscard]] std::size_t triangle_count() const noexcept { return triangles_.size(); }
    /// Largest magnitude of any coordinate in the tree, in metres from the anchor.
    [[nodiscard]] double reach_m() const noexcept { return reach_m_; }

    /// Calls visit(triangle) for every triangle whose leaf's box meets the hull of `apex` and the convex `polygon`
    /// (in either direction, in one plane that does not hold the apex): conservative, in a fixed order.
    /// visit returns false to stop.
    template <typename Visit>
    void visit_shaft(const glm::dvec3& apex, std::span<const glm::dvec3> polygon, const Visit& visit) const {
        const Shaft shaft{apex, polygon};
        if (nodes_.empty()) {
            return;
        }
        std::array<std::uint32_t, 64> stack;
        std::size_t depth = 0;
        stack[depth++] = 0;
        while (depth > 0) {
            const Node& node = nodes_[stack[--depth]];
            if (shaft.misses(node.centre, node.half)) {
                continue;
            }
            if (node.count == 0) {
                stack[depth++] = node.first;
                stack[depth++] = static_cast<std::uint32_t>(&node - nodes_.data()) + 1;
                continue;
            }
            for (std::uint32_t i = node.first; i < node.first + node.count; ++i) {
                if (!visit(triangles_[i])) {
                    return;
                }
            }
        }
    }

private:
    struct Node {
        glm::dvec3 centre;    // of the box
        glm::dvec3 half;      // half its edges, rounded up
        std::uint32_t first;  // leaf: its first triangle; else: its second child (the first one follows it)
        std::uint32_t count;  // triangles in the leaf; 0: not a leaf
    };
    /// Half spaces whose intersection is the hull.
    class Shaft {
    public:
        Shaft(const glm::dvec3& apex, std::span<const glm::dvec3> polygon);
        [[nodiscard]] bool misses(const glm::dvec3& centre, const glm::dvec3& half) const noexcept;

    private:
        struct Plane {
            glm::dvec3 inwards;
            glm::dvec3 magnitude;  // |inwards|
            double slack;          // rounding of the dot products
        };
        glm::dvec3 apex_;
        double span_ = 0.0;  // height of the polygon's plane along the last plane's normal
        std::vector<Plane> planes_;
    };

    std::uint32_t build(std::uint32_t first, std::uint32_t count, int depth);

    std::vector<CastingTriangle> triangles_;
    std::vector<Node> nodes_;
    double reach_m_ = 0.0;
};

}  // namespace penumbra
