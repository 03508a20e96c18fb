#include "geometry/simplify.h"

#include <meshoptimizer.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

namespace penumbra {

namespace {

double distance_to_triangle(const glm::dvec3& p, const glm::dvec3& a, const glm::dvec3& b, const glm::dvec3& c) {
    const glm::dvec3 ab = b - a;
    const glm::dvec3 ac = c - a;
    const glm::dvec3 ap = p - a;
    const auto to_segment = [&](const glm::dvec3& from, const glm::dvec3& to) {
        const glm::dvec3 d = to - from;
        const double squared = glm::dot(d, d);
        const double t = squared > 0.0 ? std::clamp(glm::dot(p - from, d) / squared, 0.0, 1.0) : 0.0;
        return glm::length(p - from - t * d);
    };
    const double d00 = glm::dot(ab, ab);
    const double d01 = glm::dot(ab, ac);
    const double d11 = glm::dot(ac, ac);
    const double determinant = d00 * d11 - d01 * d01;
    if (determinant > 0.0) {
        const double d20 = glm::dot(ap, ab);
        const double d21 = glm::dot(ap, ac);
        const double v = (d11 * d20 - d01 * d21) / determinant;
        const double w = (d00 * d21 - d01 * d20) / determinant;
        if (v >= 0.0 && w >= 0.0 && v + w <= 1.0) {
            return glm::length(ap - v * ab - w * ac);
        }
    }
    return std::min({to_segment(a, b), to_segment(b, c), to_segment(c, a)});
}

/// Triangles in the cells of a regular grid that their boxes touch.
class TriangleGrid {
public:
    TriangleGrid(const std::vector<glm::vec3>& positions, const std::vector<glm::uvec3>& triangles)
        : positions_{positions}, triangles_{triangles} {
        low_ = glm::dvec3{std::numeric_limits<double>::infinity()};
        glm::dvec3 high{-std::numeric_limits<double>::infinity()};
        for (const glm::uvec3& t : triangles) {
            for (int k = 0; k < 3; ++k) {
                low_ = glm::min(low_, glm::dvec3{positions[t[k]]});
                high = glm::max(high, glm::dvec3{positions[t[k]]});
            }
        }
        const double longest = std::max({high.x - low_.x, high.y - low_.y, high.z - low_.z, 1e-300});
        // About one cell per triangle of a closed surface.
        const double across = std::clamp(std::sqrt(static_cast<double>(triangles.size()) / 4.0), 1.0, 256.0);
        cell_ = longest / across;
        count_ = glm::ivec3{glm::min((high - low_) / cell_, glm::dvec3{255.0})} + 1;
        std::vector<std::pair<std::uint32_t, std::uint32_t>> entries;
        for (std::uint32_t i = 0; i < triangles.size(); ++i) {
            const auto [from, to] = cells_of(i);
            for (int z = from.z; z <= to.z; ++z) {
                for (int y = from.y; y <= to.y; ++y) {
                    for (int x = from.x; x <= to.x; ++x) {
                        entries.emplace_back(index_of({x, y, z}), i);
                    }
                }
            }
        }
        std::ranges::sort(entries);
        first_.assign(static_cast<std::size_t>(count_.x * count_.y * count_.z) + 1, 0);
        for (const auto& [cell, triangle] : entries) {
            ++first_[cell + 1];
            members_.push_back(triangle);
        }
        for (std::size_t i = 1; i < first_.size(); ++i) {
            first_[i] += first_[i - 1];
        }
    }

    [[nodiscard]] double distance(const glm::dvec3& p) const {
        const glm::ivec3 at = cell_of(p);
        double nearest = std::numeric_limits<double>::infinity();
        const int widest = std::max({count_.x, count_.y, count_.z});
        for (int ring = 0; ring <= widest; ++ring) {
            // All that lies in rings not looked at yet is farther than this.
            if (nearest <= (ring - 1) * cell_) {
                break;
            }
            const glm::ivec3 from = glm::max(at - ring, glm::ivec3{0});
            const glm::ivec3 to = glm::min(at + ring, count_ - 1);
            for (int z = from.z; z <= to.z; ++z) {
                for (int y = from.y; y <= to.y; ++y) {
                    const bool on_face = std::abs(z - at.z) == ring || std::abs(y - at.y) == ring;
                    for (int x = from.x; x <= to.x; x += on_face ? 1 : std::max(1, to.x - from.x)) {
                        if (on_face || std::abs(x - at.x) == ring) {
                            nearest = std::min(nearest, distance_in({x, y, z}, p));
                        }
                    }
                }
            }
        }
        return nearest;
    }

private:
    [[nodiscard]] glm::ivec3 cell_of(const glm::dvec3& p) const {
        return glm::ivec3{glm::clamp((p - low_) / cell_, glm::dvec3{0.0}, glm::dvec3{count_ - 1})};
    }
    [[nodiscard]] std::pair<glm::ivec3, glm::ivec3> cells_of(std::uint32_t triangle) const {
        const glm::uvec3 t = triangles_[triangle];
        const glm::dvec3 a{positions_[t.x]};
        const glm::dvec3 b{positions_[t.y]};
        const glm::dvec3 c{positions_[t.z]};
        return {cell_of(glm::min(a, glm::min(b, c))), cell_of(glm::max(a, glm::max(b, c)))};
    }
    [[nodiscard]] std::uint32_t index_of(const glm::ivec3& cell) const {
        return static_cast<std::uint32_t>((cell.z * count_.y + cell.y) * count_.x + cell.x);
    }
    [[nodiscard]] double distance_in(const glm::ivec3& cell, const glm::dvec3& p) const {
        double nearest = std::numeric_limits<double>::infinity();
        const std::uint32_t index = index_of(cell);
        for (std::uint32_t i = first_[index]; i < first_[index + 1]; ++i) {
            const glm::uvec3 t = triangles_[members_[i]];
            nearest = std::min(nearest, distance_to_triangle(p, glm::dvec3{positions_[t.x]},
                                                             glm::dvec3{positions_[t.y]}, glm::dvec3{positions_[t.z]}));
        }
        return nearest;
    }

    const std::vector<glm::vec3>& positions_;
    const std::vector<glm::uvec3>& triangles_;
    glm::dvec3 low_;
    double cell_ = 1.0;
    glm::ivec3 count_{1};
    std::vector<std::uint32_t> first_, members_;
};

double deviation_between(const Mesh& full, const Mesh& reduced) {
    double largest = 0.0;
    const TriangleGrid of_reduced{reduced.positions_local, reduced.triangles};
    std::vector<std::uint8_t> seen(full.positions_local.size(), 0);
    for (const glm::uvec3& t : full.triangles) {
        for (int k = 0; k < 3; ++k) {
            if (seen[t[k]] == 0) {
                seen[t[k]] = 1;
                largest = std::max(largest, of_reduced.distance(glm::dvec3{full.positions_local[t[k]]}));
            }
        }
    }
    const TriangleGrid of_full{full.positions_local, full.triangles};
    for (const glm::uvec3& t : reduced.triangles) {
        const glm::dvec3 a{reduced.positions_local[t.x]};
        const glm::dvec3 b{reduced.positions_local[t.y]};
        const glm::dvec3 c{reduced.positions_local[t.z]};
        for (const glm::dvec3& p : {0.5 * (a + b), 0.5 * (b + c), 0.5 * (c + a), (a + b + c) / 3.0}) {
            largest = std::max(largest, of_full.distance(p));
        }
    }
    return largest;
}

}  // namespace

SimplifiedMesh simplify(const std::shared_ptr<const Mesh>& mesh, std::size_t triangles) {
    if (mesh->triangles.size() <= triangles || mesh->triangles.empty()) {
        return {mesh, 0.0};
    }
    // Corners doubled for normals and UVs would be borders that must stay.
    const std::size_t corner_count = 3 * mesh->triangles.size();
    const auto* indices = &mesh->triangles.front().x;
    const auto* positions = &mesh->positions_local.front().x;
    std::vector<unsigned> remap(mesh->positions_local.size());
    const std::size_t welded_count = meshopt_generateVertexRemap(remap.data(), indices, corner_count, positions,
                                                                 mesh->positions_local.size(), sizeof(glm::vec3));
    std::vector<unsigned> welded(corner_count);
    std::vector<unsigned> kept(corner_count);
    std::vector<glm::vec3> points(welded_count);
    meshopt_remapIndexBuffer(welded.data(), indices, corner_count, remap.data());
    meshopt_remapVertexBuffer(points.data(), positions, mesh->positions_local.size(), sizeof(glm::vec3), remap.data());
    const std::size_t found =
        meshopt_simplify(kept.data(), welded.data(), corner_count, &points.front().x, points.size(), sizeof(glm::vec3),
                         3 * triangles, std::numeric_limits<float>::max(), 0, nullptr);
    auto reduced = std::make_shared<Mesh>();
    reduced->name = mesh->name;
    std::vector<std::uint32_t> place(points.size(), 0xffffffffU);
    for (std::size_t i = 0; i + 2 < found; i += 3) {
        glm::uvec3 t;
        for (int k = 0; k < 3; ++k) {
            std::uint32_t& at = place[kept[i + static_cast<std::size_t>(k)]];
            if (at == 0xffffffffU) {
                at = static_cast<std::uint32_t>(reduced->positions_local.size());
                reduced->positions_local.push_back(points[kept[i + static_cast<std::size_t>(k)]]);
            }
            t[k] = at;
        }
        reduced->triangles.push_back(t);
    }
    if (reduced->triangles.empty() || reduced->triangles.size() >= mesh->triangles.size()) {
        return {mesh, 0.0};
    }
    const double deviation = deviation_between(*mesh, *reduced);
    return {std::move(reduced), deviation};
}

}  // namespace penumbra
