#include "passes/light_summary.h"

#include <algorithm>
#include <array>
#include <limits>
#include <numbers>

#include "reference/light_mask.h"
#include "scene/bounds.h"

namespace penumbra {

namespace {

constexpr int kTile_px = 16;
constexpr double kInfinity = std::numeric_limits<double>::infinity();

struct Interval {
    double low = kInfinity;
    double high = -kInfinity;
    void add(double value) noexcept {
        low = std::min(low, value);
        high = std::max(high, value);
    }
    void add(const Interval& other) noexcept {
        low = std::min(low, other.low);
        high = std::max(high, other.high);
    }
};

Interval project(const Bounds& box, const glm::dvec3& axis) {
    const double middle = glm::dot(box.centre(), axis);
    const double reach = glm::dot(box.half_size(), glm::abs(axis));
    return {middle - reach, middle + reach};
}

// Directions along which a caster may be seen to lie apart from hull(light, receivers). Any set is safe: more
// directions only find more casters to leave out. The box axes, their diagonals, and the frame of the main light
// direction, in which the hull is narrow.
std::vector<glm::dvec3> separating_axes(const glm::dvec3& main_direction) {
    std::vector<glm::dvec3> axes;
    for (int x = -1; x <= 1; ++x) {
        for (int y = -1; y <= 1; ++y) {
            for (int z = -1; z <= 1; ++z) {
                if (x > 0 || (x == 0 && (y > 0 || (y == 0 && z > 0)))) {
                    axes.push_back(glm::normalize(glm::dvec3{x, y, z}));
                }
            }
        }
    }
    const double length = glm::length(main_direction);
    if (length > 0.0) {
        const glm::dvec3 w = main_direction / length;
        const glm::dvec3 helper = std::abs(w.x) < 0.7 ? glm::dvec3{1, 0, 0} : glm::dvec3{0, 1, 0};
        const glm::dvec3 u = glm::normalize(glm::cross(helper, w));
        const glm::dvec3 v = glm::cross(w, u);
        constexpr int kTurns = 16;
        for (int i = 0; i < kTurns; ++i) {
            const double angle = std::numbers::pi * i / kTurns;
            const glm::dvec3 side = std::cos(angle) * u + std::sin(angle) * v;
            axes.push_back(side);
            axes.push_back(glm::normalize(side + 0.3 * w));
            axes.push_back(glm::normalize(side - 0.3 * w));
        }
        axes.push_back(w);
    }
    return axes;
}

void collect_receivers(const Scene& scene, const View& view, LightSummary& summary) {
    std::vector<std::uint8_t> seen(scene.instances.size(), 0);
    for (int ty = 0; ty < view.height; ty += kTile_px) {
        for (int tx = 0; tx < view.width; tx += kTile_px) {
            ReceiverTile tile;
            tile.low_cr = glm::vec3{std::numeric_limits<float>::infinity()};
            tile.high_cr = -tile.low_cr;
            tile.first_pixel = static_cast<std::uint32_t>(summary.receiver_points_cr.size());
            for (int y = ty; y < std::min(ty + kTile_px, view.height); ++y) {
                for (int x = tx; x < std::min(tx + kTile_px, view.width); ++x) {
                    const std::size_t i = static_cast<std::size_t>(y) * view.width + x;
                    if (summary.mask[i] == 0) {
                        continue;
                    }
                    const glm::vec3& p = view.position_cr[i];
                    seen[static_cast<std::size_t>(view.instance[i])] = 1;
                    tile.low_cr = glm::min(tile.low_cr, p);
                    tile.high_cr = glm::max(tile.high_cr, p);
                    summary.receiver_points_cr.push_back(p);
                    ++tile.pixel_count;
                }
            }
            if (tile.pixel_count > 0) {
                summary.receivers_ws.add(view.eye_ws + glm::dvec3{tile.low_cr});
                summary.receivers_ws.add(view.eye_ws + glm::dvec3{tile.high_cr});
                summary.tiles.push_back(tile);
            }
        }
    }
    summary.lit_pixels = summary.receiver_points_cr.size();
    for (std::uint32_t i = 0; i < seen.size(); ++i) {
        if (seen[i] != 0) {
            summary.receivers.push_back(i);
            summary.receivers_not_casting += scene.instances[i].casts ? 0 : 1;
        }
    }
}

std::vector<glm::dvec3> separating_axes(const LightSummary& summary) {
    const Light& light = *summary.light;
    return separating_axes(light.kind == LightKind::Sun ? light.direction_ws
                                                        : summary.receivers_ws.centre() - light.position_ws);
}

bool may_cast(const Bounds& caster_ws, const LightSummary& summary, const Bounds& light_bounds,
              const std::vector<glm::dvec3>& axes, double reach_m = 0.0) {
    const Light& light = *summary.light;
    // Float32 rounding of the receivers must not push a touching caster out.
    const double slack =
        reach_m + 1e-6 * (summary.receivers_ws.radius() + glm::length(summary.receivers_ws.centre() - summary.eye_ws));
    for (const glm::dvec3& axis : axes) {
        Interval hull = project(summary.receivers_ws, axis);
        if (light.kind == LightKind::Sun) {
            // Rays leave towards -direction, up to half the sun's angle off: the hull is open on that side.
            const double cosine = glm::dot(axis, -light.direction_ws);
            const double angle = std::acos(std::clamp(cosine, -1.0, 1.0));
            const double half = 0.5 * light.sun_angle_rad;
            if (std::cos(std::max(0.0, angle - half)) > 0.0) {
                hull.high = kInfinity;
            }
            if (std::cos(std::min(std::numbers::pi, angle + half)) < 0.0) {
                hull.low = -kInfinity;
            }
        } else {
            hull.add(project(light_bounds, axis));
        }
        const Interval caster = project(caster_ws, axis);
        if (caster.low > hull.high + slack || caster.high < hull.low - slack) {
            return false;
        }
    }
    return true;
}

}  // namespace

LightSummary::Trivial LightSummary::trivial() const {
    if (!light->casts_shadow) {  // the artist's wish, no saving: it holds whatever is kept
        return {"light-without-shadow", "shadows are switched off for this light"};
    }
    if (lit_pixels == 0 && !keeps("light-without-pixels")) {
        return {"light-without-pixels", "the light reaches no visible pixel"};
    }
    if (casters.empty() && !keeps("light-without-casters")) {
        return {"light-without-casters",
                casters_outside == 0
                    ? "nothing in the scene casts a shadow"
                    : "all " + std::to_string(casters_outside) +
                          " casters lie outside the space between the light and the visible receivers"};
    }
    return {};
}

bool within_reach(const LightSummary& summary, const Bounds& caster_ws, double reach_m) {
    return summary.lit_pixels > 0 &&
           may_cast(caster_ws, summary, bounds_of(*summary.light), separating_axes(summary), reach_m);
}

LightSummary summarise_light(const Scene& scene, const View& view, const Light& light,
                             const std::vector<Bounds>& instance_bounds_ws, const Keep& keep) {
    LightSummary summary;
    summary.light = &light;
    summary.scene = &scene;
    summary.view = &view;
    summary.eye_ws = view.eye_ws;
    summary.has_extent = !has_no_extent(light);
    summary.keep = keep;
    const bool keep_outside = summary.keeps("caster-outside-hull");
    summary.mask = light_mask(scene, view, light);
    collect_receivers(scene, view, summary);

    const Bounds light_bounds = bounds_of(light);
    const auto axes = separating_axes(summary);
    for (std::uint32_t i = 0; i < scene.instances.size(); ++i) {
        const Instance& instance = scene.instances[i];
        if (!instance.casts || instance.mesh->triangles.empty()) {
            continue;
        }
        const bool needed = summary.lit_pixels > 0 && may_cast(instance_bounds_ws[i], summary, light_bounds, axes);
        if (needed || keep_outside) {
            summary.casters.push_back(i);
            summary.caster_needed.push_back(needed ? 1 : 0);
            summary.caster_bounds_ws.push_back(instance_bounds_ws[i]);
            summary.caster_triangles += instance.mesh->triangles.size();
        } else {
            ++summary.casters_outside;
            const double near_m = 2.0 * summary.receivers_ws.radius();
            if (summary.lit_pixels > 0 && may_cast(instance_bounds_ws[i], summary, light_bounds, axes, near_m)) {
                summary.near_hull.push_back(i);
                summary.near_hull_bounds_ws.push_back(instance_bounds_ws[i]);
            }
        }
    }
    return summary;
}

}  // namespace penumbra
