#include "techniques/shadow_volume/shadow_volume.h"

#include "passes/frame.h"
#include "passes/volume_debug.h"
#include "techniques/all_lights.h"

namespace penumbra {

const TechniqueInfo& ShadowVolume::description() {
    static const TechniqueInfo info{
        .id = "shadow_volume",
        .title = "Shadow volumes",
        .paper = "Crow1977",
        .summary =
            "Counts the faces of every caster's shadow volume at each pixel: hard edges exact to the pixel, without "
            "map "
            "or bias.",
        .randomised = false,
        .on_cpu = false,
        .lights = all_light_kinds(),
        .settings = volume_settings(),
        .knob = "",
    };
    return info;
}

ShadowVolume::ShadowVolume(const Settings& settings) : volumes_{volume_options(settings)} {}

Verdict ShadowVolume::supports(const Light& /*light*/) const {
    return {};
}

FieldOfUse ShadowVolume::field_of_use() const {
    return {.needs_point_light = true, .needs_light_above_horizon = true};
}

Plan ShadowVolume::plan(const LightSummary& summary) const {
    Plan plan;
    volumes_.plan(summary, "lookup", plan);
    return plan;
}

void ShadowVolume::prepare(Frame& frame) {
    if (frame.plan().runs("lookup")) {
        volumes_.prepare(frame);
    }
}

void ShadowVolume::update(Frame& frame) {
    frame.step("volumes", [&] { volumes_.extract(frame); });
}

void ShadowVolume::resolve(Frame& frame) {
    frame.step("count", [&] { volumes_.count(frame); });
    frame.step("lookup", [&] {
        const Program& lookup =
            frame.device().programs.get({"lib/fullscreen.vert", "techniques/shadow_volume/shadow_volume.frag"},
                                        volumes_.in_image() ? Defines{{"COUNT_IN_IMAGE"}} : Defines{});
        volumes_.bind_counts(2);
        frame.resolve_with(lookup);
    });
}

std::vector<DebugView> ShadowVolume::debug_views(const Plan& plan) const {
    return plan.runs("lookup") ? volume_views() : std::vector<DebugView>{};
}

DebugImage ShadowVolume::debug_image(Frame& frame, std::string_view id) {
    return volume_picture(frame, volumes_, id);
}

std::vector<Statistic> ShadowVolume::statistics(Frame& frame) {
    if (!frame.plan().runs("lookup")) {
        return {};
    }
    return volume_statistics(frame, volumes_);
}

}  // namespace penumbra
