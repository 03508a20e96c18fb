#include "reference/shaft_bvh.h"

#include <algorithm>
#include <cmath>

#include "scene/message.h"

namespace penumbra {

namespace {

using message::is_finite;

constexpr std::uint32_t kLeaf = 4;
/// Median splits halve the count, so 32-bit indices never come near the traversal's stack of 64.
constexpr int kMaxDepth = 60;

glm::dvec3 doubled_middle(const CastingTriangle& triangle) {
    return glm::min(triangle.corner[0], glm::min(triangle.corner[1], triangle.corner[2])) +
           glm::max(triangle.corner[0], glm::max(triangle.corner[1], triangle.corner[2]));
}

bool overlap(const Bounds& a, const Bounds& b) {
    return glm::all(glm::lessThanEqual(a.low, b.high)) && glm::all(glm::lessThanEqual(b.low, a.high));
}

}  // namespace

ShaftBvh::ShaftBvh(const Scene& scene, const glm::dvec3& anchor_ws, const Bounds& region_ws) {
    const Bounds region{region_ws.low - anchor_ws, region_ws.high - anchor_ws};
    for (const Instance& instance : scene.instances) {
        if (!instance.casts || instance.mesh == nullptr) {
            continue;
        }
        const Mesh& mesh = *instance.mesh;
        const glm::dmat3 linear{instance.world_from_local};
        const glm::dvec3 offset = glm::dvec3{instance.world_from_local[3]} - anchor_ws;
        for (const glm::uvec3& triangle : mesh.triangles) {
            CastingTriangle casting{};
            Bounds box;
            for (int i = 0; i < 3; ++i) {
                casting.corner[i] = linear * glm::dvec3{mesh.positions_local[triangle[i]]} + offset;
                box.add(casting.corner[i]);
            }
            if (!is_finite(casting.corner[0]) || !is_finite(casting.corner[1]) || !is_finite(casting.corner[2]) ||
                (!region_ws.empty() && !overlap(box, region))) {
                continue;
            }
            const glm::dvec3 far = glm::max(glm::abs(box.low), glm::abs(box.high));
            reach_m_ = std::max({reach_m_, far.x, far.y, far.z});
            triangles_.push_back(casting);
        }
    }
    if (!triangles_.empty()) {
        nodes_.reserve(triangles_.size());
        build(0, static_cast<std::uint32_t>(triangles_.size()), 0);
    }
}

std::uint32_t ShaftBvh::build(std::uint32_t first, std::uint32_t count, int depth) {
    const auto index = static_cast<std::uint32_t>(nodes_.size());
    Bounds box;
    Bounds middles;
    for (std::uint32_t i = first; i < first + count; ++i) {
        for (const glm::dvec3& corner : triangles_[i].corner) {
            box.add(corner);
        }
        middles.add(doubled_middle(triangles_[i]));
    }
    const glm::dvec3 centre = 0.5 * (box.low + box.high);
    const glm::dvec3 half = glm::max(box.high - centre, centre - box.low) * (1.0 + 1e-15);
    nodes_.push_back({centre, half, first, count});
    const glm::dvec3 extent = middles.high - middles.low;
    const int wider = extent.x >= extent.y ? 0 : 1;
    const int axis = extent[wider] >= extent.z ? wider : 2;
    if (count <= kLeaf || depth >= kMaxDepth || !(extent[axis] > 0.0)) {
        return index;
    }
    const std::uint32_t left = count / 2;
    const auto begin = triangles_.begin() + first;
    std::nth_element(begin, begin + left, begin + count, [axis](const CastingTriangle& a, const CastingTriangle& b) {
        return doubled_middle(a)[axis] < doubled_middle(b)[axis];
    });
    build(first, left, depth + 1);
    const std::uint32_t right = build(first + left, count - left, depth + 1);
    nodes_[index].first = right;
    nodes_[index].count = 0;
    return index;
}

ShaftBvh::Shaft::Shaft(const glm::dvec3& apex, std::span<const glm::dvec3> polygon) : apex_{apex} {
    glm::dvec3 middle{0.0};
    for (const glm::dvec3& corner : polygon) {
        middle += (corner - apex) / static_cast<double>(polygon.size());
    }
    glm::dvec3 area{0.0};
    for (std::size_t i = 0; i < polygon.size(); ++i) {
        const glm::dvec3 from = polygon[i] - apex;
        const glm::dvec3 to = polygon[(i + 1) % polygon.size()] - apex;
        area += glm::cross(from - middle, to - middle);
        glm::dvec3 inwards = glm::cross(from, to);
        inwards *= glm::dot(inwards, middle) < 0.0 ? -1.0 : 1.0;
        // The cross product's own rounding tilts the plane: what that moves at the distance of the box is slack.
        planes_.push_back({inwards, glm::abs(inwards), 8e-16 * glm::length(from) * glm::length(to)});
    }
    if (glm::dot(area, middle) < 0.0) {
        area = -area;
    }
    span_ = glm::dot(area, middle);
    planes_.push_back({area, glm::abs(area), 8e-16 * glm::length(area)});
}

bool ShaftBvh::Shaft::misses(const glm::dvec3& centre, const glm::dvec3& half) const noexcept {
    const glm::dvec3 offset = centre - apex_;
    const double far = glm::dot(glm::abs(offset) + half, glm::dvec3{1.0});
    for (const Plane& plane : planes_) {
        if (glm::dot(plane.inwards, offset) + glm::dot(plane.magnitude, half) < -plane.slack * far) {
            return true;
        }
    }
    const Plane& across = planes_.back();
    return glm::dot(across.inwards, offset) - glm::dot(across.magnitude, half) > span_ + across.slack * far;
}

}  // namespace penumbra
