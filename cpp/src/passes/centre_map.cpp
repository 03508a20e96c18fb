#include "passes/centre_map.h"

#include <algorithm>

#include "passes/casters_beside.h"
#include "passes/frame.h"

namespace penumbra {

namespace {

std::string step_name(const MapFace& face) {
    return "depth map, " + face.name;
}
std::string peel_name(const MapFace& face) {
    return "second depth map, " + face.name;
}

std::string receiver_name(const MapFace& face) {
    return "receiver depth map, " + face.name;
}

/// Casters of the face, and all receivers: a depth map keeps the nearest of them.
std::vector<std::uint32_t> casters_and_receivers(const LightSummary& summary, const MapFace& face) {
    std::vector<std::uint32_t> instances = casters_in(summary, face);
    instances.insert(instances.end(), summary.receivers.begin(), summary.receivers.end());
    std::ranges::sort(instances);
    instances.erase(std::ranges::unique(instances).begin(), instances.end());
    return instances;
}

}  // namespace

bool CentreMap::needs_receiver_map(const LightSummary& summary) const noexcept {
    // A receiver that cannot cast onto any other (a floor) is left out of the casters.
    const auto casts = [&](std::uint32_t receiver) {
        return std::ranges::find(summary.casters, receiver) != summary.casters.end();
    };
    // Culled casters leave no nearest surface.
    return wants_receivers(summary) &&
           (!std::ranges::all_of(summary.receivers, casts) || summary.receivers_not_casting > 0 ||
            summary.keeps("every-receiver-casts") || options_.bias.cull() != Cull::None);
}

MapFrustum CentreMap::fit(const LightSummary& summary) const {
    const Light& light = *summary.light;
    MapFrustumOptions options = frustum_options_;
    options.keep_receivers = wants_receivers(summary);
    return fit_map_frustum(summary, light.position_ws, light.direction_ws, options);
}

bool CentreMap::plan(const LightSummary& summary, std::string_view lookup, Plan& plan) const {
    const LightSummary::Trivial trivial = summary.trivial();
    if (!trivial.reason.empty()) {
        plan.leave_out("depth map", trivial.rule, trivial.reason);
        plan.leave_out(std::string{lookup}, trivial.rule, trivial.reason);
        return false;
    }
    const MapFrustum frustum = fit(summary);
    for (const MapFace& face : frustum.faces) {
        plan.run(step_name(face));
        if (midpoint()) {
            plan.run(peel_name(face));
        }
        if (needs_receiver_map(summary)) {
            plan.run(receiver_name(face));
        }
    }
    for (const std::string& face : frustum.faces_without_receivers) {
        plan.leave_out("depth map, " + face, "cube-face-without-receivers",
                       "no visible receiver lies in this face of the light's cube");
    }
    CastersBeside beside;
    for (const MapFace& face : frustum.faces) {
        beside.add(summary, face);
    }
    beside.tell(plan);
    if (wants_receivers(summary) && !needs_receiver_map(summary)) {
        plan.leave_out("receiver depth map", "every-receiver-casts",
                       "every visible receiver is among the casters, so their map holds it");
    }
    beside.tell_of_hull(summary, plan);
    plan.run(std::string{lookup});
    return true;
}

void CentreMap::allocate(Frame& frame) {
    frustum_ = fit(frame.summary());
    const int layers = static_cast<int>(frustum_.faces.size());
    MapLayers* shared = options_.shared_layers ? frame.map_layers() : nullptr;
    if (layers > 0) {
        map_.allocate(options_.size_px, layers, "depth map", shared);
        if (midpoint()) {
            second_map_.allocate(options_.size_px, layers, "second depth map", shared);
        }
        if (needs_receiver_map(frame.summary())) {
            receiver_map_.allocate(options_.size_px, layers, "receiver depth map", shared);
        } else {
            receiver_map_ = DepthMap{};
        }
    }
}

void CentreMap::update(Frame& frame) {
    allocate(frame);
    if (frustum_.faces.empty()) {
        return;
    }
    block_ =
        make_map_block(frustum_, frame.light(), frame.light().direction_ws, frame.summary().eye_ws, options_.size_px);
    GpuScene& casters = caster_scene_ != nullptr ? *caster_scene_ : frame.gpu_scene();
    setup_.bind_for_depth(casters, frustum_, block_);
    for (std::size_t i = 0; i < frustum_.faces.size(); ++i) {
        const int layer = static_cast<int>(i);
        const auto instances = casters_in(frame.summary(), frustum_.faces[i]);
        frame.step(step_name(frustum_.faces[i]),
                   [&] { map_.render(frame, casters, instances, i, layer, options_.bias.cull()); });
        if (midpoint()) {
            frame.step(peel_name(frustum_.faces[i]),
                       [&] { second_map_.render(frame, casters, instances, i, layer, Cull::None, &map_); });
        }
    }
    if (needs_receiver_map(frame.summary())) {
        for (std::size_t i = 0; i < frustum_.faces.size(); ++i) {
            frame.step(receiver_name(frustum_.faces[i]), [&] {
                receiver_map_.render(frame, casters, casters_and_receivers(frame.summary(), frustum_.faces[i]), i,
                                     static_cast<int>(i), Cull::None);
            });
        }
    }
}

const Program& CentreMap::lookup(Frame& frame, std::string_view fragment, const Defines& more) const {
    Defines all = defines();
    all.insert(all.end(), more.begin(), more.end());
    return frame.device().programs.get({"lib/fullscreen.vert", fragment}, all);
}

void CentreMap::bind(const Program& program) {
    setup_.bind_for_lookup(block_);
    options_.bias.set_uniforms(program);
    if (map_.texture()) {
        map_.texture().bind(2);
    }
    if (midpoint() && second_map_.texture()) {
        second_map_.texture().bind(3);
    }
}

}  // namespace penumbra
