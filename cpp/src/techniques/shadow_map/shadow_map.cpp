#include "techniques/shadow_map/shadow_map.h"

#include "passes/debug_picture.h"
#include "passes/frame.h"
#include "techniques/all_lights.h"

namespace penumbra {

namespace {

constexpr const char* kLookup = "techniques/shadow_map/shadow_map.frag";

}  // namespace

const TechniqueInfo& ShadowMap::description() {
    static const TechniqueInfo info{
        .id = "shadow_map",
        .title = "Hard shadow map",
        .paper = "Williams1978",
        .summary =
            "One depth map from the light's centre and one comparison per pixel: hard edges, whatever the size of the "
            "light.",
        .randomised = false,
        .on_cpu = false,
        .lights = all_light_kinds(),
        .settings = map_settings("slope", true),
        .knob = "map_size",
    };
    return info;
}

ShadowMap::ShadowMap(const Settings& settings)
    : map_{{.size_px = get_int(settings, "map_size"),
            .bias = map_bias_from(settings),
            .facing_test = get_bool(settings, "facing_test")}} {}

Verdict ShadowMap::supports(const Light& /*light*/) const {
    return {};
}

FieldOfUse ShadowMap::field_of_use() const {
    return {.needs_point_light = true, .needs_clear_light = true, .needs_light_above_horizon = map_.facing_test()};
}

Plan ShadowMap::plan(const LightSummary& summary) const {
    Plan plan;
    map_.plan(summary, "lookup", plan);
    return plan;
}

void ShadowMap::prepare(Frame& frame) {
    if (frame.plan().runs("lookup")) {
        map_.allocate(frame);
        static_cast<void>(map_.lookup(frame, kLookup));
    }
}

void ShadowMap::update(Frame& frame) {
    if (frame.plan().runs("lookup")) {
        map_.update(frame);
    }
}

void ShadowMap::resolve(Frame& frame) {
    frame.step("lookup", [&] {
        const Program& lookup = map_.lookup(frame, kLookup);
        map_.bind(lookup);
        frame.resolve_with(lookup);
    });
}

std::vector<DebugView> ShadowMap::debug_views(const Plan& plan) const {
    return plan.runs("lookup") ? std::vector<DebugView>{depth_map_view()} : std::vector<DebugView>{};
}

DebugImage ShadowMap::debug_image(Frame& frame, std::string_view /*id*/) {
    return depth_map_picture(frame, map_);
}

}  // namespace penumbra
