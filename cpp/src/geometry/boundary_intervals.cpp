#include "geometry/boundary_intervals.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>

namespace penumbra {

namespace {

/// Products of two differences of coordinates: |coordinate| <= 2^61, so a difference fits 62 bits, a product 124.
__extension__ using Wide = __int128;

constexpr double kGridPerUnit = 0x1p60;
constexpr double kUnitPerGrid = 0x1p-60;

constexpr std::uint32_t kNone = 0xFFFFFFFFU;

/// |coordinate| <= 2^61, so this fits 31 bits.
std::int32_t coarse(std::int64_t coordinate) noexcept {
    return static_cast<std::int32_t>(coordinate >> 31);
}

template <typename Point>
Wide cross(const Point& a, const Point& b, const Point& p) noexcept {
    return static_cast<Wide>(b.u - a.u) * (p.v - a.v) - static_cast<Wide>(b.v - a.v) * (p.u - a.u);
}

}  // namespace

bool BoundaryIntervals::to_grid(const glm::dvec2& point, Point& out) noexcept {
    if (!(std::abs(point.x) <= kLimit && std::abs(point.y) <= kLimit)) {
        return false;  // NaN ends here too
    }
    out = {static_cast<std::int64_t>(std::nearbyint(point.x * kGridPerUnit)),
           static_cast<std::int64_t>(std::nearbyint(point.y * kGridPerUnit))};
    return true;
}

glm::dvec2 BoundaryIntervals::from_grid(const Point& point) noexcept {
    return glm::dvec2{static_cast<double>(point.u) * kUnitPerGrid, static_cast<double>(point.v) * kUnitPerGrid};
}

int BoundaryIntervals::side(const Point& a, const Point& b, const Point& p) noexcept {
    const Wide doubled_area = cross(a, b, p);
    return static_cast<int>(doubled_area > 0) - static_cast<int>(doubled_area < 0);
}

// Narrows `part` of the edge from -> to (parameter 0 .. 1) to what lies on the left of the line a -> b; nothing left
// is from >= to. If the whole edge lies on the line, `part` stays and the tie is told.
BoundaryIntervals::Tie BoundaryIntervals::cut_left_of(const Point& a, const Point& b, const Point& from,
                                                      const Point& to, Interval& part) noexcept {
    const Wide at_from = cross(a, b, from);
    const Wide at_to = cross(a, b, to);
    if (at_from <= 0 && at_to <= 0) {
        if (at_from == 0 && at_to == 0) {
            const Wide along =
                static_cast<Wide>(b.u - a.u) * (to.u - from.u) + static_cast<Wide>(b.v - a.v) * (to.v - from.v);
            return along > 0 ? Tie::SameDirection : Tie::OppositeDirection;
        }
        part.to = part.from;
        return Tie::None;
    }
    if (at_from >= 0 && at_to >= 0) {
        return Tie::None;
    }
    // Both terms are exact integers until here, so the quotient is good to its last digits even where the edges are
    // nearly parallel, and both edges of a crossing agree on the point.
    const double t = static_cast<double>(at_from) / static_cast<double>(at_from - at_to);
    if (at_from < 0) {
        part.from = std::max(part.from, t);
    } else {
        part.to = std::min(part.to, t);
    }
    return Tie::None;
}

// A blocker's box is (high u, high v, ~low u, ~low v), an edge's (low u, low v, ~high u, ~high v): they overlap if and
// only if no component of the edge's is larger. Coordinates lose their low bits by a shift that rounds down, which
// keeps "<=", so boxes that touch never count as apart.
BoundaryIntervals::Box BoundaryIntervals::box_as_blocker(const Triangle& triangle) noexcept {
    const auto& [a, b, c] = triangle.corner;
    return Box{coarse(std::max({a.u, b.u, c.u})), coarse(std::max({a.v, b.v, c.v})), ~coarse(std::min({a.u, b.u, c.u})),
               ~coarse(std::min({a.v, b.v, c.v}))};
}

BoundaryIntervals::Box BoundaryIntervals::box_as_edge(const Point& a, const Point& b) noexcept {
    return Box{coarse(std::min(a.u, b.u)), coarse(std::min(a.v, b.v)), ~coarse(std::max(a.u, b.u)),
               ~coarse(std::max(a.v, b.v))};
}

bool BoundaryIntervals::apart(const Box& edge, const Box& blocker) noexcept {
    const auto larger = std::bit_cast<std::array<std::uint64_t, 2>>(edge > blocker);
    return (larger[0] | larger[1]) != 0;
}

bool BoundaryIntervals::set_polygon(std::span<const glm::dvec2> corners) {
    polygon_.clear();
    triangles_.clear();
    boxes_.clear();
    polygon_area_ = 0.0;
    all_covered_ = false;

    // Rounding can bend a straight side inwards by one grid step, and the interval rules ask for a strictly convex
    // polygon, so take the hull [Andrew1979] of the rounded corners.
    std::vector<Point> points;
    points.reserve(corners.size());
    for (const glm::dvec2& corner : corners) {
        Point point{};
        if (!to_grid(corner, point)) {
            return false;
        }
        points.push_back(point);
    }
    std::ranges::sort(points, [](const Point& a, const Point& b) { return a.u != b.u ? a.u < b.u : a.v < b.v; });
    const auto extend = [this](std::size_t keep, const Point& point) {
        while (polygon_.size() >= keep + 2 && side(polygon_[polygon_.size() - 2], polygon_.back(), point) <= 0) {
            polygon_.pop_back();
        }
        polygon_.push_back(point);
    };
    for (const Point& point : points) {
        extend(0, point);
    }
    const std::size_t lower = polygon_.size() - (polygon_.empty() ? 0 : 1);
    for (auto point = points.rbegin(); point != points.rend(); ++point) {
        if (point != points.rbegin()) {
            extend(lower, *point);
        }
    }
    if (!polygon_.empty()) {
        polygon_.pop_back();  // the first corner again
    }
    if (polygon_.size() < 3) {
        polygon_.clear();
        return false;
    }
    for (std::size_t i = 2; i < polygon_.size(); ++i) {
        const Wide doubled_area = cross(polygon_[0], polygon_[i - 1], polygon_[i]);
        polygon_area_ += 0.5 * static_cast<double>(doubled_area) * (kUnitPerGrid * kUnitPerGrid);
    }
    return true;
}

std::vector<glm::dvec2> BoundaryIntervals::polygon() const {
    std::vector<glm::dvec2> corners;
    corners.reserve(polygon_.size());
    for (const Point& point : polygon_) {
        corners.push_back(from_grid(point));
    }
    return corners;
}

void BoundaryIntervals::add_triangle(const glm::dvec2& a, const glm::dvec2& b, const glm::dvec2& c) {
    Triangle triangle{};
    if (polygon_.empty() || all_covered_ || !to_grid(a, triangle.corner[0]) || !to_grid(b, triangle.corner[1]) ||
        !to_grid(c, triangle.corner[2])) {
        return;
    }
    const int turn = side(triangle.corner[0], triangle.corner[1], triangle.corner[2]);
    if (turn == 0) {
        return;
    }
    if (turn < 0) {
        std::swap(triangle.corner[1], triangle.corner[2]);
    }
    // Separated by a side of the polygon: touches it at most.
    for (std::size_t i = 0; i < polygon_.size(); ++i) {
        const Point& from = polygon_[i];
        const Point& to = polygon_[i + 1 < polygon_.size() ? i + 1 : 0];
        if (side(from, to, triangle.corner[0]) <= 0 && side(from, to, triangle.corner[1]) <= 0 &&
            side(from, to, triangle.corner[2]) <= 0) {
            return;
        }
    }
    // Separated by an edge of the triangle, or all within the three of them.
    bool all_inside = true;
    for (int e = 0; e < 3; ++e) {
        bool all_outside = true;
        for (const Point& point : polygon_) {
            const int where = side(triangle.corner[e], triangle.corner[(e + 1) % 3], point);
            all_outside = all_outside && where <= 0;
            all_inside = all_inside && where >= 0;
        }
        if (all_outside) {
            return;
        }
    }
    if (all_inside) {
        all_covered_ = true;
        return;
    }
    triangles_.push_back(triangle);
    boxes_.push_back(box_as_blocker(triangle));
}

/// Takes `hidden` off the ends of `rest`, or notes it as covered where it lies in the middle.
/// @return true if nothing is left
bool BoundaryIntervals::cover(const Interval& hidden, Interval& rest) {
    if (hidden.from >= hidden.to) {
        return false;
    }
    if (hidden.from <= rest.from) {
        rest.from = std::max(rest.from, hidden.to);
    } else if (hidden.to >= rest.to) {
        rest.to = std::min(rest.to, hidden.from);
    } else {
        covered_.push_back(hidden);
    }
    return rest.from >= rest.to;
}

void BoundaryIntervals::count_uncovered(const Point& from, const Point& to, bool reversed, const Interval& part,
                                        double& doubled_area, std::vector<BoundaryPiece>* pieces) {
    std::ranges::sort(covered_, [](const Interval& a, const Interval& b) { return a.from < b.from; });
    covered_.push_back({part.to, part.to});  // closes the last gap
    const glm::dvec2 start = from_grid(from);
    const glm::dvec2 along = from_grid({to.u - from.u, to.v - from.v});
    const double moment = (start.x * along.y - start.y * along.x) * (reversed ? -1.0 : 1.0);
    double reached = part.from;
    for (const Interval& hidden : covered_) {
        const double until = std::min(hidden.from, part.to);
        if (until > reached) {
            doubled_area += (until - reached) * moment;
            if (pieces != nullptr) {
                const glm::dvec2 p = start + reached * along;
                const glm::dvec2 q = start + until * along;
                pieces->push_back(reversed ? BoundaryPiece{q, p} : BoundaryPiece{p, q});
            }
        }
        reached = std::max(reached, hidden.to);
        if (reached >= part.to) {
            break;
        }
    }
    covered_.clear();
}

void BoundaryIntervals::find_open_edges() {
    const std::size_t edges = 3 * triangles_.size();
    table_.assign(std::bit_ceil(2 * edges + 1), kNone);
    settled_.assign(edges, 0);
    const auto end = [this](std::uint32_t edge, std::uint32_t which) -> const Point& {
        return triangles_[edge / 3].corner[(edge % 3 + which) % 3];
    };
    const auto equal = [](const Point& a, const Point& b) { return a.u == b.u && a.v == b.v; };
    const auto mix = [](const Point& p) {
        return static_cast<std::uint64_t>(p.u) * 0x9E3779B97F4A7C15U +
               static_cast<std::uint64_t>(p.v) * 0xC2B2AE3D27D4EB4FU;
    };
    // Each entry stands for all edges between the same two points: the first one found. An edge in the opposite
    // direction settles it and every later one; until then, later ones in its own direction are settled by it.
    for (std::uint32_t edge = 0; edge < edges; ++edge) {
        const Point& from = end(edge, 0);
        const Point& to = end(edge, 1);
        std::size_t slot = (mix(from) + mix(to)) * 0xD6E8FEB86659FD93U >> 32U & (table_.size() - 1);
        while (table_[slot] != kNone) {
            const std::uint32_t other = table_[slot];
            const bool same = equal(end(other, 0), from) && equal(end(other, 1), to);
            const bool opposite = equal(end(other, 0), to) && equal(end(other, 1), from);
            if (same || opposite) {
                settled_[edge] = 1;
                settled_[other] |= static_cast<std::uint8_t>(opposite);
                break;
            }
            slot = (slot + 1) & (table_.size() - 1);
        }
        if (table_[slot] == kNone) {
            table_[slot] = edge;
        }
    }
    open_edges_.clear();
    for (std::uint32_t edge = 0; edge < edges; ++edge) {
        if (settled_[edge] == 0) {
            open_edges_.push_back({edge / 3, edge % 3});
        }
    }
}

double BoundaryIntervals::visible_fraction(std::vector<BoundaryPiece>* pieces) {
    if (pieces != nullptr) {
        pieces->clear();
    }
    if (polygon_.empty()) {
        return 1.0;
    }
    if (all_covered_) {
        return 0.0;
    }
    double doubled_area = 0.0;
    covered_.clear();

    // Sides of the polygon: hidden where the point just inside lies in a triangle.
    for (std::size_t i = 0; i < polygon_.size(); ++i) {
        const Point& from = polygon_[i];
        const Point& to = polygon_[i + 1 < polygon_.size() ? i + 1 : 0];
        const Box box = box_as_edge(from, to);
        Interval rest{0.0, 1.0};
        bool hidden = false;
        for (std::size_t j = 0; j < triangles_.size() && !hidden; ++j) {
            if (apart(box, boxes_[j])) {
                continue;
            }
            Interval part = rest;
            for (int e = 0; e < 3 && part.from < part.to; ++e) {
                const Point& a = triangles_[j].corner[e];
                const Point& b = triangles_[j].corner[(e + 1) % 3];
                if (cut_left_of(a, b, from, to, part) == Tie::OppositeDirection) {
                    part.to = part.from;
                }
            }
            hidden = cover(part, rest);
        }
        if (hidden) {
            covered_.clear();
        } else {
            count_uncovered(from, to, false, rest, doubled_area, pieces);
        }
    }

    // Edges of the triangles, as far as they run inside the polygon: hidden where the point just outside the
    // triangle lies in another one. What is visible lies on their right, so they count backwards.
    find_open_edges();
    for (const Edge& edge : open_edges_) {
        const std::size_t i = edge.triangle;
        const Point& from = triangles_[i].corner[edge.number];
        const Point& to = triangles_[i].corner[(edge.number + 1) % 3];
        Interval rest{0.0, 1.0};
        for (std::size_t k = 0; k < polygon_.size() && rest.from < rest.to; ++k) {
            const Point& a = polygon_[k];
            const Point& b = polygon_[k + 1 < polygon_.size() ? k + 1 : 0];
            if (cut_left_of(a, b, from, to, rest) != Tie::None) {
                rest.to = rest.from;
            }
        }
        if (rest.from >= rest.to) {
            continue;
        }
        const Box box = box_as_edge(from, to);
        bool hidden = false;
        for (std::size_t j = 0; j < triangles_.size() && !hidden; ++j) {
            if (apart(box, boxes_[j]) || j == i) {
                continue;
            }
            Interval part = rest;
            for (int e = 0; e < 3 && part.from < part.to; ++e) {
                const Point& a = triangles_[j].corner[e];
                const Point& b = triangles_[j].corner[(e + 1) % 3];
                if (cut_left_of(a, b, from, to, part) == Tie::SameDirection && j > i) {
                    part.to = part.from;
                }
            }
            hidden = cover(part, rest);
        }
        if (hidden) {
            covered_.clear();
        } else {
            count_uncovered(from, to, true, rest, doubled_area, pieces);
        }
    }
    return std::clamp(0.5 * doubled_area / polygon_area_, 0.0, 1.0);
}

}  // namespace penumbra
