#include "passes/field_of_use.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <numbers>
#include <optional>
#include <sstream>

#include "base/parallel.h"
#include "reference/light_mask.h"

namespace penumbra {

namespace {

constexpr double kMapsBegin = 1e-5;      // of the farthest receiver's distance: kNearShare of passes/map_frustum
constexpr double kRaysTellApart = 1e-6;  // of the scene's size: float32, docs/techniques/ray_traced.md
constexpr double kLongLight = 4.0;       // times as long as wide: no disc any more
constexpr double kUnderHorizon = 0.05;   // share of the mask from which on it is worth a word
constexpr std::int64_t kPixelGrain = 16384;

template <typename... Parts>
std::string join(const Parts&... parts) {
    std::ostringstream out;
    out.precision(3);
    (out << ... << parts);
    return out.str();
}

bool is_round(LightKind kind) noexcept {
    return kind == LightKind::Point || kind == LightKind::Spot || kind == LightKind::Sun || kind == LightKind::Ellipse;
}

/// Longest and shortest width of an area light, metres; of round lights twice the same.
glm::dvec2 widths_of(const Light& light) {
    switch (light.kind) {
        case LightKind::Point:
        case LightKind::Spot:
            return glm::dvec2{2.0 * light.radius_m};
        case LightKind::Sun:
            return glm::dvec2{0.0};
        case LightKind::Line:
            return {2.0 * glm::length(light.half_u_ws), 0.0};
        case LightKind::Rectangle:
        case LightKind::Ellipse: {
            const double u = 2.0 * glm::length(light.half_u_ws);
            const double v = 2.0 * glm::length(light.half_v_ws);
            return {std::max(u, v), std::min(u, v)};
        }
        case LightKind::Polygon: {
            double longest = 0.0;
            glm::dvec3 twice_area{0.0};
            for (std::size_t i = 0; i < light.corners_ws.size(); ++i) {
                const glm::dvec3& a = light.corners_ws[i];
                twice_area += glm::cross(a - light.corners_ws[0],
                                         light.corners_ws[(i + 1) % light.corners_ws.size()] - light.corners_ws[0]);
                for (const glm::dvec3& b : light.corners_ws) {
                    longest = std::max(longest, glm::length(a - b));
                }
            }
            return {longest, longest > 0.0 ? 0.5 * glm::length(twice_area) / longest : 0.0};
        }
    }
    return glm::dvec2{0.0};
}

std::string size_text(const Light& light) {
    if (light.kind == LightKind::Sun) {
        return join("the sun is ", light.sun_angle_rad * 180.0 / std::numbers::pi, " degrees wide");
    }
    const glm::dvec2 widths = widths_of(light);
    return widths.y < widths.x ? join("the light is ", widths.x, " x ", widths.y, " m large")
                               : join("the light is ", widths.x, " m wide");
}

/// Distance of a box from the light's, 0 if they overlap.
double gap_between(const Bounds& a, const Bounds& b) noexcept {
    return glm::length(glm::max(glm::max(a.low - b.high, b.low - a.high), glm::dvec3{0.0}));
}

double farthest_receiver_m(const LightSummary& summary) noexcept {
    const glm::dvec3 apart = glm::max(glm::abs(summary.receivers_ws.low - summary.light->position_ws),
                                      glm::abs(summary.receivers_ws.high - summary.light->position_ws));
    return summary.receivers_ws.empty() ? 0.0 : glm::length(apart);
}

struct Nearest {
    double gap_m = 0.0;  ///< never more than the true distance from the light's box
    std::uint32_t instance = 0;
};

/// The caster nearest to the light, if it comes within `below_m`.
std::optional<Nearest> nearest_caster(const LightSummary& summary, double below_m) {
    std::optional<Nearest> nearest;
    if (summary.light->kind == LightKind::Sun) {
        return nearest;
    }
    const Bounds light = bounds_of(*summary.light);
    const auto consider = [&](double gap_m, std::uint32_t instance) {
        if (gap_m < below_m && (!nearest || gap_m < nearest->gap_m)) {
            nearest = Nearest{gap_m, instance};
        }
    };
    for (std::size_t k = 0; k < summary.casters.size(); ++k) {
        if (!(gap_between(summary.caster_bounds_ws[k], light) < below_m)) {
            continue;
        }
        const Instance& instance = summary.scene->instances[summary.casters[k]];
        const glm::dmat4& world_from_local = instance.world_from_local;
        const glm::dvec3 centre = light.centre();
        const glm::dvec3 half = light.half_size();
        for (const glm::uvec3& t : instance.mesh->triangles) {
            std::array<glm::dvec3, 3> corner;
            Bounds own;
            for (int i = 0; i < 3; ++i) {
                corner[i] = glm::dvec3{world_from_local * glm::dvec4{instance.mesh->positions_local[t[i]], 1.0}};
                own.add(corner[i]);
            }
            // A slanting triangle's box says little; its plane does.
            const glm::dvec3 n = glm::cross(corner[1] - corner[0], corner[2] - corner[0]);
            const double length = glm::length(n);
            const double from_plane =
                length > 0.0 ? (std::abs(glm::dot(n, centre - corner[0])) - glm::dot(glm::abs(n), half)) / length : 0.0;
            consider(std::max({gap_between(own, light), from_plane, 0.0}), summary.casters[k]);
        }
    }
    return nearest;
}

std::string name_of(const LightSummary& summary, std::uint32_t instance) {
    return "\"" + summary.scene->instances[instance].name + "\"";
}

void warn_of_umbrae(const LightSummary& summary, std::vector<Warning>& warnings) {
    const Light& light = *summary.light;
    const bool sun = light.kind == LightKind::Sun;
    const double light_radius = sun ? std::tan(std::min(0.5 * light.sun_angle_rad, 1.5)) : 0.5 * widths_of(light).y;
    std::size_t count = 0;
    std::uint32_t first = 0;
    double shortest_m = 0.0;
    for (std::size_t k = 0; k < summary.casters.size(); ++k) {
        glm::dvec3 half = summary.caster_bounds_ws[k].half_size();
        std::sort(&half[0], &half[0] + 3);
        const double radius = half.y;  // of what a caster shows to a light on its broad side
        // Similar triangles: the cone of the umbra ends where the caster just covers the light.
        const double distance =
            sun ? 1.0 : std::max(glm::length(summary.caster_bounds_ws[k].centre() - light.position_ws), 1e-300);
        const double shrinking = sun ? light_radius : (light_radius - radius) / distance;
        if (!(shrinking > 0.0)) {
            continue;
        }
        const double umbra_m = radius / shrinking;
        const double behind_m = glm::length(summary.receivers_ws.centre() - summary.caster_bounds_ws[k].centre()) +
                                summary.receivers_ws.radius();
        if (umbra_m < behind_m) {
            if (count == 0 || umbra_m < shortest_m) {
                first = summary.casters[k];
                shortest_m = umbra_m;
            }
            ++count;
        }
    }
    if (count > 0) {
        warnings.push_back(
            {"umbra-never-ends",
             join(size_text(light), ", so that the umbra of ", name_of(summary, first), " ends ", shortest_m,
                  " m behind it", count > 1 ? join(" (", count, " casters are like it)") : std::string{},
                  ", but is drawn black all the way")});
    }
}

/// Share of the mask whose own plane has a part of the light under it.
double share_under_horizon(const LightSummary& summary) {
    if (summary.lit_pixels == 0) {
        return 0.0;
    }
    const View& view = *summary.view;
    std::atomic<std::uint64_t> cut{0};
    Control control;
    parallel_for(
        static_cast<std::int64_t>(view.size()), kPixelGrain,
        [&](std::int64_t begin, std::int64_t end) {
            std::uint64_t own = 0;
            for (std::int64_t i = begin; i < end; ++i) {
                own += summary.mask[i] != 0 && dips_under(*summary.light, view, static_cast<std::size_t>(i)) ? 1 : 0;
            }
            cut += own;
        },
        control);
    return static_cast<double>(cut) / static_cast<double>(summary.lit_pixels);
}

}  // namespace

std::vector<Warning> outside_field(const FieldOfUse& field, const LightSummary& summary) {
    std::vector<Warning> warnings;
    if (summary.lit_pixels == 0 || summary.casters.empty() || !summary.light->casts_shadow) {
        return warnings;
    }
    const Light& light = *summary.light;
    if (field.needs_clear_light) {
        const double begin_m = kMapsBegin * farthest_receiver_m(summary);
        if (const auto nearest = nearest_caster(summary, begin_m)) {
            warnings.push_back(
                {"caster-at-light", join(name_of(summary, nearest->instance), " comes within ", nearest->gap_m,
                                         " m of the light, where depths are told apart from ", begin_m,
                                         " m on: what is nearer counts as that far away or is cut off")});
        }
    }
    if (field.needs_float32_rays) {
        double size_m = summary.receivers_ws.radius();
        for (const Bounds& bounds : summary.caster_bounds_ws) {
            size_m = std::max(size_m, bounds.radius());
        }
        const double begin_m = 2.0 * kRaysTellApart * size_m;
        const auto nearest = nearest_caster(summary, begin_m);
        if (nearest && nearest->gap_m > 0.0) {
            warnings.push_back({"caster-under-float32",
                                join(name_of(summary, nearest->instance), " comes within ", nearest->gap_m,
                                     " m of the light; rays in float32 miss it in a scene of ", size_m, " m")});
        }
    }
    if (field.needs_light_above_horizon) {
        if (const double share = share_under_horizon(summary); share > kUnderHorizon) {
            warnings.push_back({"light-under-horizon",
                                join("at ", 100.0 * share,
                                     " % of the pixels a part of the light lies under the surface's own plane; it "
                                     "counts as hidden without a look")});
        }
    }
    if (!summary.has_extent) {
        return warnings;
    }
    if (field.needs_point_light) {
        warnings.push_back(
            {"hard-shadow", join(size_text(light), " and one point stands for it: no penumbra is drawn")});
    }
    if (field.needs_small_light) {
        warn_of_umbrae(summary, warnings);
    }
    if (field.needs_round_light) {
        const glm::dvec2 widths = widths_of(light);
        if (widths.x > kLongLight * widths.y) {
            warnings.push_back(
                {"long-light", join(size_text(light),
                                    "; penumbrae are as wide across a silhouette as it is there, or as a "
                                    "disc in its place: too wide beside it")});
        }
    }
    if (field.needs_line_light && is_round(light.kind)) {
        warnings.push_back({"line-for-round-light",
                            join(size_text(light), " and one line stands for it: edges along it have no penumbra")});
    }
    return warnings;
}

}  // namespace penumbra
