#include "passes/map_frustum.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>

namespace penumbra {

namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
// A frustum wider than this spends its texels badly (at 55 degrees the rim's texels are 3 times as wide in angle as
// those of a cube); then faces of a cube are used.
const double kWidestTangent = std::tan(55.0 * std::numbers::pi / 180.0);
// Receivers nearer to the light point than this share of their distance are treated as touching it.
constexpr double kNearShare = 1e-5;

struct Extent {
    glm::dvec2 low{kInfinity}, high{-kInfinity};
    double nearest = kInfinity, farthest = -kInfinity;

    [[nodiscard]] bool empty() const noexcept { return !(farthest >= nearest); }
    void add(const glm::dvec2& at, double z) noexcept {
        low = glm::min(low, at);
        high = glm::max(high, at);
        nearest = std::min(nearest, z);
        farthest = std::max(farthest, z);
    }
};

/// Rows are the map's x, y and z axes in world space.
glm::dmat3 rotation_with_z(const glm::dvec3& z_ws) {
    const glm::dvec3 helper = std::abs(z_ws.z) < 0.9 ? glm::dvec3{0, 0, 1} : glm::dvec3{0, 1, 0};
    const glm::dvec3 x_ws = glm::normalize(glm::cross(helper, z_ws));
    const glm::dvec3 y_ws = glm::cross(z_ws, x_ws);
    return glm::transpose(glm::dmat3{x_ws, y_ws, z_ws});
}

/// z along the light's normal and x along its first axis, where the kind has them.
glm::dmat3 rotation_of_light(const Light& light) {
    const glm::dvec3 z_ws = light.direction_ws;
    const glm::dvec3 along_ws = light.kind == LightKind::Polygon && light.corners_ws.size() > 1
                                    ? light.corners_ws[1] - light.corners_ws[0]
                                    : light.half_u_ws;
    const glm::dvec3 in_plane = along_ws - glm::dot(along_ws, z_ws) * z_ws;
    if (!(glm::length(in_plane) > 0.0)) {
        return rotation_with_z(z_ws);
    }
    const glm::dvec3 x_ws = glm::normalize(in_plane);
    return glm::transpose(glm::dmat3{x_ws, glm::cross(z_ws, x_ws), z_ws});
}

bool is_flat_area(LightKind kind) {
    return kind == LightKind::Rectangle || kind == LightKind::Ellipse || kind == LightKind::Polygon;
}

std::array<glm::dvec3, 8> corners_of(const glm::dvec3& low, const glm::dvec3& high) {
    std::array<glm::dvec3, 8> corners;
    for (std::size_t i = 0; i < 8; ++i) {
        corners[i] = {(i & 1U) != 0 ? high.x : low.x, (i & 2U) != 0 ? high.y : low.y, (i & 4U) != 0 ? high.z : low.z};
    }
    return corners;
}

/// Index 0..5 of the cube face (+z, -z, +x, -x, +y, -y of the map's axes) whose cone holds p.
int face_of(const glm::dvec3& p_ls) {
    const glm::dvec3 a = glm::abs(p_ls);
    if (a.z >= a.x && a.z >= a.y) {
        return p_ls.z >= 0.0 ? 0 : 1;
    }
    if (a.x >= a.y) {
        return p_ls.x >= 0.0 ? 2 : 3;
    }
    return p_ls.y >= 0.0 ? 4 : 5;
}

constexpr std::array<const char*, 6> kFaceNames{"+z", "-z", "+x", "-x", "+y", "-y"};

/// Turns the base frame so that +z looks through face `i`.
glm::dmat3 face_rotation(int i, const glm::dmat3& ls_from_world) {
    const glm::dmat3 world_axes = glm::transpose(ls_from_world);
    const std::array<glm::dvec3, 6> forward{world_axes[2],  -world_axes[2], world_axes[0],
                                            -world_axes[0], world_axes[1],  -world_axes[1]};
    if (i == 0) {
        return ls_from_world;
    }
    const glm::dvec3 z = forward[static_cast<std::size_t>(i)];
    const glm::dvec3 x = i < 2 ? -world_axes[0] : world_axes[2];
    return glm::transpose(glm::dmat3{x, glm::cross(z, x), z});
}

void pad(Extent& extent, const MapFrustumOptions& options) {
    const double usable = std::max(1.0, options.size_px - 2.0 * options.margin_texels);
    glm::dvec2 size = extent.high - extent.low;
    // A single visible pixel has no extent; a map of width zero would have texels of width zero.
    const double least = 1e-4 * std::max({1e-12, size.x, size.y, glm::length(extent.low), glm::length(extent.high)});
    const glm::dvec2 centre = 0.5 * (extent.low + extent.high);
    size = glm::max(size, glm::dvec2{least}) * (options.size_px / usable);
    extent.low = centre - 0.5 * size;
    extent.high = centre + 0.5 * size;
}

/// Where a box lies, as a face sees it.
struct Placed {
    bool beside = false;  ///< apart from the face's extent, or behind the light point
    double nearest = kInfinity;
};

Placed placed_in(const MapFace& face, const glm::dvec3& origin_ws, const Bounds& box_ws) {
    Placed box;
    bool outside_left = true;
    bool outside_right = true;
    bool outside_low = true;
    bool outside_high = true;
    bool behind = !face.orthographic;
    for (const glm::dvec3& corner_ws : corners_of(box_ws.low, box_ws.high)) {
        const glm::dvec3 p = face.ls_from_world * (corner_ws - origin_ws);
        const double w = face.orthographic ? 1.0 : p.z;
        outside_left = outside_left && p.x < face.low.x * w;
        outside_right = outside_right && p.x > face.high.x * w;
        outside_low = outside_low && p.y < face.low.y * w;
        outside_high = outside_high && p.y > face.high.y * w;
        behind = behind && p.z <= 0.0;
        box.nearest = std::min(box.nearest, p.z);
    }
    box.beside = outside_left || outside_right || outside_low || outside_high || behind;
    return box;
}

/// What is looked up in the margin lies beside its receiver by no more than `reach_m`. Casters in its way may be
/// outside the hull of light and receivers, and count all the same.
void add_casters_beside(const LightSummary& summary, const glm::dvec3& origin_ws, const MapFrustumOptions& options,
                        MapFace& face) {
    const glm::dvec2 margin = options.margin_texels / options.size_px * (face.high - face.low);
    const double reach_m = glm::length(margin) * (face.orthographic ? 1.0 : face.farthest_m);
    for (std::size_t i = 0; i < summary.near_hull.size(); ++i) {
        const Placed box = placed_in(face, origin_ws, summary.near_hull_bounds_ws[i]);
        if (!box.beside && box.nearest <= face.farthest_m &&
            within_reach(summary, summary.near_hull_bounds_ws[i], reach_m)) {
            face.beside.push_back(summary.near_hull[i]);
        }
    }
}

}  // namespace

void fit_depth_and_casters(const LightSummary& summary, const glm::dvec3& origin_ws, double nearest_m,
                           double farthest_m, bool keep_receivers, MapFace& face) {
    double nearest_caster = kInfinity;
    face.farthest_m = farthest_m;
    for (std::uint32_t i = 0; i < summary.casters.size(); ++i) {
        const Placed box = placed_in(face, origin_ws, summary.caster_bounds_ws[i]);
        const bool receives = keep_receivers && std::ranges::binary_search(summary.receivers, summary.casters[i]);
        const bool past_receivers = box.nearest > farthest_m && !receives;
        const bool outside = box.beside || past_receivers;
        if (outside && !summary.keeps("caster-outside-face")) {
            continue;
        }
        face.casters.push_back(i);
        if (!outside && summary.caster_needed[i] != 0) {  // what could be left out must not move the near plane
            nearest_caster = std::min(nearest_caster, box.nearest);
        }
    }
    if (face.orthographic) {
        const double span = std::max(
            {farthest_m - std::min(nearest_m, nearest_caster), face.high.x - face.low.x, face.high.y - face.low.y});
        face.near_m = std::min(nearest_m, nearest_caster) - 1e-3 * span;
        face.far_m = farthest_m + 1e-3 * span;
    } else {
        const double nearest = std::min(nearest_m, nearest_caster);
        face.near_m = std::max(0.99 * nearest, kNearShare * std::max(farthest_m, 1e-30));
    }
}

std::vector<std::uint32_t> casters_in(const LightSummary& summary, const MapFace& face) {
    std::vector<std::uint32_t> instances;
    instances.reserve(face.casters.size());
    for (const std::uint32_t caster : face.casters) {
        instances.push_back(summary.casters[caster]);
    }
    instances.insert(instances.end(), face.beside.begin(), face.beside.end());
    return instances;
}

MapFrustum fit_map_frustum(const LightSummary& summary, const glm::dvec3& origin_ws, const glm::dvec3& direction_ws,
                           const MapFrustumOptions& options) {
    MapFrustum frustum;
    const bool sun = summary.light->kind == LightKind::Sun;
    frustum.origin_ws = sun ? summary.receivers_ws.centre() : origin_ws;
    // In float64 once, so that positions far from the world's origin lose nothing.
    const glm::dvec3 eye_from_origin = summary.eye_ws - frustum.origin_ws;

    if (summary.receiver_points_cr.empty()) {
        return frustum;
    }
    if (sun) {
        MapFace face;
        face.name = "front";
        face.orthographic = true;
        face.ls_from_world = rotation_with_z(direction_ws);
        Extent extent;
        for (const glm::vec3& p_cr : summary.receiver_points_cr) {
            const glm::dvec3 p = face.ls_from_world * (glm::dvec3{p_cr} + eye_from_origin);
            extent.add({p.x, p.y}, p.z);
        }
        pad(extent, options);
        face.low = extent.low;
        face.high = extent.high;
        fit_depth_and_casters(summary, frustum.origin_ws, extent.nearest, extent.farthest, options.keep_receivers,
                              face);
        add_casters_beside(summary, frustum.origin_ws, options, face);
        frustum.faces.push_back(std::move(face));
        return frustum;
    }

    // One frustum along the mean direction to the receivers, if they all lie within it.
    glm::dvec3 mean{0.0};
    for (const ReceiverTile& tile : summary.tiles) {
        const glm::dvec3 p = 0.5 * (glm::dvec3{tile.low_cr} + glm::dvec3{tile.high_cr}) + eye_from_origin;
        const double length = glm::length(p);
        if (length > 0.0) {
            mean += p / length * static_cast<double>(tile.pixel_count);
        }
    }
    const bool along_normal = options.along_light_normal && is_flat_area(summary.light->kind);
    if (glm::length(mean) > 0.0 || along_normal) {
        MapFace face;
        face.name = "front";
        face.ls_from_world = along_normal ? rotation_of_light(*summary.light) : rotation_with_z(glm::normalize(mean));
        Extent extent;
        bool fits = true;
        for (const ReceiverTile& tile : summary.tiles) {
            for (const glm::dvec3& corner_cr : corners_of(glm::dvec3{tile.low_cr}, glm::dvec3{tile.high_cr})) {
                const glm::dvec3 p = face.ls_from_world * (corner_cr + eye_from_origin);
                if (!(p.z > 0.0) || std::abs(p.x) > kWidestTangent * p.z || std::abs(p.y) > kWidestTangent * p.z) {
                    fits = false;
                    break;
                }
                extent.add({p.x / p.z, p.y / p.z}, p.z);
            }
            if (!fits) {
                break;
            }
        }
        if (fits) {
            pad(extent, options);
            face.low = extent.low;
            face.high = extent.high;
            fit_depth_and_casters(summary, frustum.origin_ws, extent.nearest, extent.farthest, options.keep_receivers,
                                  face);
            add_casters_beside(summary, frustum.origin_ws, options, face);
            frustum.faces.push_back(std::move(face));
            return frustum;
        }
    }

    const glm::dmat3 base =
        along_normal ? rotation_of_light(*summary.light)
                     : rotation_with_z(glm::length(direction_ws) > 0.0 ? direction_ws : glm::dvec3{0, 0, -1});
    std::array<glm::dmat3, 6> rotation;
    std::array<Extent, 6> extent;
    for (int i = 0; i < 6; ++i) {
        rotation[static_cast<std::size_t>(i)] = face_rotation(i, base);
    }
    const auto add = [&](const glm::dvec3& p_relative_ws) {
        const auto i = static_cast<std::size_t>(face_of(base * p_relative_ws));
        const glm::dvec3 p = rotation[i] * p_relative_ws;
        if (p.z > 0.0) {  // a receiver at the light point itself needs no map
            extent[i].add({p.x / p.z, p.y / p.z}, p.z);
        }
    };
    for (const ReceiverTile& tile : summary.tiles) {
        const auto corners = corners_of(glm::dvec3{tile.low_cr}, glm::dvec3{tile.high_cr});
        const int first = face_of(base * (corners[0] + eye_from_origin));
        const bool inside_one = std::ranges::all_of(
            corners, [&](const glm::dvec3& corner) { return face_of(base * (corner + eye_from_origin)) == first; });
        if (inside_one) {  // face cones are convex, so the whole box is inside
            for (const glm::dvec3& corner : corners) {
                add(corner + eye_from_origin);
            }
        } else {
            for (std::uint32_t k = 0; k < tile.pixel_count; ++k) {
                add(glm::dvec3{summary.receiver_points_cr[tile.first_pixel + k]} + eye_from_origin);
            }
        }
    }
    for (std::size_t i = 0; i < 6; ++i) {
        if (extent[i].empty() && !summary.keeps("cube-face-without-receivers")) {
            frustum.faces_without_receivers.emplace_back(kFaceNames[i]);
            continue;
        }
        MapFace face;
        face.name = kFaceNames[i];
        face.ls_from_world = rotation[i];
        face.for_nothing = extent[i].empty();
        if (face.for_nothing) {
            extent[i].add({-1.0, -1.0}, 1.0);
            extent[i].add({1.0, 1.0}, 1.0);
        }
        pad(extent[i], options);
        face.low = extent[i].low;
        face.high = extent[i].high;
        fit_depth_and_casters(summary, frustum.origin_ws, extent[i].nearest, extent[i].farthest, options.keep_receivers,
                              face);
        add_casters_beside(summary, frustum.origin_ws, options, face);
        frustum.faces.push_back(std::move(face));
    }
    return frustum;
}

}  // namespace penumbra
