#include "techniques/linear_light_maps/linear_views.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>

namespace penumbra {

namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
// A single window this wide, else twelve around the rod; the limit of the fitted frustum of other maps.
const double kWidest = std::tan(55.0 * std::numbers::pi / 180.0);
// Texels kept free around what must be seen: the widest filter reaches two.
constexpr double kMargin_px = 4.0;
// Room for skins on either side: at most this share of what the receivers take, and no more than this tangent, but for
// receivers that take more themselves: what stands close to the rod has skins as long as one likes, and texels are
// dear.
constexpr double kMostRoom = 2.0;
constexpr double kMostRoomTangent = 0.5;

struct Range {
    double low = kInfinity, high = -kInfinity;
    void add(double value) noexcept {
        low = std::min(low, value);
        high = std::max(high, value);
    }
    [[nodiscard]] bool empty() const noexcept { return !(high >= low); }
    [[nodiscard]] bool holds(double value) const noexcept { return low <= value && value <= high; }
    [[nodiscard]] double size() const noexcept { return high - low; }
};

struct Seen {
    std::vector<Range> u;  // per sample
    Range v, z;
    explicit Seen(std::size_t samples) : u(samples) {}
    [[nodiscard]] bool empty() const noexcept { return z.empty(); }
};

glm::dvec3 any_perpendicular(const glm::dvec3& axis) {
    const glm::dvec3 helper = std::abs(axis.z) < 0.9 ? glm::dvec3{0, 0, 1} : glm::dvec3{0, 1, 0};
    return glm::normalize(glm::cross(helper, axis));
}

std::array<glm::dvec3, 8> corners_of(const glm::dvec3& low, const glm::dvec3& high) {
    std::array<glm::dvec3, 8> corners;
    for (std::size_t i = 0; i < 8; ++i) {
        corners[i] = {(i & 1U) != 0 ? high.x : low.x, (i & 2U) != 0 ? high.y : low.y, (i & 4U) != 0 ? high.z : low.z};
    }
    return corners;
}

/// Rows u, v, f; a sun's first row is sheared, so that a sample's rays are columns.
glm::dmat3 axes(const glm::dvec3& u, const glm::dvec3& v, const glm::dvec3& f, double shear) {
    return glm::transpose(glm::dmat3{u + shear * f, v, f});
}

struct Sectors {
    glm::dvec3 u, v, f;
    bool orthographic = false;
    std::vector<double> along;

    /// The windows around the rod: four, f turned about u, and each in three parts along u.
    [[nodiscard]] glm::dmat3 window(int i, double shear = 0.0) const {
        const std::array<glm::dvec3, 4> forward{f, v, -f, -v};
        const glm::dvec3 towards = forward[static_cast<std::size_t>(i % 4)];
        return axes(u, glm::cross(towards, u), towards, shear);
    }
    [[nodiscard]] bool inside(int i, const glm::dvec3& p, double widest) const {
        const glm::dvec3 q = window(i) * p;
        const bool part = i < 4 ? std::abs(q.x) <= widest * q.z : i < 8 ? q.x > q.z : q.x < -q.z;
        return orthographic || (q.z > 0.0 && part && std::abs(q.y) <= widest * q.z &&
                                q.x - along.front() <= kWidestAlong * q.z && along.back() - q.x <= kWidestAlong * q.z);
    }
    void add(int i, const glm::dvec3& p, Seen& seen) const {
        const glm::dvec3 q = window(i) * p;
        for (std::size_t k = 0; k < along.size(); ++k) {
            seen.u[k].add(orthographic ? q.x + along[k] * q.z : (q.x - along[k]) / q.z);
        }
        seen.v.add(orthographic ? q.y : q.y / q.z);
        seen.z.add(q.z);
    }
    [[nodiscard]] bool within(int i, const glm::dvec3& p, const Seen& seen) const {
        const glm::dvec3 q = window(i) * p;
        bool inside = seen.z.holds(q.z) && seen.v.holds(orthographic ? q.y : q.y / q.z);
        for (std::size_t k = 0; k < along.size() && inside; ++k) {
            inside = seen.u[k].holds(orthographic ? q.x + along[k] * q.z : (q.x - along[k]) / q.z);
        }
        return inside;
    }
};

constexpr std::array<const char*, kMostWindows> kWindowNames{
    "front",       "left",         "back",          "right",        "front, ahead", "left, ahead",
    "back, ahead", "right, ahead", "front, behind", "left, behind", "back, behind", "right, behind"};

/// What of the scene lies around the rod, relative to its origin.
struct Surroundings {
    const LightSummary& summary;
    glm::dvec3 origin_ws;
    glm::dvec3 eye_from_origin;
};

/// How far sample `k` must see, so that it holds the edges that hide its neighbours from a receiver. A caster at depth
/// d that hides x_l from p appears (x_l - x_k) (d - d_p) beside p; and no farther out than the caster itself.
Range with_room(const Surroundings& around, const Sectors& sectors, const glm::dmat3& rotation, const Seen& seen,
                std::size_t k, double nearest_m) {
    const Range receivers = seen.u[k];
    Range wanted = receivers;
    const double back = k > 0 ? sectors.along[k] - sectors.along[k - 1] : 0.0;
    const double forth = k + 1 < sectors.along.size() ? sectors.along[k + 1] - sectors.along[k] : 0.0;
    for (std::size_t c = 0; c < around.summary.casters.size(); ++c) {
        if (around.summary.caster_needed[c] == 0) {
            continue;
        }
        const Bounds& box = around.summary.caster_bounds_ws[c];
        Range own;
        double nearest = kInfinity;
        for (const glm::dvec3& corner_ws : corners_of(box.low, box.high)) {
            const glm::dvec3 q = rotation * (corner_ws - around.origin_ws);
            nearest = std::min(nearest, q.z);
            if (sectors.orthographic) {
                own.add(q.x + sectors.along[k] * q.z);
            } else if (q.z > nearest_m) {
                own.add((q.x - sectors.along[k]) / q.z);
            } else {
                own.add(-kInfinity);
                own.add(kInfinity);
            }
        }
        if (nearest > seen.z.high) {
            continue;
        }
        const double in_front =
            sectors.orthographic ? seen.z.high - nearest : 1.0 / std::max(nearest, nearest_m) - 1.0 / seen.z.high;
        wanted.add(std::min(receivers.high + forth * in_front, std::max(own.high, receivers.low)));
        wanted.add(std::max(receivers.low - back * in_front, std::min(own.low, receivers.high)));
    }
    double most = kMostRoom * receivers.size();
    if (!sectors.orthographic) {
        most = std::min(most, std::max(kMostRoomTangent, 0.25 * receivers.size()));
    }
    return {std::max(wanted.low, receivers.low - most), std::min(wanted.high, receivers.high + most)};
}

/// Instances of the maps that skins come from: surfaces that matter, whatever else is drawn.
std::vector<std::uint32_t> skin_casters(const Surroundings& around, const MapFace& face) {
    const LightSummary& summary = around.summary;
    std::vector<std::uint32_t> instances;
    for (const std::uint32_t c : face.casters) {
        double nearest = kInfinity;
        for (const glm::dvec3& corner_ws :
             corners_of(summary.caster_bounds_ws[c].low, summary.caster_bounds_ws[c].high)) {
            nearest = std::min(nearest, (face.ls_from_world * (corner_ws - around.origin_ws)).z);
        }
        const bool receives = std::ranges::binary_search(summary.receivers, summary.casters[c]);
        if (summary.caster_needed[c] != 0 && (receives || nearest <= face.farthest_m)) {
            instances.push_back(summary.casters[c]);
        }
    }
    for (const std::uint32_t receiver : summary.receivers) {
        if (!summary.scene->instances[receiver].casts) {
            instances.push_back(receiver);
        }
    }
    std::ranges::sort(instances);
    return instances;
}

LinearWindow make_window(const Surroundings& around, const Sectors& sectors, int index, Seen seen, int size_px) {
    LinearWindow window;
    const std::size_t samples = sectors.along.size();
    if (seen.empty()) {  // kept though nothing is seen through it
        for (std::size_t k = 0; k < samples; ++k) {
            seen.u[k] = {-1.0, 1.0};
        }
        seen.v = {-1.0, 1.0};
        seen.z = {1.0, 1.0};
    }
    const double least_m = 1e-5 * std::max(seen.z.high, 1e-30);
    glm::dvec2 size{0.0, seen.v.size()};
    std::vector<double> middle;
    double farthest_off = 0.0;
    for (std::size_t k = 0; k < samples; ++k) {
        const Range u = with_room(around, sectors, sectors.window(index), seen, k, least_m);
        size.x = std::max(size.x, u.size());
        middle.push_back(0.5 * (u.low + u.high));
        farthest_off = std::max(farthest_off, std::abs(middle.back()));
    }
    const double usable = std::max(1.0, size_px - 2.0 * kMargin_px);
    // A single visible pixel has no extent; a map of width zero would have texels of width zero.
    const double least =
        1e-4 * std::max({1e-12, size.x, size.y, farthest_off, std::abs(seen.v.low), std::abs(seen.v.high)});
    size = glm::max(size, glm::dvec2{least}) * (size_px / usable);
    window.step = size / static_cast<double>(size_px);
    double near_m = kInfinity;
    double far_m = seen.z.high;
    for (std::size_t k = 0; k < samples; ++k) {
        MapFace face;
        face.name = kWindowNames[static_cast<std::size_t>(index)];
        face.orthographic = sectors.orthographic;
        face.ls_from_world = sectors.window(index, sectors.orthographic ? sectors.along[k] : 0.0);
        face.low = {middle[k] - 0.5 * size.x, 0.5 * (seen.v.low + seen.v.high - size.y)};
        face.high = face.low + size;
        const glm::dvec3 eye_ws =
            sectors.orthographic ? around.origin_ws : around.origin_ws + sectors.along[k] * sectors.u;
        fit_depth_and_casters(around.summary, eye_ws, seen.z.low, seen.z.high, true, face);
        near_m = std::min(near_m, face.near_m);
        far_m = std::max(far_m, face.far_m);
        window.skin_casters.push_back(skin_casters(around, face));
        window.faces.push_back(std::move(face));
    }
    // Skins end on what lies behind the casters, seen or not: a sun's far plane is not to cut it off.
    const double reach = far_m + 4.0 * std::max(size.x, size.y);
    for (std::size_t c = 0; sectors.orthographic && c < around.summary.casters.size(); ++c) {
        if (around.summary.caster_needed[c] != 0) {
            for (const glm::dvec3& corner_ws :
                 corners_of(around.summary.caster_bounds_ws[c].low, around.summary.caster_bounds_ws[c].high)) {
                far_m = std::max(far_m, std::min(reach, (sectors.window(index) * (corner_ws - around.origin_ws)).z));
            }
        }
    }
    window.nearest_m = near_m;
    for (std::size_t k = 0; k < samples; ++k) {
        window.faces[k].near_m = near_m;
        window.faces[k].far_m = far_m;
        const double shift = sectors.orthographic ? sectors.along[k] * far_m : 0.0;
        window.low_u.push_back(window.faces[k].low.x - shift);
        window.receivers_u.emplace_back(seen.u[k].low - shift, seen.u[k].high - shift);
    }
    return window;
}

}  // namespace

std::vector<LinearViews::Group> LinearViews::groups() const {
    std::vector<Group> all;
    for (std::size_t first = 0; first < windows.size(); first += PENUMBRA_MAX_FACES) {
        all.push_back({first, std::min<std::size_t>(PENUMBRA_MAX_FACES, windows.size() - first)});
    }
    return all;
}

MapFrustum LinearViews::frustum_of(int sample, const Group& group) const {
    MapFrustum frustum;
    frustum.origin_ws = eye_ws(sample);
    for (std::size_t i = group.first; i < group.first + group.count; ++i) {
        frustum.faces.push_back(windows[i].faces[static_cast<std::size_t>(sample)]);
    }
    return frustum;
}

MapFrustum LinearViews::central(const Group& group) const {
    MapFrustum frustum;
    frustum.origin_ws = origin_ws;
    for (std::size_t i = group.first; i < group.first + group.count; ++i) {
        const LinearWindow& window = windows[i];
        MapFace face = window.common();
        const glm::dmat3 rows = glm::transpose(face.ls_from_world);
        face.ls_from_world = glm::transpose(glm::dmat3{u_ws, rows[1], rows[2]});
        const double width = face.high.x - face.low.x;
        face.low.x = 0.5 * (window.low_u.front() + window.low_u.back());
        face.high.x = face.low.x + width;
        frustum.faces.push_back(std::move(face));
    }
    return frustum;
}

glm::dvec2 LinearViews::shift_from_central(std::size_t window, int sample) const {
    const LinearWindow& w = windows[window];
    const auto k = static_cast<std::size_t>(sample);
    const double low = 0.5 * (w.low_u.front() + w.low_u.back());
    return glm::dvec2{-along[k], low - w.low_u[k]} / w.step.x;
}

glm::dvec2 LinearViews::shift_between(std::size_t window, int from, int to) const {
    const LinearWindow& w = windows[window];
    const auto a = static_cast<std::size_t>(from);
    const auto b = static_cast<std::size_t>(to);
    return glm::dvec2{along[a] - along[b], w.low_u[a] - w.low_u[b]} / w.step.x;
}

std::optional<std::size_t> LinearViews::window_of(const glm::dvec3& p_ws) const {
    if (in_one_window) {
        return 0;
    }
    const double v = glm::dot(p_ws, v_ws);
    const double f = glm::dot(p_ws, f_ws);
    const double u = glm::dot(p_ws, u_ws);
    const bool along_f = std::abs(f) >= std::abs(v);
    const std::size_t towards = along_f ? (f >= 0.0 ? 0 : 2) : (v >= 0.0 ? 1 : 3);
    const double z = std::max(std::abs(f), std::abs(v));
    const std::size_t part = std::abs(u) <= z ? 0 : u > 0.0 ? 1 : 2;
    const int window = window_towards[4 * part + towards];
    if (window < 0 || std::max(u - along.front(), along.back() - u) > kWidestAlong * z) {
        return std::nullopt;
    }
    return static_cast<std::size_t>(window);
}

LinearPoint LinearViews::point_in(std::size_t window, const glm::dvec3& p_ws, const glm::dvec3& n_ws) const {
    const MapFace& face = windows[window].common();
    const glm::dmat3 rows = glm::transpose(face.ls_from_world);
    const glm::dvec3 p{glm::dot(u_ws, p_ws), glm::dot(rows[1], p_ws), glm::dot(rows[2], p_ws)};
    const glm::dvec3 n{glm::dot(u_ws, n_ws), glm::dot(rows[1], n_ws), glm::dot(rows[2], n_ws)};
    LinearPoint point;
    point.has_plane = true;
    point.normal_uv = {n.x, n.y};
    if (orthographic) {
        point.uv = {p.x, p.y};
        point.d = face.far_m - p.z;
        point.towards = -n.z;
    } else {
        point.uv = {p.x / p.z, p.y / p.z};
        point.d = 1.0 / p.z;
        point.towards = -glm::dot(n, p);
    }
    return point;
}

std::vector<LinearMap> linear_maps(const LinearViews& views, std::size_t window, std::span<const float> stored,
                                   int first_layer, int size_px) {
    const LinearWindow& seen = views.windows[window];
    const double d_per_stored = 1.0 / views.stored_per_d(window);
    const auto texels = static_cast<std::size_t>(size_px) * static_cast<std::size_t>(size_px);
    std::vector<LinearMap> maps;
    for (int sample = 0; sample < views.samples(); ++sample) {
        const auto k = static_cast<std::size_t>(sample);
        LinearMap map;
        map.width_px = map.height_px = size_px;
        map.along = views.along[k];
        map.low = {seen.low_u[k], seen.common().low.y};
        map.step = seen.step;
        const std::size_t layer = static_cast<std::size_t>(first_layer) + window * views.along.size() + k;
        const std::span<const float> own = stored.subspan(layer * texels, texels);
        map.d.resize(texels);
        std::ranges::transform(own, map.d.begin(),
                               [&](float value) { return d_per_stored * static_cast<double>(value); });
        maps.push_back(std::move(map));
    }
    return maps;
}

double LinearViews::stored_per_d(std::size_t window) const {
    const MapFace& face = windows[window].common();
    return orthographic ? 1.0 / (face.far_m - face.near_m) : face.near_m;
}

std::vector<double> even_places(int count) {
    std::vector<double> places;
    places.reserve(static_cast<std::size_t>(count));
    for (int i = 0; i < count; ++i) {
        places.push_back(count > 1 ? 2.0 * i / (count - 1) - 1.0 : 0.0);
    }
    return places;
}

LinearViews fit_linear_views(const LightSummary& summary, const LinearRod& rod, const std::vector<double>& places,
                             const glm::dvec3& aim_ws, int size_px) {
    LinearViews views;
    views.orthographic = summary.light->kind == LightKind::Sun;
    views.origin_ws = views.orthographic ? summary.receivers_ws.centre() : rod.centre_ws;
    // A sun's directions count by their slope against the middle one.
    const double half = glm::length(rod.half_ws) / (views.orthographic ? glm::length(rod.centre_ws) : 1.0);
    Sectors sectors;
    sectors.orthographic = views.orthographic;
    for (const double place : places) {
        views.along.push_back(half * place);
    }
    sectors.along = views.along;
    if (summary.receiver_points_cr.empty()) {
        return views;
    }
    const Surroundings around{summary, views.origin_ws, summary.eye_ws - views.origin_ws};
    if (views.orthographic) {
        sectors.f = glm::normalize(rod.centre_ws);
        // A point moves against the slope of its ray.
        sectors.u = half > 0.0 ? -glm::normalize(rod.half_ws) : any_perpendicular(sectors.f);
    } else {
        glm::dvec3 aim = aim_ws - views.origin_ws;
        if (half > 0.0) {
            sectors.u = rod.half_ws / half;
            aim -= glm::dot(aim, sectors.u) * sectors.u;
        }
        sectors.f = glm::length(aim) > 0.0 ? glm::normalize(aim)
                                           : any_perpendicular(half > 0.0 ? sectors.u : glm::dvec3{0, 0, 1});
        if (!(half > 0.0)) {
            sectors.u = any_perpendicular(sectors.f);
        }
    }
    sectors.v = glm::cross(sectors.f, sectors.u);
    views.u_ws = sectors.u;
    views.v_ws = sectors.v;
    views.f_ws = sectors.f;

    std::vector<Seen> seen(kMostWindows, Seen{places.size()});
    const auto corners = [&](const ReceiverTile& tile) {
        auto all = corners_of(glm::dvec3{tile.low_cr}, glm::dvec3{tile.high_cr});
        for (glm::dvec3& corner : all) {
            corner += around.eye_from_origin;
        }
        return all;
    };
    const bool one = std::ranges::all_of(summary.tiles, [&](const ReceiverTile& tile) {
        return std::ranges::all_of(corners(tile), [&](const glm::dvec3& p) { return sectors.inside(0, p, kWidest); });
    });
    views.in_one_window = one;
    for (const ReceiverTile& tile : summary.tiles) {
        // A tile whose box widens nothing needs no look at its points. (Boxes themselves would make windows that depend
        // on how the scene lies to the world's axes.)
        const auto box = corners(tile);
        bool done = false;
        for (int i = 0; i < (one ? 1 : kMostWindows) && !done;
             ++i) {  // windows are convex, so a box is inside with its corners
            const Seen& in = seen[static_cast<std::size_t>(i)];
            done = std::ranges::all_of(box, [&](const glm::dvec3& p) {
                return (one || sectors.inside(i, p, 1.0)) && sectors.within(i, p, in);
            });
        }
        for (std::uint32_t k = 0; !done && k < tile.pixel_count; ++k) {
            const glm::dvec3 p = glm::dvec3{summary.receiver_points_cr[tile.first_pixel + k]} + around.eye_from_origin;
            bool found = false;
            for (int i = 0; i < (one ? 1 : kMostWindows); ++i) {
                if (one || sectors.inside(i, p, 1.0)) {
                    sectors.add(i, p, seen[static_cast<std::size_t>(i)]);
                    found = true;
                    break;
                }
            }
            if (!found) {
                views.outside_cr.push_back(summary.receiver_points_cr[tile.first_pixel + k]);
            }
        }
    }
    for (int i = 0; i < (one ? 1 : kMostWindows); ++i) {
        const Seen& in = seen[static_cast<std::size_t>(i)];
        if (in.empty() && !summary.keeps("cube-face-without-receivers")) {
            views.windows_without_receivers.emplace_back(kWindowNames[static_cast<std::size_t>(i)]);
        } else {
            views.window_towards[static_cast<std::size_t>(i)] = static_cast<int>(views.windows.size());
            views.windows.push_back(make_window(around, sectors, i, in, size_px));
        }
    }
    return views;
}

}  // namespace penumbra
