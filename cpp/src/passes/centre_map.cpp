#include "passes/centre_map.h"

#include "passes/frame.h"

namespace penumbra {

namespace {

std::string step_name(const MapFace& face) {
    return "depth map, " + face.name;
}
std::string peel_name(const MapFace& face) {
    return "second depth map, " + face.name;
}

}  // namespace

bool CentreMap::plan(const LightSummary& summary, std::string_view lookup, Plan& plan) const {
    const LightSummary::Trivial trivial = summary.trivial();
    if (!trivial.reason.empty()) {
        plan.leave_out("depth map", trivial.rule, trivial.reason);
        plan.leave_out(std::string{lookup}, trivial.rule, trivial.reason);
        return false;
    }
    const Light& light = *summary.light;
    const MapFrustum frustum = fit_map_frustum(summary, light.position_ws, light.direction_ws, options_);
    for (const MapFace& face : frustum.faces) {
        plan.run(step_name(face));
        if (midpoint()) {
            plan.run(peel_name(face));
        }
    }
    for (const std::string& face : frustum.faces_without_receivers) {
        plan.leave_out("depth map, " + face, "cube-face-without-receivers",
                       "no visible receiver lies in this face of the light's cube");
    }
    if (summary.casters_outside > 0) {
        plan.leave_out("casters out of reach", "caster-outside-hull",
                       std::to_string(summary.casters_outside) +
                           " casters lie outside the space between the light and the visible receivers");
    }
    plan.run(std::string{lookup});
    return true;
}

void CentreMap::allocate(Frame& frame) {
    const Light& light = frame.light();
    frustum_ = fit_map_frustum(frame.summary(), light.position_ws, light.direction_ws, options_);
    const int layers = static_cast<int>(frustum_.faces.size());
    if (layers > 0) {
        map_.allocate(options_.size_px, layers, "depth map");
        if (midpoint()) {
            second_map_.allocate(options_.size_px, layers, "second depth map");
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
    setup_.bind_for_depth(frame, frustum_, block_);
    for (std::size_t i = 0; i < frustum_.faces.size(); ++i) {
        const int layer = static_cast<int>(i);
        frame.step(step_name(frustum_.faces[i]), [&] { map_.render(frame, frustum_, i, layer, bias_.cull()); });
        if (midpoint()) {
            frame.step(peel_name(frustum_.faces[i]),
                       [&] { second_map_.render(frame, frustum_, i, layer, Cull::None, &map_); });
        }
    }
}

const Program& CentreMap::lookup(Frame& frame, std::string_view fragment, const Defines& more) const {
    Defines defines = bias_.defines(frustum_, facing_test_);
    defines.insert(defines.end(), more.begin(), more.end());
    return frame.device().programs.get({"lib/fullscreen.vert", fragment}, defines);
}

void CentreMap::bind(const Program& program) {
    setup_.bind_for_lookup(block_);
    bias_.set_uniforms(program);
    if (map_.texture()) {
        map_.texture().bind(2);
    }
    if (midpoint() && second_map_.texture()) {
        second_map_.texture().bind(3);
    }
}

}  // namespace penumbra
