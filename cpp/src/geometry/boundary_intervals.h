#pragma once

#include <array>
#include <cstdint>
#include <glm/glm.hpp>
#include <span>
#include <vector>

namespace penumbra {

/// A straight piece of the boundary of what is visible, in the plane of the light; the visible side is on its left.
struct BoundaryPiece {
    glm::dvec2 from;
    glm::dvec2 to;
};

/// Area of a convex polygon that a set of triangles leaves uncovered, as one sum over the uncovered boundary: every
/// edge of the polygon and of the triangles is cut into intervals on its own. There is no sweep, no graph and no
/// clipped polygon, so there is no topology that rounding could break.
///
/// Coordinates are rounded once, on entry, to multiples of 2^-60; from there on, every question "on which side?" is
/// answered exactly in 128-bit integers. The result is thus that of an arrangement whose corners moved by less than
/// one unit in the last place of a float64 near 1, whatever slivers, T-junctions, shared, doubled or collinear edges
/// there are. Only lengths along edges and the final sum are float64.
///
/// Ties, where an edge lies exactly on another one's line:
/// - a triangle's edge on a side of the polygon never counts;
/// - a triangle's edge on another triangle's edge: running in the opposite direction it is covered, running in the
///   same direction only the triangle that came first keeps it;
/// - a side of the polygon on a triangle's edge: covered if both run in the same direction, else not.
///
/// Edges that two triangles share are settled first, by a hash of their ends: in opposite directions both are covered,
/// in the same direction one is kept. What is left of a mesh are its silhouettes, so the cost grows like the number of
/// triangles times the number of silhouette edges in front of the polygon.
///
/// Keeps its memory between uses; one object per thread.
class BoundaryIntervals {
public:
    /// Largest magnitude of a coordinate that set_polygon and add_triangle take.
    static constexpr double kLimit = 2.0;

    /// Starts anew: no triangles.
    /// @param corners convex, in either direction, each coordinate in [-2, 2]; corners that are not corners of the
    ///                convex hull are dropped
    /// @return false if the polygon has no area on the grid; the visible fraction is then defined as 1
    bool set_polygon(std::span<const glm::dvec2> corners);

    /// Adds a triangle that covers; either direction, each coordinate in [-2, 2]. One without area, or with a
    /// coordinate that is not in that range (NaN included), covers nothing.
    void add_triangle(const glm::dvec2& a, const glm::dvec2& b, const glm::dvec2& c);

    /// Area left uncovered over the area of the polygon, 0 .. 1.
    /// @param pieces if given, is replaced by the boundary of the uncovered part: closed up to rounding, in no
    ///               particular order
    [[nodiscard]] double visible_fraction(std::vector<BoundaryPiece>* pieces = nullptr);

    /// Area of the polygon as it was rounded, in squared units of the coordinates.
    [[nodiscard]] double polygon_area() const noexcept { return polygon_area_; }

    /// Corners of the polygon as they were rounded, counter-clockwise.
    [[nodiscard]] std::vector<glm::dvec2> polygon() const;

    /// Triangles added since set_polygon that can touch the polygon.
    [[nodiscard]] std::size_t triangle_count() const noexcept { return triangles_.size(); }

private:
    struct Point {
        std::int64_t u;
        std::int64_t v;
    };
    /// A bounding box on a coarser grid, as four numbers that are compared at once: see apart().
    using Box = std::int32_t __attribute__((vector_size(16)));
    struct Edge {
        std::uint32_t triangle;
        std::uint32_t number;  // from corner `number` to the next one
    };
    struct Interval {
        double from;
        double to;
    };
    struct Triangle {
        std::array<Point, 3> corner;  // counter-clockwise
    };
    /// How an edge lies on the line of the edge that cuts it.
    enum class Tie { None, SameDirection, OppositeDirection };

    static bool to_grid(const glm::dvec2& point, Point& out) noexcept;
    static glm::dvec2 from_grid(const Point& point) noexcept;
    static int side(const Point& a, const Point& b, const Point& p) noexcept;
    static Tie cut_left_of(const Point& a, const Point& b, const Point& from, const Point& to, Interval& part) noexcept;
    static Box box_as_blocker(const Triangle& triangle) noexcept;
    static Box box_as_edge(const Point& a, const Point& b) noexcept;
    static bool apart(const Box& edge, const Box& blocker) noexcept;
    /// Fills open_edges_ with the edges that are not wholly settled by an equal edge of another triangle.
    void find_open_edges();
    bool cover(const Interval& hidden, Interval& rest);
    /// Adds the parts of `part` on from -> to that no interval of covered_ hides; covered_ is used up.
    void count_uncovered(const Point& from, const Point& to, bool reversed, const Interval& part, double& doubled_area,
                         std::vector<BoundaryPiece>* pieces);

    std::vector<Point> polygon_;  // counter-clockwise, strictly convex
    std::vector<Triangle> triangles_;
    std::vector<Box> boxes_;  // of triangles_
    std::vector<Edge> open_edges_;
    std::vector<std::uint32_t> table_;  // hash table of edges: 3 triangle + number, or kNone
    std::vector<std::uint8_t> settled_;
    std::vector<Interval> covered_;
    double polygon_area_ = 0.0;
    bool all_covered_ = false;
};

}  // namespace penumbra
