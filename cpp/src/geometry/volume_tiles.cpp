#include "geometry/volume_tiles.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace penumbra {

namespace {

constexpr int kMost = 12;
/// Rasterisers snap vertices and clip in float32: polygons are taken this much larger.
constexpr double kMargin_px = 0.5;
/// Depths as far apart as this share are not told apart.
constexpr float kDepthSlack = 1e-4F;

template <class P>
struct Polygon {
    std::array<P, kMost> points;
    int count = 0;
    void add(const P& p) { points[static_cast<std::size_t>(count++)] = p; }
};

/// What of it has side(p) >= 0; side is affine.
template <class P, class F>
Polygon<P> clipped(const Polygon<P>& polygon, const F& side) {
    Polygon<P> kept;
    for (int i = 0; i < polygon.count; ++i) {
        const P& p = polygon.points[static_cast<std::size_t>(i)];
        const P& q = polygon.points[static_cast<std::size_t>(i + 1 < polygon.count ? i + 1 : 0)];
        const double sp = side(p);
        const double sq = side(q);
        if (sp >= 0.0) {
            kept.add(p);
        }
        if ((sp >= 0.0) != (sq >= 0.0)) {
            kept.add(p + (sp / (sp - sq)) * (q - p));
        }
    }
    return kept;
}

std::size_t cell_of(const TileGrid& grid, int row, int column) noexcept {
    return static_cast<std::size_t>(row) * static_cast<std::size_t>(grid.columns) + static_cast<std::size_t>(column);
}

}  // namespace

std::vector<TileRectangle> rectangles_of(const TileGrid& grid, std::vector<std::int32_t>& rectangle_of) {
    std::vector<TileRectangle> found;
    rectangle_of.assign(grid.wanted.size(), -1);
    const auto free_tile = [&](int column, int row) {
        const auto i = cell_of(grid, row, column);
        return grid.wanted[i] != 0 && rectangle_of[i] < 0;
    };
    for (int row = 0; row < grid.rows; ++row) {
        for (int column = 0; column < grid.columns; ++column) {
            if (!free_tile(column, row)) {
                continue;
            }
            TileRectangle rectangle{column, row, 1, 1};
            while (column + rectangle.columns < grid.columns && free_tile(column + rectangle.columns, row)) {
                ++rectangle.columns;
            }
            const auto row_is_free = [&](int r) {
                for (int c = 0; c < rectangle.columns; ++c) {
                    if (!free_tile(column + c, r)) {
                        return false;
                    }
                }
                return true;
            };
            while (row + rectangle.rows < grid.rows && row_is_free(row + rectangle.rows)) {
                ++rectangle.rows;
            }
            for (int r = 0; r < rectangle.rows; ++r) {
                for (int c = 0; c < rectangle.columns; ++c) {
                    rectangle_of[cell_of(grid, row + r, column + c)] = static_cast<std::int32_t>(found.size());
                }
            }
            found.push_back(rectangle);
        }
    }
    return found;
}

TileWalker::TileWalker(const TileGrid& grid)
    : grid_{&grid},
      wanted_before_(static_cast<std::size_t>(grid.columns + 1) * static_cast<std::size_t>(grid.rows), 0),
      low_(static_cast<std::size_t>(grid.columns)),
      high_(static_cast<std::size_t>(grid.columns)),
      first_row_{grid.rows} {
    for (int row = 0; row < grid.rows; ++row) {
        std::uint32_t* before = wanted_before_.data() + static_cast<std::ptrdiff_t>(row) * (grid.columns + 1);
        for (int column = 0; column < grid.columns; ++column) {
            before[column + 1] = before[column] + grid.wanted[cell_of(grid, row, column)];
        }
        if (before[grid.columns] > 0) {
            first_row_ = std::min(first_row_, row);
            last_row_ = row;
        }
    }
}

void TileWalker::walk(const glm::dvec4& a, const glm::dvec4& b, const glm::dvec4& c, bool z_pass,
                      std::vector<std::uint32_t>& tiles) {
    // The view's rectangle, a margin wider; what is behind the eye is outside of one of two opposite sides.
    const double wide_x = 1.0 + 2.0 * kMargin_px / grid_->width_px;
    const double wide_y = 1.0 + 2.0 * kMargin_px / grid_->height_px;
    Polygon<glm::dvec4> homogeneous;
    homogeneous.add(a);
    homogeneous.add(b);
    homogeneous.add(c);
    const auto clip = [&](const auto& side) {
        const bool ia = side(a) >= 0.0;
        const bool ib = side(b) >= 0.0;
        const bool ic = side(c) >= 0.0;
        if (!ia && !ib && !ic) {
            homogeneous.count = 0;
        } else if (!(ia && ib && ic)) {
            homogeneous = clipped(homogeneous, side);
        }
    };
    clip([&](const glm::dvec4& p) { return wide_x * p.w - p.x; });
    clip([&](const glm::dvec4& p) { return wide_x * p.w + p.x; });
    clip([&](const glm::dvec4& p) { return wide_y * p.w - p.y; });
    clip([&](const glm::dvec4& p) { return wide_y * p.w + p.y; });
    Polygon<glm::vec3> polygon;  // in tiles, and depth
    float bottom = std::numeric_limits<float>::infinity();
    float top = -bottom;
    for (int i = 0; i < homogeneous.count; ++i) {
        const glm::dvec4& p = homogeneous.points[static_cast<std::size_t>(i)];
        if (p.w > 0.0) {  // else the eye itself
            const double over_w = 1.0 / p.w;
            polygon.add({(0.5 + 0.5 * p.x * over_w) * grid_->width_px / TileGrid::kTile_px,
                         (0.5 + 0.5 * p.y * over_w) * grid_->height_px / TileGrid::kTile_px,
                         p.z * over_w});  // not clamped to 0 .. 1: clamped, it would not be affine
            bottom = std::min(bottom, polygon.points[static_cast<std::size_t>(polygon.count - 1)].y);
            top = std::max(top, polygon.points[static_cast<std::size_t>(polygon.count - 1)].y);
        }
    }
    constexpr auto kMargin = static_cast<float>(kMargin_px / TileGrid::kTile_px);
    const int first_row = std::max(first_row_, static_cast<int>(std::floor(bottom - kMargin)));
    const int last_row = std::min(last_row_, static_cast<int>(std::floor(top + kMargin)));
    if (polygon.count < 2) {
        return;
    }
    // What interpolation may lose of depths far beyond those that are seen.
    slack_ = 0.0F;
    for (int i = 0; i < polygon.count; ++i) {
        slack_ = std::max(slack_, 2e-6F * std::abs(polygon.points[static_cast<std::size_t>(i)].z));
    }
    for (int row = first_row; row <= last_row; ++row) {
        walk_row(polygon.points.data(), polygon.count, row, z_pass, tiles);
    }
}

void TileWalker::walk_row(const glm::vec3* points, int count, int row, bool z_pass, std::vector<std::uint32_t>& tiles) {
    constexpr auto kMargin = static_cast<float>(kMargin_px / TileGrid::kTile_px);
    const float y0 = static_cast<float>(row) - kMargin;
    const float y1 = static_cast<float>(row) + 1.0F + kMargin;
    // The parts of the outline within the row: from left to right, with their depths.
    struct Part {
        glm::vec2 from, to;  ///< x, depth
    };
    std::array<Part, kMost> parts;
    int part_count = 0;
    float left = std::numeric_limits<float>::infinity();
    float right = -left;
    float nearest = 0.0F;
    float farthest = 1.0F;
    for (int i = 0; i < count; ++i) {
        const glm::vec3& p = points[i];
        const glm::vec3& q = points[i + 1 < count ? i + 1 : 0];
        if (std::max(p.y, q.y) < y0 || std::min(p.y, q.y) > y1) {
            continue;
        }
        glm::vec2 from{p.x, p.z};
        glm::vec2 to{q.x, q.z};
        if (const float rise = q.y - p.y; std::abs(rise) > 1e-6F) {
            const glm::vec2 change = (to - from) / rise;
            to = from + change * (std::clamp(q.y, y0, y1) - p.y);
            from += change * (std::clamp(p.y, y0, y1) - p.y);
        }
        if (from.x > to.x) {
            std::swap(from, to);
        }
        parts[static_cast<std::size_t>(part_count++)] = {from, to};
        left = std::min(left, from.x);
        right = std::max(right, to.x);
        nearest = std::max({nearest, from.y, to.y});
        farthest = std::min({farthest, from.y, to.y});
    }
    if (part_count == 0) {
        return;
    }
    const int first = std::max(0, static_cast<int>(std::floor(left - kMargin)));
    const int last = std::min(grid_->columns - 1, static_cast<int>(std::floor(right + kMargin)));
    const std::uint32_t* before = wanted_before_.data() + static_cast<std::ptrdiff_t>(row) * (grid_->columns + 1);
    if (first > last || before[last + 1] == before[first]) {
        return;
    }
    // Depth is affine, so its extremes in a column lie on the outline within it; where the row cuts the polygon,
    // between two parts' ends, that is a piece of outline as well.
    const bool wide = last > first;
    if (wide) {
        for (const bool upper : {false, true}) {
            const float y = upper ? y1 : y0;
            std::array<glm::vec2, 2> ends;
            int found = 0;
            for (int i = 0; i < count; ++i) {
                const glm::vec3& p = points[i];
                const glm::vec3& q = points[i + 1 < count ? i + 1 : 0];
                if ((p.y <= y) != (q.y <= y) && found < 2) {
                    const float t = (y - p.y) / (q.y - p.y);
                    ends[static_cast<std::size_t>(found++)] = {p.x + t * (q.x - p.x), p.z + t * (q.z - p.z)};
                }
            }
            if (found == 2) {
                const bool swap = ends[0].x > ends[1].x;
                parts[static_cast<std::size_t>(part_count++)] = {ends[swap ? 1 : 0], ends[swap ? 0 : 1]};
            }
        }
        std::fill(low_.begin() + first, low_.begin() + last + 1, std::numeric_limits<float>::infinity());
        std::fill(high_.begin() + first, high_.begin() + last + 1, -std::numeric_limits<float>::infinity());
        for (int i = 0; i < part_count; ++i) {
            const Part& part = parts[static_cast<std::size_t>(i)];
            const int from = std::max(first, static_cast<int>(std::floor(part.from.x - kMargin)));
            const int to = std::min(last, static_cast<int>(std::floor(part.to.x + kMargin)));
            const float width = part.to.x - part.from.x;
            const float change = width > 1e-6F ? (part.to.y - part.from.y) / width : 0.0F;
            for (int column = from; column <= to; ++column) {
                const float x0 = std::max(part.from.x, static_cast<float>(column) - kMargin);
                const float x1 = std::min(part.to.x, static_cast<float>(column) + 1.0F + kMargin);
                const bool whole = from == to || change == 0.0F;
                const float z0 = whole ? part.from.y : part.from.y + change * (x0 - part.from.x);
                const float z1 = whole ? part.to.y : part.from.y + change * (x1 - part.from.x);
                low_[static_cast<std::size_t>(column)] = std::min({low_[static_cast<std::size_t>(column)], z0, z1});
                high_[static_cast<std::size_t>(column)] = std::max({high_[static_cast<std::size_t>(column)], z0, z1});
            }
        }
    }
    for (int column = first; column <= last; ++column) {
        const auto i = cell_of(*grid_, row, column);
        if (grid_->wanted[i] == 0) {
            continue;
        }
        const float high = wide ? high_[static_cast<std::size_t>(column)] : nearest;
        const float low = wide ? low_[static_cast<std::size_t>(column)] : farthest;
        // Fragments before all that is seen do not fail, those behind all of it do not pass. What no part told of (by
        // rounding) is kept.
        const bool matters = !(low <= high) || (z_pass ? high * (1.0F + kDepthSlack) + slack_ >= grid_->farthest[i]
                                                       : low * (1.0F - kDepthSlack) - slack_ <= grid_->nearest[i]);
        if (matters) {
            tiles.push_back(static_cast<std::uint32_t>(i));
        }
    }
}

}  // namespace penumbra
