#include "techniques/shadow_map/shadow_map.h"

#include "passes/frame.h"
#include "techniques/all_lights.h"

namespace penumbra {

const TechniqueInfo& ShadowMap::description() {
    static const TechniqueInfo info{
        .id = "shadow_map",
        .title = "Hard shadow map",
        .paper = "Williams1978",
        .summary = "One depth map from the light's centre and one comparison per pixel: hard edges, whatever the size of the light.",
        .randomised = false,
        .on_cpu = false,
        .lights = all_light_kinds(),
        .settings = map_settings("slope", true),
    };
    return info;
}

ShadowMap::ShadowMap(const Settings& settings)
    : facing_test_{get_bool(settings, "facing_test")},
      midpoint_{get_choice(settings, "bias") == "midpoint"},
      map_{get_int(settings, "map_size"), map_bias_from(settings), 2.0} {}

Verdict ShadowMap::supports(const Light&) const { return {}; }

Plan ShadowMap::plan(const LightSummary& summary) const {
    Plan plan;
    map_.plan(summary, "lookup", plan);
    return plan;
}

void ShadowMap::prepare(Frame& frame) {
    if (!frame.plan().runs("lookup")) {
        return;
    }
    ProgramLibrary& programs = frame.device().programs;
    lookup_ = midpoint_ ? &programs.get({"lib/fullscreen.vert", "techniques/shadow_map/shadow_map.frag"}, {{"MIDPOINT"}})
                        : &programs.get({"lib/fullscreen.vert", "techniques/shadow_map/shadow_map.frag"});
    map_.allocate(frame);
}

void ShadowMap::update(Frame& frame) {
    if (lookup_ != nullptr) {
        map_.update(frame);
    }
}

void ShadowMap::resolve(Frame& frame) {
    frame.step("lookup", [&] {
        map_.bind(frame, *lookup_, facing_test_);
        frame.resolve_with(*lookup_);
    });
}

}  // namespace penumbra
