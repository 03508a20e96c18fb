#include "techniques/pcf/pcf.h"

#include <array>

#include "passes/debug_picture.h"
#include "passes/frame.h"
#include "techniques/all_lights.h"

namespace penumbra {

namespace {

constexpr std::array kFilters{"2x2", "bicubic16", "bicubic4", "box"};

constexpr int kBox = 3;
constexpr int kLeastMaskedKernel = 24;  // below, finding the range of depths costs about what it saves

int filter_index(const Settings& settings) {
    const std::string& filter = get_choice(settings, "filter");
    for (std::size_t i = 0; i < kFilters.size(); ++i) {
        if (kFilters[i] == filter) {
            return static_cast<int>(i);
        }
    }
    return 0;
}

/// Texels that the filter reaches beyond the receiver's, for the margin of the map.
double reach_texels(const Settings& settings) {
    const int filter = filter_index(settings);
    if (filter == 0) {
        return 2.0;
    }
    return filter == kBox ? 0.5 * get_int(settings, "kernel") + 2.0 : 4.0;
}

std::vector<SettingInfo> pcf_settings() {
    std::vector<SettingInfo> settings = map_settings("slope", false);
    settings.push_back({.id = "filter",
                        .label = "Filter",
                        .unit = "",
                        .help = "Weights of the comparisons: 2x2 bilinear, bicubic by 16 or by 4 fetches, or a box.",
                        .default_value = std::string{"box"},
                        .minimum = 0,
                        .maximum = 0,
                        .choices = {kFilters.begin(), kFilters.end()},
                        .sweep = {std::string{"2x2"}, std::string{"bicubic16"}}});
    settings.push_back({.id = "kernel",
                        .label = "Kernel",
                        .unit = "texel",
                        .help = "Width of the box filter; the width of every penumbra on the map.",
                        .default_value = 7,
                        .minimum = 1,
                        .maximum = 63,
                        .choices = {},
                        .sweep = {3, 5, 7, 15, 31},
                        .sweep_when = {.setting = "filter", .value = "box"}});
    settings.push_back(
        {.id = "mask",
         .label = "Mask",
         .unit = "",
         .help = "Box filter: compares only where nearest and farthest depth under the kernel leave it open.",
         .default_value = true,
         .minimum = 0,
         .maximum = 0,
         .choices = {},
         .sweep = {}});
    return settings;
}

}  // namespace

const TechniqueInfo& Pcf::description() {
    static const TechniqueInfo info{
        .id = "pcf",
        .title = "Percentage-closer filtering",
        .paper = "Reeves1987",
        .summary = "Averages the comparisons of many texels of one depth map: edges softened by a fixed width.",
        .randomised = false,
        .on_cpu = false,
        .lights = all_light_kinds(),
        .settings = pcf_settings(),
        .knob = "kernel",
    };
    return info;
}

Pcf::Pcf(const Settings& settings)
    : filter_{filter_index(settings)},
      kernel_{get_int(settings, "kernel")},
      mask_{get_bool(settings, "mask") && filter_ == kBox && kernel_ >= kLeastMaskedKernel &&
            map_bias_from(settings).mode != MapBias::Mode::ReceiverPlane},
      map_{{.size_px = get_int(settings, "map_size"),
            .bias = map_bias_from(settings),
            .facing_test = get_bool(settings, "facing_test"),
            .margin_texels = reach_texels(settings)}} {}

Verdict Pcf::supports(const Light& /*light*/) const {
    return {};
}

FieldOfUse Pcf::field_of_use() const {
    return {.needs_point_light = true, .needs_clear_light = true, .needs_light_above_horizon = map_.facing_test()};
}

Plan Pcf::plan(const LightSummary& summary) const {
    Plan plan;
    if (map_.plan(summary, "filtered lookup", plan) && mask_ && !summary.keeps("kernel-on-one-side")) {
        plan.run("depths under the kernel");
        plan.leave_out("comparisons that agree", "kernel-on-one-side",
                       "where all depths under the kernel lie on one side of the receiver, one answer serves for all " +
                           std::to_string((kernel_ + 1) * (kernel_ + 1)));
    }
    return plan;
}

const Program& Pcf::lookup(Frame& frame) const {
    const bool masked = frame.plan().runs("depths under the kernel");
    return map_.lookup(frame, "techniques/pcf/pcf.frag",
                       {{"FILTER", std::to_string(filter_)}, {"MASK", masked ? "1" : "0"}});
}

void Pcf::prepare(Frame& frame) {
    if (!frame.plan().runs("filtered lookup")) {
        return;
    }
    map_.allocate(frame);
    static_cast<void>(lookup(frame));
    compare_sampler_ = Sampler::create();
    const GLuint sampler = compare_sampler_.name();
    glSamplerParameteri(sampler, GL_TEXTURE_MIN_FILTER, GL_LINEAR);
    glSamplerParameteri(sampler, GL_TEXTURE_MAG_FILTER, GL_LINEAR);
    glSamplerParameteri(sampler, GL_TEXTURE_WRAP_S, GL_CLAMP_TO_EDGE);
    glSamplerParameteri(sampler, GL_TEXTURE_WRAP_T, GL_CLAMP_TO_EDGE);
    glSamplerParameteri(sampler, GL_TEXTURE_COMPARE_MODE, GL_COMPARE_REF_TO_TEXTURE);
    glSamplerParameteri(sampler, GL_TEXTURE_COMPARE_FUNC, GL_GEQUAL);
}

void Pcf::update(Frame& frame) {
    if (frame.plan().runs("filtered lookup")) {
        map_.update(frame);
        frame.step("depths under the kernel", [&] { range_.update(frame, map_.texture(), kernel_ + 1); });
    }
}

void Pcf::resolve(Frame& frame) {
    frame.step("filtered lookup", [&] {
        const Program& program = lookup(frame);
        map_.bind(program);
        if (program.has("kernel")) {
            program.set("kernel", kernel_);
        }
        map_.texture().bind(3);
        if (range_.texture()) {
            range_.texture().bind(4);
        }
        glBindSampler(3, compare_sampler_.name());
        frame.resolve_with(program);
        glBindSampler(3, 0);
    });
}

std::vector<DebugView> Pcf::debug_views(const Plan& plan) const {
    return plan.runs("lookup") ? std::vector<DebugView>{depth_map_view()} : std::vector<DebugView>{};
}

DebugImage Pcf::debug_image(Frame& frame, std::string_view /*id*/) {
    return depth_map_picture(frame, map_);
}

}  // namespace penumbra
