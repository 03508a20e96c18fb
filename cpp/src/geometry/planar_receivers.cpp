#include "geometry/planar_receivers.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <numbers>
#include <tuple>

namespace penumbra {

namespace {

constexpr double kPi = std::numbers::pi;
constexpr double kSameTurn = 0.999;  ///< cosine between normals of one plane: tolerance is in metres, not in degrees
constexpr int kTurns = 16;           ///< directions tried for a small rectangle

/// A triangle that some pixel sees, on one of its sides.
struct SeenTriangle {
    std::array<glm::dvec3, 3> corners_ws;
    glm::dvec3 normal{0.0};  ///< unit, towards the side that is seen
    double area = 0.0;
    std::uint32_t instance = 0;
    std::uint64_t pixels = 0;
    std::uint8_t plane = PlanarReceivers::kNone;
};

/// Triangles by number, and for each pixel which one it sees.
struct Seen {
    std::vector<SeenTriangle> triangles;
    std::vector<std::uint32_t> of_pixel;
};

Seen gather(const Scene& scene, const View& view, std::span<const std::uint8_t> mask) {
    constexpr std::uint32_t kNew = 0xffffffffU;
    Seen seen;
    seen.of_pixel.assign(view.size(), kNew);
    std::vector<std::vector<std::uint32_t>> numbers(scene.instances.size());  // by instance: 2 triangle + side
    for (std::size_t i = 0; i < view.size(); ++i) {
        if (mask[i] == 0) {
            continue;
        }
        const auto instance = static_cast<std::uint32_t>(view.instance[i]);
        const Instance& placed = scene.instances[instance];
        std::vector<std::uint32_t>& of_instance = numbers[instance];
        if (of_instance.empty()) {
            of_instance.assign(2 * placed.mesh->triangles.size(), kNew);
        }
        const auto index = static_cast<std::size_t>(view.triangle[i]);
        // The side is that of the view's normal; a triangle of which both sides are seen counts as two.
        const glm::uvec3& t = placed.mesh->triangles[index];
        std::uint32_t* number = &of_instance[2 * index];
        if (number[0] == kNew) {
            SeenTriangle made;
            made.instance = instance;
            for (int k = 0; k < 3; ++k) {
                made.corners_ws[k] =
                    glm::dvec3{placed.world_from_local * glm::dvec4{placed.mesh->positions_local[t[k]], 1.0}};
            }
            const glm::dvec3 n =
                glm::cross(made.corners_ws[1] - made.corners_ws[0], made.corners_ws[2] - made.corners_ws[0]);
            made.area = 0.5 * glm::length(n);
            made.normal = made.area > 0.0 ? n / (2.0 * made.area) : glm::dvec3{0.0};
            number[0] = static_cast<std::uint32_t>(seen.triangles.size());
            seen.triangles.push_back(made);
            made.normal = -made.normal;
            number[1] = static_cast<std::uint32_t>(seen.triangles.size());
            seen.triangles.push_back(made);
        }
        const bool back = glm::dot(seen.triangles[number[0]].normal, glm::dvec3{view.normal_ws[i]}) < 0.0;
        seen.of_pixel[i] = number[back ? 1 : 0];
        ++seen.triangles[seen.of_pixel[i]].pixels;
    }
    return seen;
}

/// Triangles of about one plane.
struct Cell {
    std::uint64_t pixels = 0;
    std::uint32_t largest = 0;  ///< triangle
};

bool lies_on(const SeenTriangle& triangle, const PlanarReceiver& plane, double tolerance_m) {
    if (glm::dot(triangle.normal, plane.normal) < kSameTurn) {
        return false;
    }
    return std::ranges::all_of(triangle.corners_ws,
                               [&](const glm::dvec3& p) { return std::abs(plane.height(p)) <= tolerance_m; });
}

/// The fullest cells first; equal ones in the order of their triangles, so that the result does not hang on a map's.
std::vector<Cell> fullest_cells(const Scene& scene, const std::vector<SeenTriangle>& triangles,
                                const glm::dvec3& anchor_ws, const PlanarReceiverOptions& options, std::size_t most) {
    const std::string& only = options.only;
    const double tolerance_m = options.tolerance_m;
    using Key = std::tuple<std::int64_t, std::int64_t, std::int64_t, std::int64_t>;
    std::map<Key, Cell> cells;
    // Half a cell off, so that the axis-parallel planes of most scenes do not lie on a boundary between two cells.
    const auto number = [](double x) { return static_cast<std::int64_t>(std::floor(x + 0.37)); };
    const double offset_cell = std::max(8.0 * tolerance_m, 1e-300);
    for (std::uint32_t i = 0; i < triangles.size(); ++i) {
        const SeenTriangle& t = triangles[i];
        if (t.pixels == 0 || !(t.area > 0.0) || (!only.empty() && scene.instances[t.instance].name != only)) {
            continue;
        }
        const double offset = glm::dot(t.corners_ws[0] - anchor_ws, t.normal) / offset_cell;
        if (!(std::abs(offset) < 9e15)) {
            continue;
        }
        Cell& cell =
            cells[{number(64.0 * t.normal.x), number(64.0 * t.normal.y), number(64.0 * t.normal.z), number(offset)}];
        if (cell.pixels == 0 || t.area > triangles[cell.largest].area) {
            cell.largest = i;
        }
        cell.pixels += t.pixels;
    }
    std::vector<Cell> all;
    all.reserve(cells.size());
    for (const auto& [key, cell] : cells) {
        all.push_back(cell);
    }
    std::ranges::sort(all, [](const Cell& a, const Cell& b) {
        return a.pixels != b.pixels ? a.pixels > b.pixels : a.largest < b.largest;
    });
    all.resize(std::min(all.size(), most));
    return all;
}

/// Corners of all triangles of an instance that lie on the plane, whichever way they are turned.
void add_whole(const Instance& instance, const PlanarReceiver& plane, double tolerance_m,
               std::vector<glm::dvec2>& points) {
    for (const glm::uvec3& t : instance.mesh->triangles) {
        std::array<glm::dvec3, 3> offsets{};
        bool on = true;
        for (int k = 0; k < 3; ++k) {
            const glm::dvec4 local{instance.mesh->positions_local[t[k]], 1.0};
            offsets[k] = glm::dvec3{instance.world_from_local * local} - plane.origin_ws;
            on = on && std::abs(glm::dot(offsets[k], plane.normal)) <= tolerance_m;
        }
        for (const glm::dvec3& offset : offsets) {
            if (on) {
                points.emplace_back(glm::dot(offset, plane.axis_x), glm::dot(offset, plane.axis_y));
            }
        }
    }
}

/// Axes along the camera's right hand, so that they turn with the scene.
void choose_axes(PlanarReceiver& plane, const glm::dmat4& world_from_camera) {
    for (const int column : {0, 1}) {
        const glm::dvec3 wanted{world_from_camera[column]};
        const glm::dvec3 x = wanted - plane.normal * glm::dot(plane.normal, wanted);
        if (glm::length(x) > 0.2 * glm::length(wanted)) {
            plane.axis_x = glm::normalize(x);
            break;
        }
    }
    plane.axis_y = glm::cross(plane.normal, plane.axis_x);
}

/// Turns the axes so that the rectangle around the points is small, and notes it.
void fit_rectangle(PlanarReceiver& plane, const std::vector<glm::dvec2>& points) {
    double least = std::numeric_limits<double>::infinity();
    int best = 0;
    glm::dvec2 best_low{0.0};
    glm::dvec2 best_high{0.0};
    for (int turn = 0; turn < kTurns; ++turn) {
        const double angle = 0.5 * kPi * turn / kTurns;
        const glm::dvec2 x{std::cos(angle), std::sin(angle)};
        glm::dvec2 low{std::numeric_limits<double>::infinity()};
        glm::dvec2 high{-low};
        for (const glm::dvec2& p : points) {
            const glm::dvec2 q{glm::dot(p, x), x.x * p.y - x.y * p.x};
            low = glm::min(low, q);
            high = glm::max(high, q);
        }
        const double area = (high.x - low.x) * (high.y - low.y);
        if (turn == 0 || area < 0.9 * least) {  // a clear gain only: rounding must not turn the texture
            least = area;
            best = turn;
            best_low = low;
            best_high = high;
        }
    }
    const double angle = 0.5 * kPi * best / kTurns;
    const glm::dvec3 x = std::cos(angle) * plane.axis_x + std::sin(angle) * plane.axis_y;
    plane.axis_x = glm::normalize(x);
    plane.axis_y = glm::cross(plane.normal, plane.axis_x);
    // The origin in the middle: small coordinates for the shaders.
    const glm::dvec2 middle = 0.5 * (best_low + best_high);
    plane.origin_ws += middle.x * plane.axis_x + middle.y * plane.axis_y;
    plane.low_m = best_low - middle;
    plane.high_m = best_high - middle;
}

}  // namespace

PlanarReceivers find_planar_receivers(const Scene& scene, const View& view, std::span<const std::uint8_t> mask,
                                      const PlanarReceiverOptions& options) {
    PlanarReceivers found;
    found.plane_of_pixel.assign(view.size(), PlanarReceivers::kNone);
    Seen seen = gather(scene, view, mask);
    std::uint64_t asked = 0;
    for (const SeenTriangle& t : seen.triangles) {
        asked += t.pixels;
    }
    const auto most = static_cast<std::size_t>(std::clamp(options.most, 0, 15));
    constexpr std::size_t kSeedsPerPlane = 16;  // 15 planes: fewer seeds than kNone
    for (const Cell& cell : fullest_cells(scene, seen.triangles, view.eye_ws, options, kSeedsPerPlane * most)) {
        const SeenTriangle& seed = seen.triangles[cell.largest];
        if (std::ranges::any_of(
                found.planes, [&](const PlanarReceiver& plane) { return lies_on(seed, plane, options.tolerance_m); })) {
            continue;
        }
        PlanarReceiver plane;
        plane.normal = seed.normal;
        plane.origin_ws = (seed.corners_ws[0] + seed.corners_ws[1] + seed.corners_ws[2]) / 3.0;
        found.planes.push_back(plane);
    }
    // Every triangle goes to the first plane that it lies on; seeds are in the order of size.
    std::vector<std::map<std::uint32_t, std::uint64_t>> pixels_by_instance(found.planes.size());
    for (SeenTriangle& t : seen.triangles) {
        for (std::size_t p = 0; t.pixels > 0 && p < found.planes.size(); ++p) {
            if (lies_on(t, found.planes[p], options.tolerance_m)) {
                t.plane = static_cast<std::uint8_t>(p);
                found.planes[p].pixels += t.pixels;
                pixels_by_instance[p][t.instance] += t.pixels;
                break;
            }
        }
    }
    std::vector<std::uint8_t> order;
    for (std::size_t p = 0; p < found.planes.size(); ++p) {
        if (static_cast<double>(found.planes[p].pixels) >= options.least_share * static_cast<double>(asked) &&
            found.planes[p].pixels > 0) {
            order.push_back(static_cast<std::uint8_t>(p));
        }
    }
    std::ranges::stable_sort(
        order, [&](std::uint8_t a, std::uint8_t b) { return found.planes[a].pixels > found.planes[b].pixels; });
    order.resize(std::min(order.size(), most));
    std::vector<std::uint8_t> renumbered(found.planes.size(), PlanarReceivers::kNone);
    std::vector<PlanarReceiver> kept;
    for (const std::uint8_t p : order) {
        renumbered[p] = static_cast<std::uint8_t>(kept.size());
        const auto& by_instance = pixels_by_instance[p];
        found.planes[p].name =
            scene
                .instances[std::ranges::max_element(by_instance,
                                                    [](const auto& a, const auto& b) { return a.second < b.second; })
                               ->first]
                .name;
        kept.push_back(std::move(found.planes[p]));
    }
    found.planes = std::move(kept);
    for (SeenTriangle& t : seen.triangles) {
        t.plane = t.plane == PlanarReceivers::kNone ? t.plane : renumbered[t.plane];
    }

    std::vector<std::vector<glm::dvec2>> points(found.planes.size());
    for (PlanarReceiver& plane : found.planes) {
        choose_axes(plane, scene.camera.world_from_camera);
    }
    for (std::size_t i = 0; i < view.size(); ++i) {
        if (mask[i] == 0) {
            continue;
        }
        const std::uint8_t p = seen.triangles[seen.of_pixel[i]].plane;
        found.plane_of_pixel[i] = p;
        if (p == PlanarReceivers::kNone) {
            ++found.pixels_on_none;
            continue;
        }
        // A row's first and last pixels hold its extent: a plane seen in perspective maps lines to lines.
        const bool inside_row =
            i % static_cast<std::size_t>(view.width) != 0 && (i + 1) % static_cast<std::size_t>(view.width) != 0 &&
            found.plane_of_pixel[i - 1] == p && mask[i + 1] != 0 && seen.triangles[seen.of_pixel[i + 1]].plane == p;
        if (!inside_row) {
            const PlanarReceiver& plane = found.planes[p];
            const glm::dvec3 offset = view.eye_ws + glm::dvec3{view.position_cr[i]} - plane.origin_ws;
            points[p].emplace_back(glm::dot(offset, plane.axis_x), glm::dot(offset, plane.axis_y));
        }
    }
    for (std::size_t p = 0; p < found.planes.size(); ++p) {
        if (options.whole) {
            for (const auto& [instance, pixels] : pixels_by_instance[order[p]]) {
                add_whole(scene.instances[instance], found.planes[p], options.tolerance_m, points[p]);
            }
        }
        fit_rectangle(found.planes[p], points[p]);
    }
    return found;
}

}  // namespace penumbra
