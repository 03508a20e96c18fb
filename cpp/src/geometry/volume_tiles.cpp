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

template <class P, class F>
bool all_inside(const Polygon<P>& polygon, const F& side) {
    for (int i = 0; i < polygon.count; ++i) {
        if (side(polygon.points[static_cast<std::size_t>(i)]) < 0.0) {
            return false;
        }
    }
    return true;
}

}  // namespace

std::vector<TileRectangle> rectangles_of(const TileGrid& grid, std::vector<std::int32_t>& rectangle_of) {
    std::vector<TileRectangle> found;
    rectangle_of.assign(grid.wanted.size(), -1);
    const auto free_tile = [&](int column, int row) {
        const auto i = static_cast<std::size_t>(row * grid.columns + column);
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
                    rectangle_of[static_cast<std::size_t>((row + r) * grid.columns + column + c)] =
                        static_cast<std::int32_t>(found.size());
                }
            }
            found.push_back(rectangle);
        }
    }
    return found;
}

void TileWalker::walk(const glm::dvec4& a, const glm::dvec4& b, const glm::dvec4& c, bool z_pass,
                      std::vector<std::uint32_t>& tiles) {
    // The view's rectangle, a margin wider; what is behind the eye is outside of both of two opposite sides.
    const double wide_x = 1.0 + 2.0 * kMargin_px / grid_->width_px;
    const double wide_y = 1.0 + 2.0 * kMargin_px / grid_->height_px;
    Polygon<glm::dvec4> homogeneous;
    homogeneous.add(a);
    homogeneous.add(b);
    homogeneous.add(c);
    const auto clip = [&](const auto& side) {
        if (!all_inside(homogeneous, side)) {
            homogeneous = clipped(homogeneous, side);
        }
    };
    clip([&](const glm::dvec4& p) { return wide_x * p.w - p.x; });
    clip([&](const glm::dvec4& p) { return wide_x * p.w + p.x; });
    clip([&](const glm::dvec4& p) { return wide_y * p.w - p.y; });
    clip([&](const glm::dvec4& p) { return wide_y * p.w + p.y; });
    Polygon<glm::dvec3> polygon;  // in tiles, and depth
    double bottom = std::numeric_limits<double>::infinity();
    double top = -bottom;
    for (int i = 0; i < homogeneous.count; ++i) {
        const glm::dvec4& p = homogeneous.points[static_cast<std::size_t>(i)];
        if (!(p.w > 0.0)) {
            continue;  // the eye itself
        }
        const double x = (0.5 + 0.5 * p.x / p.w) * grid_->width_px / TileGrid::kTile_px;
        const double y = (0.5 + 0.5 * p.y / p.w) * grid_->height_px / TileGrid::kTile_px;
        polygon.add({x, y, std::clamp(p.z / p.w, 0.0, 1.0)});
        bottom = std::min(bottom, y);
        top = std::max(top, y);
    }
    if (polygon.count < 2) {
        return;
    }
    constexpr double kMargin = kMargin_px / TileGrid::kTile_px;
    const int first_row = std::max(0, static_cast<int>(std::floor(bottom - kMargin)));
    const int last_row = std::min(grid_->rows - 1, static_cast<int>(std::floor(top + kMargin)));
    for (int row = first_row; row <= last_row; ++row) {
        Polygon<glm::dvec3> band = polygon;
        const double y0 = row - kMargin;
        const double y1 = row + 1.0 + kMargin;
        if (bottom < y0) {
            band = clipped(band, [&](const glm::dvec3& p) { return p.y - y0; });
        }
        if (top > y1) {
            band = clipped(band, [&](const glm::dvec3& p) { return y1 - p.y; });
        }
        if (band.count == 0) {
            continue;
        }
        double left = std::numeric_limits<double>::infinity();
        double right = -left;
        for (int i = 0; i < band.count; ++i) {
            left = std::min(left, band.points[static_cast<std::size_t>(i)].x);
            right = std::max(right, band.points[static_cast<std::size_t>(i)].x);
        }
        const int first = std::max(0, static_cast<int>(std::floor(left - kMargin)));
        const int last = std::min(grid_->columns - 1, static_cast<int>(std::floor(right + kMargin)));
        if (first > last) {
            continue;
        }
        for (int column = first; column <= last; ++column) {
            low_[static_cast<std::size_t>(column)] = std::numeric_limits<float>::infinity();
            high_[static_cast<std::size_t>(column)] = -std::numeric_limits<float>::infinity();
        }
        // Depth is affine, so its extremes in a column lie on the band's outline.
        for (int i = 0; i < band.count; ++i) {
            glm::dvec3 p = band.points[static_cast<std::size_t>(i)];
            glm::dvec3 q = band.points[static_cast<std::size_t>(i + 1 < band.count ? i + 1 : 0)];
            if (p.x > q.x) {
                std::swap(p, q);
            }
            const int from = std::max(first, static_cast<int>(std::floor(p.x - kMargin)));
            const int to = std::min(last, static_cast<int>(std::floor(q.x + kMargin)));
            const double per_x = q.x > p.x ? (q.z - p.z) / (q.x - p.x) : 0.0;
            for (int column = from; column <= to; ++column) {
                float z0 = 0.0F;
                float z1 = 0.0F;
                if (from == to || q.x - p.x < 1e-9) {
                    z0 = static_cast<float>(p.z);
                    z1 = static_cast<float>(q.z);
                } else {
                    z0 = static_cast<float>(p.z + per_x * (std::max(p.x, column - kMargin) - p.x));
                    z1 = static_cast<float>(p.z + per_x * (std::min(q.x, column + 1.0 + kMargin) - p.x));
                }
                float& low = low_[static_cast<std::size_t>(column)];
                float& high = high_[static_cast<std::size_t>(column)];
                low = std::min(low, std::min(z0, z1));
                high = std::max(high, std::max(z0, z1));
            }
        }
        for (int column = first; column <= last; ++column) {
            const auto i = static_cast<std::size_t>(row * grid_->columns + column);
            const auto k = static_cast<std::size_t>(column);
            if (grid_->wanted[i] == 0) {
                continue;
            }
            // Fragments before all that is seen do not fail, those behind all of it do not pass. What no edge told of
            // (rounding) is kept.
            const bool matters =
                !(low_[k] <= high_[k]) || (z_pass ? high_[k] * (1.0F + kDepthSlack) >= grid_->farthest[i]
                                                  : low_[k] * (1.0F - kDepthSlack) <= grid_->nearest[i]);
            if (matters) {
                tiles.push_back(static_cast<std::uint32_t>(i));
            }
        }
    }
}

}  // namespace penumbra
