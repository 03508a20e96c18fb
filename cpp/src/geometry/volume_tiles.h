#pragma once

#include <cstdint>
#include <glm/glm.hpp>
#include <span>
#include <vector>

namespace penumbra {

/// Square tiles of an image, row by row from the bottom.
struct TileGrid {
    static constexpr int kTile_px = 16;

    int width_px = 0, height_px = 0;
    int columns = 0, rows = 0;
    std::vector<std::uint8_t> wanted;      ///< 1: polygons matter there
    std::vector<float> nearest, farthest;  ///< of what is seen in each tile: reversed depth, 1 near, 0 far

    TileGrid() = default;
    TileGrid(int width, int height)
        : width_px{width},
          height_px{height},
          columns{(width + kTile_px - 1) / kTile_px},
          rows{(height + kTile_px - 1) / kTile_px},
          wanted(static_cast<std::size_t>(columns) * static_cast<std::size_t>(rows), 0),
          nearest(wanted.size(), 0.0F),
          farthest(wanted.size(), 1.0F) {}
    [[nodiscard]] std::size_t tile_of(int x_px, int y_px) const noexcept {
        return static_cast<std::size_t>(y_px / kTile_px) * static_cast<std::size_t>(columns) +
               static_cast<std::size_t>(x_px / kTile_px);
    }
};

/// A rectangle of wanted tiles, in tiles.
struct TileRectangle {
    int column = 0, row = 0, columns = 0, rows = 0;
};

/// Disjoint rectangles that hold every wanted tile and no other. @param rectangle_of  per tile, -1 where not wanted
[[nodiscard]] std::vector<TileRectangle> rectangles_of(const TileGrid& grid, std::vector<std::int32_t>& rectangle_of);

/// Which wanted tiles a polygon may touch, at a depth that matters.
class TileWalker {
public:
    /// @param grid  must outlive this
    explicit TileWalker(const TileGrid& grid);

    /// Appends tiles. Conservative: a tile left out holds no fragment of the triangle that behind (z-fail) or before
    /// (z-pass) what is seen there.
    /// @param clip  homogeneous, reversed depth; w = 0 and w < 0 allowed
    void walk(const glm::dvec4& a, const glm::dvec4& b, const glm::dvec4& c, bool z_pass,
              std::vector<std::uint32_t>& tiles);

private:
    void walk_row(const glm::vec3* points, int count, int row, bool z_pass, std::vector<std::uint32_t>& tiles);

    const TileGrid* grid_;
    std::vector<std::uint32_t> wanted_before_;  ///< per row: wanted tiles before each column, and before the end
    std::vector<float> low_, high_;             ///< depths in the columns of the row at hand
    float slack_ = 0.0F;                        ///< of the depths of the polygon at hand
    int first_row_, last_row_ = -1;             ///< that hold wanted tiles
};

}  // namespace penumbra
