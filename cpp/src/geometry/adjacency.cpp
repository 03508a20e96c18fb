#include "geometry/adjacency.h"

#include <algorithm>
#include <array>
#include <bit>

namespace penumbra {

namespace {

using Bits = std::array<std::uint32_t, 3>;

/// -0 becomes 0, everything else stays what it is.
Bits bits_of(const glm::vec3& p) {
    return {std::bit_cast<std::uint32_t>(p.x + 0.0F), std::bit_cast<std::uint32_t>(p.y + 0.0F),
            std::bit_cast<std::uint32_t>(p.z + 0.0F)};
}

std::uint64_t hash_of(const Bits& bits) {
    std::uint64_t h = bits[0] | static_cast<std::uint64_t>(bits[1]) << 32U;
    h = (h ^ (h >> 31U)) * 0x9e3779b97f4a7c15ULL + bits[2];
    h = (h ^ (h >> 29U)) * 0xbf58476d1ce4e5b9ULL;
    return h ^ (h >> 32U);
}

/// Per vertex the first one at the same place.
std::vector<std::uint32_t> weld(const std::vector<glm::vec3>& positions) {
    std::vector<std::uint32_t> welded(positions.size());
    const std::size_t slots = std::bit_ceil(2 * positions.size() + 2);
    std::vector<std::uint32_t> first(slots, Adjacency::kNone);
    for (std::size_t i = 0; i < positions.size(); ++i) {
        const Bits bits = bits_of(positions[i]);
        std::size_t slot = hash_of(bits) & (slots - 1);
        while (first[slot] != Adjacency::kNone && bits_of(positions[first[slot]]) != bits) {
            slot = (slot + 1) & (slots - 1);
        }
        if (first[slot] == Adjacency::kNone) {
            first[slot] = static_cast<std::uint32_t>(i);
        }
        welded[i] = first[slot];
    }
    return welded;
}

/// Sides of one edge are ordered by the triangle's third corner, so that the order of triangles changes nothing.
struct HalfEdge {
    std::uint32_t v1, opposite, side;
    friend auto operator<=>(const HalfEdge&, const HalfEdge&) = default;
};

}  // namespace

std::size_t Adjacency::bytes() const noexcept {
    return welded.size() * sizeof(welded[0]) + edges.size() * sizeof(edges[0]) +
           more_sides.size() * sizeof(more_sides[0]) + triangle_edges.size() * sizeof(triangle_edges[0]);
}

Adjacency make_adjacency(const Mesh& mesh) {
    Adjacency made;
    made.welded = weld(mesh.positions_local);
    made.triangle_edges.assign(mesh.triangles.size(), glm::uvec3{Adjacency::kNone});

    // Half-edges in buckets by their smaller vertex: a counting sort, then short sorts by the other one.
    const auto corners = [&](std::size_t t) {
        const glm::uvec3& v = mesh.triangles[t];
        return std::array<std::uint32_t, 3>{made.welded[v.x], made.welded[v.y], made.welded[v.z]};
    };
    const auto degenerate = [](const std::array<std::uint32_t, 3>& c) {
        return c[0] == c[1] || c[1] == c[2] || c[2] == c[0];
    };
    std::vector<std::uint64_t> first(mesh.positions_local.size() + 1, 0);
    for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
        if (const auto c = corners(t); !degenerate(c)) {
            for (unsigned k = 0; k < 3; ++k) {
                ++first[std::min(c[k], c[(k + 1) % 3]) + 1];
            }
        }
    }
    for (std::size_t v = 1; v < first.size(); ++v) {
        first[v] += first[v - 1];
    }
    std::vector<HalfEdge> half_edges(first.back());
    std::vector<std::uint64_t> next(first.begin(), first.end() - 1);
    for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
        if (const auto c = corners(t); !degenerate(c)) {
            for (unsigned k = 0; k < 3; ++k) {
                const std::uint32_t a = c[k];
                const std::uint32_t b = c[(k + 1) % 3];
                half_edges[next[std::min(a, b)]++] = {std::max(a, b), c[(k + 2) % 3],
                                                      static_cast<std::uint32_t>(2 * t + (a > b ? 1 : 0))};
            }
        }
    }

    made.edges.reserve(half_edges.size() / 2 + 1);
    for (std::uint32_t v0 = 0; v0 + 1 < first.size(); ++v0) {
        const auto begin = half_edges.begin() + static_cast<std::ptrdiff_t>(first[v0]);
        const auto end = half_edges.begin() + static_cast<std::ptrdiff_t>(first[v0 + 1]);
        std::sort(begin, end);
        for (auto run = begin; run != end;) {
            auto stop = run;
            const auto index = static_cast<std::uint32_t>(made.edges.size());
            for (; stop != end && stop->v1 == run->v1; ++stop) {
                const std::uint32_t t = stop->side / 2;
                const auto c = corners(t);
                const std::uint32_t start = (stop->side & 1U) != 0 ? run->v1 : v0;
                made.triangle_edges[t][start == c[0] ? 0 : start == c[1] ? 1 : 2] = index;
            }
            Adjacency::Edge edge{v0, run->v1, run->side, Adjacency::kNone};
            const auto count = static_cast<std::uint32_t>(stop - run);
            if (count == 1) {
                ++made.border_edges;
            } else if (count == 2) {
                edge.side1 = run[1].side;
            } else {
                ++made.many_edges;
                edge.side0 = static_cast<std::uint32_t>(made.more_sides.size());
                edge.side1 = Adjacency::kMany | count;
                for (auto side = run; side != stop; ++side) {
                    made.more_sides.push_back(side->side);
                }
            }
            made.edges.push_back(edge);
            run = stop;
        }
    }
    return made;
}

}  // namespace penumbra
