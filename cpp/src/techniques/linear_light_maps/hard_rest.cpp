#include "techniques/linear_light_maps/hard_rest.h"

#include <algorithm>

#include "passes/frame.h"

namespace penumbra {

namespace {

/// The summary as if the camera saw these points alone. What is not asked by frusta and depth maps stays empty.
LightSummary summary_of(const LightSummary& whole, const std::vector<glm::vec3>& points_cr) {
    constexpr std::size_t kTile = 256;
    LightSummary rest;
    rest.light = whole.light;
    rest.scene = whole.scene;
    rest.view = whole.view;
    rest.eye_ws = whole.eye_ws;
    rest.has_extent = whole.has_extent;
    rest.keep = whole.keep;
    rest.receivers = whole.receivers;
    rest.casters = whole.casters;
    rest.caster_needed = whole.caster_needed;
    rest.caster_bounds_ws = whole.caster_bounds_ws;
    rest.near_hull = whole.near_hull;
    rest.near_hull_bounds_ws = whole.near_hull_bounds_ws;
    rest.receiver_points_cr = points_cr;
    rest.lit_pixels = points_cr.size();
    for (std::size_t first = 0; first < points_cr.size(); first += kTile) {
        ReceiverTile tile{points_cr[first], points_cr[first], static_cast<std::uint32_t>(first), 0};
        tile.pixel_count = static_cast<std::uint32_t>(std::min(kTile, points_cr.size() - first));
        for (std::size_t i = first; i < first + tile.pixel_count; ++i) {
            tile.low_cr = glm::min(tile.low_cr, points_cr[i]);
            tile.high_cr = glm::max(tile.high_cr, points_cr[i]);
        }
        rest.receivers_ws.add(whole.eye_ws + glm::dvec3{tile.low_cr});
        rest.receivers_ws.add(whole.eye_ws + glm::dvec3{tile.high_cr});
        rest.tiles.push_back(tile);
    }
    return rest;
}

}  // namespace

void set_windows(const Program& program, const LinearViews& views) {
    program.set("rod_u", glm::vec3{views.u_ws});
    program.set("rod_v", glm::vec3{views.v_ws});
    program.set("rod_f", glm::vec3{views.f_ws});
    program.set("window_towards", std::span<const int>{views.window_towards});
    program.set("rod_reach", glm::vec3{glm::dvec3{views.along.front(), views.along.back(), kWidestAlong}});
}

void HardRest::add(const LightSummary& summary, const LinearViews& views, double weight, const glm::dvec3& axis_ws,
                   int size_px) {
    if (views.outside_cr.empty()) {
        return;
    }
    Rod rod;
    rod.summary = summary_of(summary, views.outside_cr);
    rod.views = &views;
    const double length = views.along.back() - views.along.front();
    for (std::size_t k = 0; k < views.along.size(); ++k) {
        MapFrustum frustum =
            fit_map_frustum(rod.summary, views.eye_ws(static_cast<int>(k)), axis_ws, {.size_px = size_px});
        rod.blocks.push_back(make_map_block(frustum, *summary.light, axis_ws, summary.eye_ws, size_px));
        rod.first_layers.push_back(layers_);
        layers_ += static_cast<int>(frustum.faces.size());
        rod.frusta.push_back(std::move(frustum));
        // Trapezoid weights: half of either segment beside the sample.
        const double before = k > 0 ? views.along[k] - views.along[k - 1] : 0.0;
        const double after = k + 1 < views.along.size() ? views.along[k + 1] - views.along[k] : 0.0;
        rod.weights.push_back(
            weight * (length > 0.0 ? 0.5 * (before + after) / length : 1.0 / static_cast<double>(views.along.size())));
    }
    rods_.push_back(std::move(rod));
}

void HardRest::render(Frame& frame, int size_px) {
    maps_.allocate(size_px, std::max(1, layers_), "maps beyond the windows");
    for (const Rod& rod : rods_) {
        for (std::size_t k = 0; k < rod.frusta.size(); ++k) {
            setup_.bind_for_depth(frame.gpu_scene(), rod.frusta[k], rod.blocks[k]);
            for (std::size_t face = 0; face < rod.frusta[k].faces.size(); ++face) {
                maps_.render(frame, frame.gpu_scene(), casters_in(rod.summary, rod.frusta[k].faces[face]), face,
                             rod.first_layers[k] + static_cast<int>(face), Cull::None);
            }
        }
    }
}

void HardRest::accumulate(Frame& frame, RenderTarget& sums, const MapBias& bias, bool facing_test) {
    frame.bind_view();
    maps_.texture().bind(2);
    for (const Rod& rod : rods_) {
        for (std::size_t k = 0; k < rod.frusta.size(); ++k) {
            setup_.bind_for_lookup(rod.blocks[k]);
            const Program& program =
                frame.device().programs.get({"lib/fullscreen.vert", "techniques/linear_light_maps/hard_rest.frag"},
                                            bias.defines(rod.frusta[k], facing_test));
            bias.set_uniforms(program);
            set_windows(program, *rod.views);
            program.set("rod_centre_cr", glm::vec3{rod.views->origin_ws - frame.summary().eye_ws});
            program.set("first_layer", rod.first_layers[k]);
            program.set("weight", static_cast<float>(rod.weights[k]));
            frame.fullscreen().draw(sums, program);
        }
    }
}

}  // namespace penumbra
