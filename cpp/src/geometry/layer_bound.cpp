#include "geometry/layer_bound.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace penumbra {

namespace {

constexpr double kWidestTangent = 2.0;
/// Cells that a polygon is made larger by, against rounding.
constexpr double kSlack = 1e-6;

glm::dmat3 axes_with_z(const glm::dvec3& z) {
    const glm::dvec3 helper = std::abs(z.z) < 0.9 ? glm::dvec3{0, 0, 1} : glm::dvec3{0, 1, 0};
    const glm::dvec3 x = glm::normalize(glm::cross(helper, z));
    return {x, glm::cross(z, x), z};  // columns; a vector times it gives the three products
}

/// What of the polygon has dot(normal, p) >= 0.
std::vector<glm::dvec3> clipped(std::span<const glm::dvec3> polygon, const glm::dvec3& normal) {
    std::vector<glm::dvec3> kept;
    for (std::size_t i = 0; i < polygon.size(); ++i) {
        const glm::dvec3& p = polygon[i];
        const glm::dvec3& q = polygon[(i + 1) % polygon.size()];
        const double sp = glm::dot(normal, p);
        const double sq = glm::dot(normal, q);
        if (sp >= 0.0) {
            kept.push_back(p);
        }
        if ((sp >= 0.0) != (sq >= 0.0)) {
            kept.push_back(p + sp / (sp - sq) * (q - p));
        }
    }
    return kept;
}

}  // namespace

LayerBound::LayerBound(const glm::dvec4& light_ws, std::span<const Bounds> casters_ws)
    : origin_ws_{light_ws.w * glm::dvec3{light_ws}}, parallel_{light_ws.w == 0.0} {
    Bounds all;
    for (const Bounds& bounds : casters_ws) {
        all.add(bounds);
    }
    const glm::dvec3 towards = parallel_ ? -glm::dvec3{light_ws} : all.centre() - origin_ws_;
    Face window;
    window.axes = axes_with_z(glm::length(towards) > 0.0 ? glm::normalize(towards) : glm::dvec3{0, 0, -1});
    glm::dvec2 low{std::numeric_limits<double>::infinity()};
    glm::dvec2 high{-low};
    for (const Bounds& bounds : casters_ws) {
        for (unsigned i = 0; i < 8 && !cube_; ++i) {
            const glm::dvec3 corner{(i & 1U) != 0 ? bounds.high.x : bounds.low.x,
                                    (i & 2U) != 0 ? bounds.high.y : bounds.low.y,
                                    (i & 4U) != 0 ? bounds.high.z : bounds.low.z};
            const glm::dvec3 p = (corner - origin_ws_) * window.axes;
            cube_ = !parallel_ && (!(p.z > 0.0) || std::max(std::abs(p.x), std::abs(p.y)) > kWidestTangent * p.z);
            const glm::dvec2 at = parallel_ ? glm::dvec2{p} : glm::dvec2{p} / p.z;
            low = glm::min(low, at);
            high = glm::max(high, at);
        }
    }
    if (!cube_) {
        window.low = low;
        window.cells_per_unit = (kCells - 1.0) / glm::max(high - low, glm::dvec2{1e-300});
        faces_.push_back(window);
    } else {
        cells_ = kCells / 2;
        for (int axis = 0; axis < 3; ++axis) {
            for (const double sign : {1.0, -1.0}) {
                Face face;
                glm::dvec3 z{0.0};
                z[axis] = sign;
                face.axes = axes_with_z(z);
                face.cells_per_unit = glm::dvec2{0.5 * (cells_ - 1.0)};
                face.first = faces_.size() * static_cast<std::size_t>(cells_) * static_cast<std::size_t>(cells_);
                faces_.push_back(face);
            }
        }
    }
    counts_.assign(faces_.size() * static_cast<std::size_t>(cells_) * static_cast<std::size_t>(cells_), 0);
    last_.assign(counts_.size(), 0);
}

void LayerBound::add(const glm::dvec3& a_ws, const glm::dvec3& b_ws, const glm::dvec3& c_ws, std::uint32_t convex) {
    convex_ = convex;
    for (const Face& face : faces_) {
        const std::array<glm::dvec3, 3> triangle{(a_ws - origin_ws_) * face.axes, (b_ws - origin_ws_) * face.axes,
                                                 (c_ws - origin_ws_) * face.axes};
        if (!cube_ || std::max({triangle[0].z, triangle[1].z, triangle[2].z}) > 0.0) {
            add_to(face, triangle);
        }
    }
}

void LayerBound::add_to(const Face& face, std::span<const glm::dvec3> triangle_ls) {
    std::array<glm::dvec2, 8> projected;
    std::size_t count = 0;
    if (!cube_) {
        bool outside = false;
        for (const glm::dvec3& p : triangle_ls) {
            if (!parallel_ && !(p.z > 1e-6 * (std::abs(p.x) + std::abs(p.y)))) {
                ++everywhere_;
                return;
            }
            projected[count] = parallel_ ? glm::dvec2{p} : glm::dvec2{p} / p.z;
            const glm::dvec2 at = (projected[count++] - face.low) * face.cells_per_unit;
            outside = outside || at.x < 0.0 || at.y < 0.0 || at.x > cells_ || at.y > cells_;
        }
        outside_ += outside ? 1 : 0;
    } else {
        // A hair wider than the face: a ray along its border is a ray of both.
        std::vector<glm::dvec3> polygon(triangle_ls.begin(), triangle_ls.end());
        for (const glm::dvec3& side : {glm::dvec3{1, 0, 1 + 1e-9}, glm::dvec3{-1, 0, 1 + 1e-9},
                                       glm::dvec3{0, 1, 1 + 1e-9}, glm::dvec3{0, -1, 1 + 1e-9}}) {
            polygon = clipped(polygon, side);
        }
        for (const glm::dvec3& p : polygon) {
            if (p.z > 0.0) {
                projected[count++] = glm::dvec2{p} / p.z;
            }
        }
    }
    if (count > 0) {
        fill(face, {projected.data(), count});
    }
}

void LayerBound::fill(const Face& face, std::span<const glm::dvec2> polygon) {
    std::array<glm::dvec2, 8> p;
    double bottom = std::numeric_limits<double>::infinity();
    double top = -bottom;
    for (std::size_t i = 0; i < polygon.size(); ++i) {
        p[i] = (polygon[i] - face.low) * face.cells_per_unit;
        bottom = std::min(bottom, p[i].y);
        top = std::max(top, p[i].y);
    }
    // Flat casters make cells of no size, and coordinates that no integer holds.
    const auto cell = [&](double at) {
        return at > 0.0 ? static_cast<int>(std::min(std::floor(at), cells_ - 1.0)) : 0;
    };
    for (int row = cell(bottom - kSlack); row <= cell(top + kSlack); ++row) {
        // The polygon's width within the row.
        double left = std::numeric_limits<double>::infinity();
        double right = -left;
        const double y0 = row - kSlack;
        const double y1 = row + 1.0 + kSlack;
        for (std::size_t i = 0; i < polygon.size(); ++i) {
            const glm::dvec2& a = p[i];
            const glm::dvec2& b = p[(i + 1) % polygon.size()];
            if (std::max(a.y, b.y) < y0 || std::min(a.y, b.y) > y1) {
                continue;
            }
            const double rise = b.y - a.y;
            for (const double y : {std::clamp(a.y, y0, y1), std::clamp(b.y, y0, y1)}) {
                const double x = rise != 0.0 ? a.x + (y - a.y) / rise * (b.x - a.x) : a.x;
                left = std::min(left, std::clamp(x, std::min(a.x, b.x), std::max(a.x, b.x)));
                right = std::max(right, std::clamp(x, std::min(a.x, b.x), std::max(a.x, b.x)));
            }
            if (rise == 0.0) {
                left = std::min({left, a.x, b.x});
                right = std::max({right, a.x, b.x});
            }
        }
        if (left > right) {
            continue;
        }
        const std::size_t first_cell = face.first + static_cast<std::size_t>(row) * static_cast<std::size_t>(cells_);
        std::uint32_t* counts = counts_.data() + first_cell;
        std::uint32_t* last = last_.data() + first_cell;
        const int last_column = cell(right + kSlack);
        for (int column = cell(left - kSlack); column <= last_column; ++column) {
            std::uint32_t& last_convex = last[column];
            if (convex_ == 0 || last_convex != convex_) {
                last_convex = convex_;
                most_ = std::max(most_, ++counts[column]);
            }
        }
    }
}

}  // namespace penumbra
