#pragma once

#include <algorithm>
#include <array>
#include <glm/glm.hpp>
#include <utility>
#include <vector>

namespace penumbra::test {

/// Area of a square [-half, half]^2 that triangles cover, by another algorithm than the one under test: vertical slabs
/// between all corners and crossings, in each of which the covered length is linear. In long double, so that with
/// corners on a grid of 2^-26 its error is some 1e-17 of the square; a misplaced crossing of nearly parallel edges
/// moves the result by no more than the sliver between them.
inline double covered_area(const std::vector<std::array<glm::dvec2, 3>>& triangles, double half) {
    using Real = long double;
    struct Edge {
        Real x0, y0, x1, y1;
        [[nodiscard]] Real at(Real x) const { return y0 + (y1 - y0) * ((x - x0) / (x1 - x0)); }
    };
    std::vector<Edge> edges;  // left to right; three per triangle, upright ones too
    std::vector<Real> stops{-half, half};
    const auto add_edge = [&](const glm::dvec2& a, const glm::dvec2& b) {
        const bool swap = a.x > b.x;
        const glm::dvec2& p = swap ? b : a;
        const glm::dvec2& q = swap ? a : b;
        edges.push_back({p.x, p.y, q.x, q.y});
        stops.push_back(p.x);
        stops.push_back(q.x);
    };
    for (const auto& t : triangles) {
        for (int i = 0; i < 3; ++i) {
            add_edge(t[i], t[(i + 1) % 3]);
        }
    }
    std::vector<Edge> all = edges;
    all.push_back({-half, -half, half, -half});
    all.push_back({-half, half, half, half});
    for (std::size_t i = 0; i < all.size(); ++i) {
        for (std::size_t j = i + 1; j < all.size(); ++j) {
            const Edge& a = all[i];
            const Edge& b = all[j];
            const Real slope = (a.y1 - a.y0) * (b.x1 - b.x0) - (b.y1 - b.y0) * (a.x1 - a.x0);
            if (slope != 0) {
                const Real t = ((b.y0 - a.y0) * (b.x1 - b.x0) - (b.x0 - a.x0) * (b.y1 - b.y0)) / slope;
                if (t >= 0 && t <= 1) {
                    stops.push_back(a.x0 + t * (a.x1 - a.x0));
                }
            }
        }
    }
    std::sort(stops.begin(), stops.end());
    Real area = 0;
    std::vector<std::pair<Real, Real>> spans;
    for (std::size_t k = 1; k < stops.size(); ++k) {
        const Real low = std::max<Real>(stops[k - 1], -half);
        const Real high = std::min<Real>(stops[k], half);
        if (!(high > low)) {
            continue;
        }
        const Real x = (low + high) / 2;
        spans.clear();
        for (std::size_t t = 0; t < triangles.size(); ++t) {
            Real y[3];
            int count = 0;
            for (std::size_t e = 3 * t; e < 3 * t + 3; ++e) {
                if (edges[e].x0 < x && x < edges[e].x1) {
                    y[count++] = edges[e].at(x);
                }
            }
            if (count >= 2) {
                spans.emplace_back(std::max<Real>(-half, std::min(y[0], y[1])),
                                   std::min<Real>(half, std::max(y[0], y[1])));
            }
        }
        std::sort(spans.begin(), spans.end());
        Real reached = -half;
        Real length = 0;
        for (const auto& [from, to] : spans) {
            if (to > std::max(from, reached)) {
                length += to - std::max(from, reached);
                reached = to;
            }
        }
        area += length * (high - low);
    }
    return static_cast<double>(area);
}

}  // namespace penumbra::test
