#include "geometry/silhouettes.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "scene/bounds.h"

namespace penumbra {

namespace {

constexpr std::uint32_t kBorder = 0xffffffffU;       // no triangle beyond
constexpr std::uint32_t kUnknownTurn = 0xfffffffeU;  // several, or one that runs the edge the same way
constexpr double kFarthest = 1e12;                   // in radii of the mesh: from there on a light point is a sun

/// Facings of all triangles and the edges between them: votes, directions, fans.
class Outline {
public:
    Outline(const Mesh& mesh, const Adjacency& adjacency, const std::int8_t* facing, bool mirrored)
        : mesh_{mesh}, adjacency_{adjacency}, facing_{facing}, mirrored_{mirrored} {}

    void add_if_silhouette(std::uint32_t index, std::vector<SilhouetteEdge>& out) const {
        const Adjacency::Edge& edge = adjacency_.edges[index];
        bool left = false;
        bool right = false;
        std::uint32_t start = Adjacency::kNone;
        for_sides(edge, [&](std::uint32_t side) {
            const int vote = vote_of(side);
            left = left || vote > 0;
            right = right || vote < 0;
            // Light-facing fans come first: between them they meet every corner of a closed mesh once.
            if (vote != 0 && (start == Adjacency::kNone || (facing_[start] < 0 && facing_[side / 2] > 0))) {
                start = side / 2;
            }
        });
        if (left && right) {
            return;
        }
        if (!left && !right) {
            out.push_back({edge.v0, edge.v1, edge.v0});
            out.push_back({edge.v1, edge.v0, edge.v1});
            return;
        }
        const std::uint32_t a = left != mirrored_ ? edge.v0 : edge.v1;
        const std::uint32_t b = left != mirrored_ ? edge.v1 : edge.v0;
        out.push_back({a, b, arriving(index, a, start)});
    }

    void add_triangle_if_facing(std::uint32_t t, std::vector<SilhouetteEdge>& out) const {
        if (facing_[t] <= 0) {
            return;
        }
        for (unsigned k = 0; k < 3; ++k) {
            const auto corner = [&](unsigned i) { return adjacency_.welded[mesh_.triangles[t][(k + i) % 3]]; };
            out.push_back(mirrored_ ? SilhouetteEdge{corner(1), corner(0), corner(2)}
                                    : SilhouetteEdge{corner(0), corner(1), corner(2)});
        }
    }

private:
    template <class F>
    void for_sides(const Adjacency::Edge& edge, const F& f) const {
        if (edge.side1 == Adjacency::kNone) {
            f(edge.side0);
        } else if ((edge.side1 & Adjacency::kMany) == 0) {
            f(edge.side0);
            f(edge.side1);
        } else {
            for (std::uint32_t i = 0; i < (edge.side1 & ~Adjacency::kMany); ++i) {
                f(adjacency_.more_sides[edge.side0 + i]);
            }
        }
    }

    /// Where the triangle lies as one walks from v0 to v1, if nothing mirrors: 1 left, -1 right, 0 no vote.
    [[nodiscard]] int vote_of(std::uint32_t side) const {
        return (side & 1U) != 0 ? -facing_[side / 2] : facing_[side / 2];
    }

    /// Walks from triangle to triangle around vertex a until the next silhouette edge. @return its far end, a if none
    [[nodiscard]] std::uint32_t arriving(std::uint32_t from_edge, std::uint32_t a, std::uint32_t triangle) const {
        for (int step = 0; step < kMostFanSteps; ++step) {
            std::uint32_t next_edge = Adjacency::kNone;
            for (unsigned k = 0; k < 3; ++k) {
                const std::uint32_t e = adjacency_.triangle_edges[triangle][k];
                if (e != from_edge && (adjacency_.edges[e].v0 == a || adjacency_.edges[e].v1 == a)) {
                    next_edge = e;
                }
            }
            const Adjacency::Edge& edge = adjacency_.edges[next_edge];
            int own = 0;
            for_sides(edge, [&](std::uint32_t side) { own = side / 2 == triangle ? vote_of(side) : own; });
            const bool many = edge.side1 != Adjacency::kNone && (edge.side1 & Adjacency::kMany) != 0;
            bool silhouette = true;
            std::uint32_t across = Adjacency::kNone;
            for_sides(edge, [&](std::uint32_t side) {
                if (vote_of(side) == -own) {
                    silhouette = false;
                    // Among many, only a triangle of the same facing surely carries the same surface on.
                    if (across == Adjacency::kNone && (!many || facing_[side / 2] == facing_[triangle])) {
                        across = side / 2;
                    }
                }
            });
            if (silhouette) {
                return edge.v0 == a ? edge.v1 : edge.v0;
            }
            if (across == Adjacency::kNone) {
                return a;
            }
            from_edge = next_edge;
            triangle = across;
        }
        return a;
    }

    const Mesh& mesh_;
    const Adjacency& adjacency_;
    const std::int8_t* facing_;
    bool mirrored_;
};

void add_all_edges(const Adjacency& adjacency, std::vector<SilhouetteEdge>& out) {
    for (const Adjacency::Edge& edge : adjacency.edges) {
        out.push_back({edge.v0, edge.v1, edge.v0});
        out.push_back({edge.v1, edge.v0, edge.v1});
    }
}

int facing_in(const Mesh& mesh, std::size_t t, const glm::dvec4& light) {
    const glm::uvec3& v = mesh.triangles[t];
    return facing_of(glm::dvec3{mesh.positions_local[v.x]}, glm::dvec3{mesh.positions_local[v.y]},
                     glm::dvec3{mesh.positions_local[v.z]}, light);
}

void prefetch([[maybe_unused]] const void* address) noexcept {
#ifdef __GNUC__
    __builtin_prefetch(address);
#endif
}

/// @return false if one of them came too near to edge-on for its sign to be sure; that one is 0
bool decide_by_planes(const float* nx, const float* ny, const float* nz, const float* d, std::size_t count,
                      glm::vec4 light, std::int8_t* facing) {
    int unsure = 0;
    for (std::size_t i = 0; i < count; ++i) {
        const float s = nx[i] * light.x + ny[i] * light.y + nz[i] * light.z - d[i] * light.w;
        const int sign = static_cast<int>(s > kSureFacing) - static_cast<int>(s < -kSureFacing);
        unsure |= sign == 0 ? 1 : 0;
        facing[i] = static_cast<std::int8_t>(sign);
    }
    return unsure == 0;
}

}  // namespace

int facing_of(const glm::dvec3& a, const glm::dvec3& b, const glm::dvec3& c, const glm::dvec4& light) noexcept {
    const glm::dvec3 to_light = light.w == 0.0 ? glm::dvec3{light} : glm::dvec3{light} - a;
    const glm::dvec3 u = b - a;
    const glm::dvec3 v = c - a;
    const double s = glm::dot(glm::cross(u, v), to_light);
    const double band = kEdgeOn * glm::length(u) * glm::length(v) * glm::length(to_light);
    return static_cast<int>(s > band) - static_cast<int>(s < -band);
}

FacingFrame::FacingFrame(const glm::dvec3& middle, double radius) noexcept : centre{middle} {
    if (radius > 0.0) {
        int exponent = 0;
        static_cast<void>(std::frexp(radius, &exponent));
        scale = std::ldexp(1.0, -std::clamp(exponent, -120, 120));  // a float holds it and its inverse
    }
}

glm::dvec4 FacingFrame::plane(const glm::dvec3& a, const glm::dvec3& b, const glm::dvec3& c) const noexcept {
    const glm::dvec3 u = b - a;
    const glm::dvec3 v = c - a;
    const double lengths = glm::length(u) * glm::length(v);
    if (!(lengths > 0.0)) {
        return glm::dvec4{0.0};
    }
    const glm::dvec3 n = glm::cross(u, v) / lengths;
    return {n, glm::dot(n, scale * (a - centre))};
}

glm::dvec4 FacingFrame::light(const glm::dvec4& light_local) const noexcept {
    if (light_local.w == 0.0) {
        return {glm::normalize(glm::dvec3{light_local}), 0.0};
    }
    const glm::dvec3 p = scale * (glm::dvec3{light_local} - centre);
    const double distance = glm::length(p);
    return distance > kFarthest ? glm::dvec4{p / distance, 0.0} : glm::dvec4{p, 1.0} / (distance + 1.0);
}

std::vector<SilhouetteEdge> find_silhouettes(const Mesh& mesh, const Adjacency& adjacency,
                                             const glm::dvec4& light_local, bool mirrored, EdgeChoice choice) {
    std::vector<SilhouetteEdge> found;
    if (choice == EdgeChoice::All) {
        add_all_edges(adjacency, found);
        return found;
    }
    std::vector<std::int8_t> facing(mesh.triangles.size());
    for (std::size_t t = 0; t < facing.size(); ++t) {
        facing[t] = static_cast<std::int8_t>(facing_in(mesh, t, light_local));
    }
    const Outline outline{mesh, adjacency, facing.data(), mirrored};
    if (choice == EdgeChoice::LightFacing) {
        for (std::uint32_t t = 0; t < facing.size(); ++t) {
            outline.add_triangle_if_facing(t, found);
        }
    } else {
        for (std::uint32_t e = 0; e < adjacency.edges.size(); ++e) {
            outline.add_if_silhouette(e, found);
        }
    }
    return found;
}

FlatSilhouettes::FlatSilhouettes(const Mesh& mesh, const Adjacency& adjacency) : mesh_{&mesh}, adjacency_{&adjacency} {
    const Bounds bounds = bounds_of(mesh);
    frame_ = FacingFrame{bounds.centre(), bounds.radius()};
    for (const glm::uvec3& v : mesh.triangles) {
        const glm::vec4 plane{frame_.plane(glm::dvec3{mesh.positions_local[v.x]}, glm::dvec3{mesh.positions_local[v.y]},
                                           glm::dvec3{mesh.positions_local[v.z]})};
        nx_.push_back(plane.x);
        ny_.push_back(plane.y);
        nz_.push_back(plane.z);
        d_.push_back(plane.w);
    }
    facing_.resize(mesh.triangles.size() + 1, 0);
    const auto silent = static_cast<std::uint32_t>(8 * mesh.triangles.size());
    const auto side_in = [&](std::uint32_t side, std::uint32_t e) {
        const glm::uvec3& edges = adjacency.triangle_edges[side / 2];
        const std::uint32_t k = edges.x == e ? 0U : (edges.y == e ? 1U : 2U);
        return 8 * (side / 2) + 2 * k + (side & 1U);
    };
    sides_.reserve(adjacency.edges.size());
    for (std::uint32_t e = 0; e < adjacency.edges.size(); ++e) {
        const Adjacency::Edge& edge = adjacency.edges[e];
        const bool two = (edge.side1 & Adjacency::kMany) == 0;  // kNone has the bit as well
        sides_.push_back(two ? glm::uvec2{side_in(edge.side0, e), side_in(edge.side1, e)} : glm::uvec2{silent});
    }
    find_turns();
}

// An edge of a triangle is 4 * triangle + k, k = 0 .. 2: between its corners k and k + 1.
void FlatSilhouettes::find_turns() {
    const std::vector<glm::uvec3>& edges_of = adjacency_->triangle_edges;
    across_.assign(4 * edges_of.size(), kUnknownTurn);
    for (std::uint32_t t = 0; t < edges_of.size(); ++t) {
        for (std::uint32_t k = 0; k < 3; ++k) {
            const std::uint32_t e = edges_of[t][static_cast<int>(k)];
            if (e == Adjacency::kNone) {
                continue;
            }
            const Adjacency::Edge& edge = adjacency_->edges[e];
            if (edge.side1 == Adjacency::kNone) {
                across_[4 * t + k] = kBorder;
            } else if ((edge.side1 & Adjacency::kMany) == 0 && ((edge.side0 ^ edge.side1) & 1U) != 0) {
                const std::uint32_t other = edge.side0 / 2 == t ? edge.side1 / 2 : edge.side0 / 2;
                const glm::uvec3& there = edges_of[other];
                across_[4 * t + k] = 4 * other + (there.x == e ? 0U : (there.y == e ? 1U : 2U));
            }
        }
    }
}

bool FlatSilhouettes::arriving(std::uint32_t from, std::uint32_t a, bool a_first, std::uint32_t& z) const {
    std::uint32_t h = from;
    const std::int8_t facing = facing_[h >> 2U];
    // Two bits for each k: the other edge at the corner a, which stays first, or second, in all triangles of the fan.
    const std::uint32_t turn = a_first ? 0b01'00'10U : 0b00'10'01U;
    for (int step = 0; step < kMostFanSteps; ++step) {
        const std::uint32_t next = (h & ~3U) | ((turn >> (2 * (h & 3U))) & 3U);
        const std::uint32_t beyond = across_[next];
        if (beyond >= kUnknownTurn) {
            if (beyond == kUnknownTurn) {
                return false;
            }
        } else if (facing_[beyond >> 2U] == facing) {
            h = beyond;
            continue;
        }
        const glm::uvec3& corners = mesh_->triangles[h >> 2U];
        z = adjacency_->welded[corners[static_cast<int>(((h & 3U) + 2U) % 3U)]];
        return true;
    }
    z = a;
    return true;
}

void FlatSilhouettes::decide_facings(const glm::dvec4& light_local) {
    const glm::vec4 light{frame_.light(light_local)};
    constexpr std::size_t kBlock = 2048;
    for (std::size_t first = 0; first < nx_.size(); first += kBlock) {
        const std::size_t count = std::min(kBlock, nx_.size() - first);
        std::int8_t* facing = facing_.data() + first;
        if (!decide_by_planes(nx_.data() + first, ny_.data() + first, nz_.data() + first, d_.data() + first, count,
                              light, facing)) {
            for (std::size_t i = 0; i < count; ++i) {
                if (facing[i] == 0) {
                    facing[i] = static_cast<std::int8_t>(facing_in(*mesh_, first + i, light_local));
                }
            }
        }
    }
}

void FlatSilhouettes::find(const glm::dvec4& light_local, bool mirrored, EdgeChoice choice,
                           std::vector<SilhouetteEdge>& out) {
    if (choice == EdgeChoice::All) {
        add_all_edges(*adjacency_, out);
        return;
    }
    decide_facings(light_local);
    const Outline outline{*mesh_, *adjacency_, facing_.data(), mirrored};
    if (choice == EdgeChoice::LightFacing) {
        for (std::uint32_t t = 0; t < nx_.size(); ++t) {
            outline.add_triangle_if_facing(t, out);
        }
        return;
    }
    const std::int8_t* facing = facing_.data();
    constexpr std::size_t kBlock = 1024;
    std::array<std::uint32_t, kBlock> kept;
    for (std::size_t first = 0; first < sides_.size(); first += kBlock) {
        const std::size_t end = std::min(first + kBlock, sides_.size());
        std::size_t count = 0;
        for (std::size_t e = first; e < end; ++e) {
            // One left and one right of the edge, by far the most: run opposite ways and faced alike, or neither. No
            // branch, because on rough meshes none could be foreseen.
            const glm::uvec2 s = sides_[e];
            const int same_way = static_cast<int>((s.x ^ s.y ^ 1U) & 1U);
            kept[count] = static_cast<std::uint32_t>(e);
            count += facing[s.x >> 3U] * facing[s.y >> 3U] != 1 - 2 * same_way ? 1 : 0;
        }
        for (std::size_t i = 0; i < count; ++i) {
            const std::uint32_t e = kept[i];
            const glm::uvec2 s = sides_[e];
            // What a walk reads first, a few walks ahead: they are short, and wait for memory more than they compute.
            const glm::uvec2 soon = sides_[kept[std::min(i + 6, count - 1)]];
            prefetch(across_.data() + std::min<std::size_t>(soon.x >> 1U, across_.size() - 1));
            prefetch(across_.data() + std::min<std::size_t>(soon.y >> 1U, across_.size() - 1));
            const int vote0 = (s.x & 1U) != 0 ? -facing[s.x >> 3U] : facing[s.x >> 3U];
            const int vote1 = (s.y & 1U) != 0 ? -facing[s.y >> 3U] : facing[s.y >> 3U];
            if (vote0 == 0 && vote1 == 0) {
                outline.add_if_silhouette(e, out);
                continue;
            }
            // As Outline has it, for two triangles of which at least one votes, and not against the other.
            const bool left = vote0 + vote1 > 0;
            const Adjacency::Edge& edge = adjacency_->edges[e];
            const std::uint32_t a = left != mirrored ? edge.v0 : edge.v1;
            const std::uint32_t b = left != mirrored ? edge.v1 : edge.v0;
            const bool second = vote0 == 0 || (vote1 != 0 && facing[s.x >> 3U] < 0 && facing[s.y >> 3U] > 0);
            const std::uint32_t side = second ? s.y : s.x;
            std::uint32_t z = a;
            if (arriving(side >> 1U, a, (a == edge.v0) == ((side & 1U) == 0), z)) {
                out.push_back({a, b, z});
            } else {
                outline.add_if_silhouette(e, out);
            }
        }
    }
}

std::size_t FlatSilhouettes::bytes() const noexcept {
    return across_.size() * sizeof(across_[0]) + (nx_.size() + ny_.size() + nz_.size() + d_.size()) * sizeof(float) +
           sides_.size() * sizeof(sides_[0]) + facing_.size();
}

}  // namespace penumbra
