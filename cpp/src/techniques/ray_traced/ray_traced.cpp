#include "techniques/ray_traced/ray_traced.h"

#include <algorithm>

#include "passes/frame.h"
#include "reference/ray_scene.h"
#include "reference/visibility_tracer.h"
#include "techniques/all_lights.h"

namespace penumbra {

const TechniqueInfo& RayTraced::description() {
    static const TechniqueInfo info{
        .id = "ray_traced",
        .title = "Ray tracing",
        .paper = "Cook1984",
        .summary = "N stratified shadow rays per pixel on the CPU: right on average, noisy until N is large.",
        .randomised = true,
        .on_cpu = true,
        .lights = all_light_kinds(),
        .settings =
            {
                {.id = "rays",
                 .label = "Rays",
                 .unit = "rays",
                 .help = "Shadow rays per pixel.",
                 .default_value = 16,
                 .minimum = 1,
                 .maximum = 65536,
                 .choices = {},
                 .sweep = {1, 4, 16, 64, 256, 1024}},
                {.id = "seed",
                 .label = "Seed",
                 .unit = "",
                 .help = "Equal seeds give equal images.",
                 .default_value = 1,
                 .minimum = 0,
                 .maximum = 2147483647,
                 .choices = {},
                 .sweep = {}},
                {.id = "early_out",
                 .label = "Early out",
                 .unit = "",
                 .help =
                     "Stops a pixel when its first rays all agree: faster, but thin penumbrae are biased to 0 or 1.",
                 .default_value = false,
                 .minimum = 0,
                 .maximum = 0,
                 .choices = {},
                 .sweep = {}},
                {.id = "early_out_rays",
                 .label = "First rays",
                 .unit = "rays",
                 .help = "How many rays must agree before the early out.",
                 .default_value = 16,
                 .minimum = 1,
                 .maximum = 4096,
                 .choices = {},
                 .sweep = {}},
            },
        .knob = "rays",
    };
    return info;
}

RayTraced::RayTraced(const Settings& settings)
    : rays_{get_int(settings, "rays")},
      seed_{static_cast<std::uint32_t>(get_int(settings, "seed"))},
      early_out_{get_bool(settings, "early_out")},
      early_out_rays_{get_int(settings, "early_out_rays")} {}

Verdict RayTraced::supports(const Light& /*light*/) const {
    return {};
}

Plan RayTraced::plan(const LightSummary& summary) const {
    Plan plan;
    const LightSummary::Trivial trivial = summary.trivial();
    if (!trivial.reason.empty()) {
        plan.leave_out("rays", trivial.rule, trivial.reason);
        return plan;
    }
    if (!summary.has_extent && rays_ > 1 && !summary.keeps("light-without-extent")) {
        plan.leave_out("further rays", "light-without-extent",
                       "the light has no extent: all " + std::to_string(rays_) + " rays are the same");
    }
    const std::uint64_t outside = summary.mask.size() - summary.lit_pixels;
    if (outside > 0 && !summary.keeps("pixel-outside-mask")) {
        plan.leave_out("rays outside the mask", "pixel-outside-mask",
                       std::to_string(outside) + " pixels see no surface or face away from the whole light");
    }
    plan.run("rays");
    return plan;
}

void RayTraced::prepare(Frame& frame) {
    if (frame.plan().runs("rays")) {
        static_cast<void>(frame.ray_scene());
    }
}

void RayTraced::update(Frame& /*frame*/) {}

void RayTraced::resolve(Frame& frame) {
    frame.step("rays", [&] {
        const LightSummary& summary = frame.summary();
        const TraceOptions options{.rays_per_pixel = rays_,
                                   .seed = seed_,
                                   .early_out = early_out_,
                                   .early_out_rays = early_out_rays_,
                                   .repeat_single_point = summary.keeps("light-without-extent")};
        std::vector<std::uint8_t> all;
        if (summary.keeps("pixel-outside-mask")) {
            const View& view = frame.view();
            all.resize(view.size());
            std::ranges::transform(view.instance, all.begin(), [](std::int32_t seen) { return seen >= 0 ? 1 : 0; });
        }
        rays_cast_ =
            trace_visibility(frame.ray_scene(), frame.scene(), frame.view(), frame.light(),
                             all.empty() ? summary.mask : all, options, frame.visibility_on_cpu(), frame.control());
    });
}

std::vector<Statistic> RayTraced::statistics(Frame& frame) {
    if (!frame.plan().runs("rays")) {
        return {};
    }
    return {{.id = "rays", .label = "Rays cast", .unit = "rays", .value = static_cast<double>(rays_cast_)}};
}

}  // namespace penumbra
