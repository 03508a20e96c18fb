#include "geometry/shadow_volume.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <numbers>
#include <numeric>

namespace penumbra {

namespace {

template <class F>
void for_sides(const Adjacency& adjacency, const Adjacency::Edge& edge, const F& f) {
    if (edge.side1 == Adjacency::kNone) {
        f(edge.side0);
    } else if ((edge.side1 & Adjacency::kMany) == 0) {
        f(edge.side0);
        f(edge.side1);
    } else {
        for (std::uint32_t i = 0; i < (edge.side1 & ~Adjacency::kMany); ++i) {
            f(adjacency.more_sides[edge.side0 + i]);
        }
    }
}

TriangleFacing facing(double height) noexcept {
    return height > 0.0 ? FacesLight : (height < 0.0 ? FacesAway : SeenEdgeOn);
}

glm::dvec3 corner(const Mesh& mesh, std::uint32_t v) {
    return glm::dvec3{mesh.positions_local[v]};
}

/// Sign of the volume of the tetrahedron (a, b, c, d): d before or behind the triangle's front.
double side_of(const glm::dvec3& a, const glm::dvec3& b, const glm::dvec3& c, const glm::dvec3& d) {
    return glm::dot(glm::cross(b - a, c - a), d - a);
}

/// Of a triangle seen from p, positive from behind [VanOosteromStrackee1983].
double solid_angle(const glm::dvec3& at_a, const glm::dvec3& at_b, const glm::dvec3& at_c, const glm::dvec3& p) {
    const glm::dvec3 a = at_a - p;
    const glm::dvec3 b = at_b - p;
    const glm::dvec3 c = at_c - p;
    const double la = glm::length(a);
    const double lb = glm::length(b);
    const double lc = glm::length(c);
    return 2.0 * std::atan2(glm::dot(a, glm::cross(b, c)),
                            la * lb * lc + glm::dot(a, b) * lc + glm::dot(b, c) * la + glm::dot(c, a) * lb);
}

class Pieces {
public:
    explicit Pieces(std::size_t count) : parent_(count) { std::iota(parent_.begin(), parent_.end(), 0U); }
    std::uint32_t find(std::uint32_t i) {
        while (parent_[i] != i) {
            parent_[i] = parent_[parent_[i]];
            i = parent_[i];
        }
        return i;
    }
    void join(std::uint32_t a, std::uint32_t b) { parent_[find(a)] = find(b); }

private:
    std::vector<std::uint32_t> parent_;
};

/// Sine of a dent that the rounding of float32 corners leaves in a plane quad.
constexpr double kFlat = 4e-6;

/// Convex at every edge, and wound once around its middle.
void find_convex_shells(const Mesh& mesh, const Adjacency& adjacency, int outwards, Pieces& pieces, Closure& closure) {
    const std::size_t count = mesh.triangles.size();
    std::vector<std::uint8_t> convex(count, 1);
    const auto opposite = [&](std::uint32_t t, const Adjacency::Edge& edge) {
        const glm::uvec3& v = mesh.triangles[t];
        for (const std::uint32_t i : {v.x, v.y, v.z}) {
            if (adjacency.welded[i] != edge.v0 && adjacency.welded[i] != edge.v1) {
                return corner(mesh, i);
            }
        }
        return corner(mesh, v.x);
    };
    for (const Adjacency::Edge& edge : adjacency.edges) {
        const bool two = edge.side1 != Adjacency::kNone && (edge.side1 & Adjacency::kMany) == 0;
        const std::uint32_t t = two ? edge.side0 / 2 : adjacency.more_sides[edge.side0] / 2;
        if (two) {
            const glm::uvec3& v = mesh.triangles[t];
            const glm::dvec3 a = corner(mesh, v.x);
            const glm::dvec3 n = glm::cross(corner(mesh, v.y) - a, corner(mesh, v.z) - a);
            const glm::dvec3 other = opposite(edge.side1 / 2, edge) - a;
            if (outwards * glm::dot(n, other) <= kFlat * glm::length(n) * glm::length(other)) {
                continue;
            }
        }
        convex[pieces.find(t)] = 0;
    }
    std::vector<glm::dvec4> middle(count, glm::dvec4{0.0});
    std::vector<double> angle(count, 0.0);
    for (std::uint32_t t = 0; t < count; ++t) {
        const glm::uvec3& v = mesh.triangles[t];
        middle[pieces.find(t)] += glm::dvec4{corner(mesh, v.x) + corner(mesh, v.y) + corner(mesh, v.z), 3.0};
    }
    closure.convex_shell.assign(count, 0);
    for (std::uint32_t t = 0; t < count; ++t) {
        const std::uint32_t shell = pieces.find(t);
        const glm::uvec3& v = mesh.triangles[t];
        angle[shell] += solid_angle(corner(mesh, v.x), corner(mesh, v.y), corner(mesh, v.z),
                                    glm::dvec3{middle[shell]} / middle[shell].w);
    }
    for (std::uint32_t t = 0; t < count; ++t) {
        const std::uint32_t shell = pieces.find(t);
        const bool once = std::abs(outwards * angle[shell] / (4.0 * std::numbers::pi) - 1.0) < 0.1;
        closure.convex_shell[t] = convex[shell] != 0 && once ? shell + 1 : 0;
    }
}

}  // namespace

Closure closure_of(const Mesh& mesh, const Adjacency& adjacency) {
    Closure closure;
    Pieces pieces{mesh.triangles.size()};
    closure.closed = !adjacency.edges.empty();
    for (const Adjacency::Edge& edge : adjacency.edges) {
        int sum = 0;
        const std::uint32_t first = (edge.side1 == Adjacency::kNone || (edge.side1 & Adjacency::kMany) == 0)
                                        ? edge.side0 / 2
                                        : adjacency.more_sides[edge.side0] / 2;
        for_sides(adjacency, edge, [&](std::uint32_t side) {
            sum += (side & 1U) != 0 ? -1 : 1;
            pieces.join(first, side / 2);
        });
        closure.closed = closure.closed && sum == 0;
    }
    std::vector<double> volume(mesh.triangles.size(), 0.0);
    std::vector<std::uint8_t> used(mesh.triangles.size(), 0);
    const glm::dvec3 centre = bounds_of(mesh).centre();
    for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t) {
        if (adjacency.triangle_edges[t].x == Adjacency::kNone) {
            continue;
        }
        const glm::uvec3& v = mesh.triangles[t];
        const std::uint32_t shell = pieces.find(t);
        used[shell] = 1;
        volume[shell] +=
            glm::dot(corner(mesh, v.x) - centre, glm::cross(corner(mesh, v.y) - centre, corner(mesh, v.z) - centre));
    }
    bool any_out = false;
    bool any_in = false;
    for (std::size_t i = 0; i < volume.size(); ++i) {
        closure.shells += used[i];
        any_out = any_out || (used[i] != 0 && volume[i] > 0.0);
        any_in = any_in || (used[i] != 0 && !(volume[i] > 0.0));
    }
    closure.outwards = closure.closed ? static_cast<int>(any_out) - static_cast<int>(any_in) : 0;
    if (closure.outwards != 0) {
        find_convex_shells(mesh, adjacency, closure.outwards, pieces, closure);
    }
    return closure;
}

double winding_number(const Mesh& mesh, const glm::dvec3& p) noexcept {
    double sum = 0.0;
    for (const glm::uvec3& v : mesh.triangles) {
        sum += solid_angle(corner(mesh, v.x), corner(mesh, v.y), corner(mesh, v.z), p);
    }
    return sum / (4.0 * std::numbers::pi);
}

VolumeFaces volume_faces(const Closure& closure, const Mesh& mesh, const Bounds& bounds_local,
                         const glm::dvec4& light_local) noexcept {
    if (!closure.closed || closure.outwards == 0) {
        return VolumeFaces::All;
    }
    const glm::dvec3 light{light_local};
    const bool may_be_inside = light_local.w != 0.0 && glm::all(glm::greaterThanEqual(light, bounds_local.low)) &&
                               glm::all(glm::lessThanEqual(light, bounds_local.high));
    const double inside = may_be_inside ? closure.outwards * winding_number(mesh, light) : 0.0;
    if (std::abs(inside) < 0.25) {
        return closure.outwards > 0 ? VolumeFaces::Towards : VolumeFaces::Averted;
    }
    // From within one of several shells, others may face the light; and a light on the surface is neither in nor out.
    if (closure.shells == 1 && std::abs(inside - 1.0) < 0.25) {
        return closure.outwards > 0 ? VolumeFaces::Averted : VolumeFaces::Towards;
    }
    return VolumeFaces::All;
}

int edge_multiplicity(const Adjacency& adjacency, const Adjacency::Edge& edge, const std::uint8_t* towards,
                      VolumeFaces faces) noexcept {
    int m = 0;
    for_sides(adjacency, edge, [&](std::uint32_t side) {
        const std::uint8_t seen = towards[side / 2];
        if (bounds_volume(seen, faces)) {
            m += ((side & 1U) != 0) == (seen == FacesLight) ? -1 : 1;
        }
    });
    return m;
}

std::uint64_t most_sides(const Adjacency& adjacency, VolumeFaces faces) noexcept {
    std::uint64_t sum = 0;
    for (const Adjacency::Edge& edge : adjacency.edges) {
        std::uint64_t along = 0;
        std::uint64_t against = 0;
        for_sides(adjacency, edge, [&](std::uint32_t side) { ++((side & 1U) != 0 ? against : along); });
        // With all triangles, those of either direction can add up, half of them averted.
        sum += faces == VolumeFaces::All ? along + against : std::max(along, against);
    }
    return sum;
}

int count_crossings(const Mesh& mesh, const glm::dvec4& light_local, const glm::dvec3& p_local, VolumeFaces faces,
                    std::int64_t except) noexcept {
    int count = 0;
    for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
        const glm::dvec3 a = corner(mesh, mesh.triangles[t].x);
        const glm::dvec3 b = corner(mesh, mesh.triangles[t].y);
        const glm::dvec3 c = corner(mesh, mesh.triangles[t].z);
        const bool sun = light_local.w == 0.0;
        const glm::dvec3 light{light_local};
        const double at_light = sun ? glm::dot(glm::cross(b - a, c - a), light) : side_of(a, b, c, light);
        if (static_cast<std::int64_t>(t) == except || !bounds_volume(facing(at_light), faces)) {
            continue;
        }
        const double at_p = side_of(a, b, c, p_local);
        // For a sun, where the parallel to it through p pierces; for a point, the segment itself.
        const glm::dvec3 far = sun ? p_local + light : light;
        const double s0 = side_of(a, b, far, p_local);
        const double s1 = side_of(b, c, far, p_local);
        const double s2 = side_of(c, a, far, p_local);
        const bool through = (s0 > 0.0 && s1 > 0.0 && s2 > 0.0) || (s0 < 0.0 && s1 < 0.0 && s2 < 0.0);
        count += through && ((at_light > 0.0 && at_p < 0.0) || (at_light < 0.0 && at_p > 0.0)) ? 1 : 0;
    }
    return count;
}

VolumeMaker::VolumeMaker(const Mesh& mesh, const Adjacency& adjacency)
    : mesh_{&mesh},
      adjacency_{&adjacency},
      bounds_{bounds_of(mesh)},
      closure_{closure_of(mesh, adjacency)},
      centre_{bounds_.centre()} {
    planes_.reserve(mesh.triangles.size());
    for (const glm::uvec3& v : mesh.triangles) {
        const glm::dvec3 a = corner(mesh, v.x) - centre_;
        const glm::dvec3 n = glm::cross(corner(mesh, v.y) - corner(mesh, v.x), corner(mesh, v.z) - corner(mesh, v.x));
        planes_.emplace_back(n, glm::dot(n, a));
    }
    towards_.resize(mesh.triangles.size());
}

void VolumeMaker::face(const glm::dvec4& light_local) {
    const glm::dvec3 light = glm::dvec3{light_local} - light_local.w * centre_;
    for (std::size_t t = 0; t < planes_.size(); ++t) {
        const glm::dvec4& plane = planes_[t];
        towards_[t] = facing(plane.x * light.x + plane.y * light.y + plane.z * light.z - plane.w * light_local.w);
    }
}

void VolumeMaker::append(const glm::dvec4& light_local, VolumeFaces faces, const Options& options,
                         std::uint32_t first_vertex, VolumeIndices& out) {
    face(light_local);
    const auto near_of = [&](std::uint32_t v) { return 2 * (first_vertex + v); };
    const auto far_of = [&](std::uint32_t v) { return 2 * (first_vertex + v) + 1; };
    for (std::size_t t = 0; t < towards_.size(); ++t) {
        if (!bounds_volume(towards_[t], faces)) {
            continue;
        }
        const bool front = towards_[t] == FacesLight;
        const glm::uvec3& v = mesh_->triangles[t];
        if (options.near_caps) {
            auto& list = front ? out.wound : out.flipped;
            list.insert(list.end(), {near_of(v.x), near_of(v.y), near_of(v.z)});
        }
        if (options.far_caps && front) {
            out.wound.insert(out.wound.end(), {far_of(v.x), far_of(v.z), far_of(v.y)});
        } else if (options.far_caps) {
            out.wound.insert(out.wound.end(), {far_of(v.x), far_of(v.y), far_of(v.z)});
        }
    }
    for (const Adjacency::Edge& edge : adjacency_->edges) {
        const int m = edge_multiplicity(*adjacency_, edge, towards_.data(), faces);
        const std::uint32_t a = m > 0 ? edge.v0 : edge.v1;
        const std::uint32_t b = m > 0 ? edge.v1 : edge.v0;
        for (int i = 0; i < std::abs(m); ++i) {
            out.wound.insert(out.wound.end(), {near_of(b), near_of(a), far_of(a)});
            if (options.far_edges) {
                out.wound.insert(out.wound.end(), {near_of(b), far_of(a), far_of(b)});
            }
        }
    }
}

std::size_t VolumeMaker::bytes() const noexcept {
    return planes_.size() * sizeof(planes_[0]) + towards_.size();
}

}  // namespace penumbra
