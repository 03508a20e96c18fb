#include "techniques/masked_rays/masked_rays.h"

#include <algorithm>
#include <utility>

#include "passes/frame.h"
#include "reference/pilot_rays.h"
#include "reference/ray_scene.h"
#include "techniques/all_lights.h"

namespace penumbra {

namespace {

constexpr std::string_view kPilot = "pilot rays";

std::vector<SettingInfo> masked_rays_settings() {
    std::vector<SettingInfo> settings = PenumbraMask::settings();
    settings.push_back({.id = "mask_by",
                        .label = "Mask by",
                        .unit = "",
                        .help = "What finds the penumbrae: maps, which miss none, or one ray of each pixel, which is "
                                "faster where maps are dear to draw and may miss what is fine.",
                        .default_value = std::string{"maps"},
                        .minimum = 0,
                        .maximum = 0,
                        .choices = {"maps", "rays"},
                        .sweep = {std::string{"rays"}, std::string{"maps"}}});
    settings.push_back(
        {.id = "rays",
         .label = "Rays",
         .unit = "rays",
         .help = "Strata of the light where a pixel of a penumbra sees visibility change; fewer rays elsewhere.",
         .default_value = 256,
         .minimum = 1,
         .maximum = 65536,
         .choices = {},
         .sweep = {4, 8, 16, 32, 64, 128, 256, 512, 1024, 4096}});
    settings.push_back(
        {.id = "first_rays",
         .label = "First rays",
         .unit = "rays",
         .help = "Rays per pixel that may lie in a penumbra; more follow only where those around differ.",
         .default_value = 16,
         .minimum = 1,
         .maximum = 4096,
         .choices = {},
         .sweep = {64, 256}});
    settings.push_back({.id = "share",
                        .label = "Share",
                        .unit = "pixels",
                        .help = "Radius in which pixels of a surface share their first rays where V changes slowly; 0 "
                                "keeps V right on average.",
                        .default_value = 0,
                        .minimum = 0,
                        .maximum = 8,
                        .choices = {},
                        .sweep = {1, 0}});
    settings.push_back({.id = "check_rays",
                        .label = "Check rays",
                        .unit = "rays",
                        .help = "Rays per sure pixel that count, outside all times, how many are wrongly sure.",
                        .default_value = 4,
                        .minimum = 0,
                        .maximum = 65536,
                        .choices = {},
                        .sweep = {}});
    settings.push_back({.id = "seed",
                        .label = "Seed",
                        .unit = "",
                        .help = "Equal seeds give equal images.",
                        .default_value = 1,
                        .minimum = 0,
                        .maximum = 2147483647,
                        .choices = {},
                        .sweep = {}});
    return settings;
}

}  // namespace

const TechniqueInfo& MaskedRays::description() {
    static const TechniqueInfo info{
        .id = "masked_rays",
        .title = "Rays under a penumbra mask",
        .paper = "Chan2004",
        .summary = "Shadow maps find where a penumbra may be, and only there rays are traced: right on average.",
        .randomised = true,
        .on_cpu = false,
        .lights = all_light_kinds(),
        .settings = masked_rays_settings(),
        .knob = "rays",
    };
    return info;
}

MaskedRays::MaskedRays(const Settings& settings)
    : options_{.rays = get_int(settings, "rays"),
               .first_rays = get_int(settings, "first_rays"),
               .share = get_int(settings, "share"),
               .seed = static_cast<std::uint32_t>(get_int(settings, "seed"))},
      check_rays_{get_int(settings, "check_rays")},
      by_rays_{get_choice(settings, "mask_by") == "rays"},
      mask_{PenumbraMask::options_from(settings)} {}

Verdict MaskedRays::supports(const Light& /*light*/) const {
    return {};
}

Plan MaskedRays::plan(const LightSummary& summary) const {
    Plan plan;
    const LightSummary::Trivial trivial = summary.trivial();
    if (by_rays_) {
        PenumbraMask::plan(summary, plan, kPilot);
    } else {
        PenumbraMask::plan(summary, plan);
    }
    if (!trivial.reason.empty()) {
        plan.leave_out("rays", trivial.rule, trivial.reason);
        return plan;
    }
    if (summary.casters_outside > 0 && plan.runs("penumbra mask")) {
        plan.leave_out("casters out of reach", "caster-outside-hull",
                       std::to_string(summary.casters_outside) +
                           " casters lie outside the space between the light and the visible receivers, and are not "
                           "drawn into the mask's map");
    }
    plan.run("rays");
    return plan;
}

void MaskedRays::prepare(Frame& frame) {
    if (frame.plan().runs("rays")) {
        static_cast<void>(frame.ray_scene());
        mask_.prepare(frame);
    }
}

void MaskedRays::update(Frame& frame) {
    mask_.update(frame);
}

void MaskedRays::resolve(Frame& frame) {
    mask_.classify(frame);
    frame.step(kPilot, [&] {
        listed_.resize(frame.view().size());
        find_penumbrae(frame.ray_scene(), frame.view(), frame.light(), frame.summary().mask, options_.seed, listed_,
                       frame.visibility_on_cpu(), frame.control());
    });
    frame.step("rays", [&] {
        std::vector<float>& visibility = frame.visibility_on_cpu();
        if (!frame.plan().runs(kPilot)) {
            list_by_mask(frame);
        }
        counts_ = trace_masked(frame.ray_scene(), frame.view(), frame.light(), listed_, options_, visibility,
                               frame.control());
        if (frame.summary().keeps("pixel-outside-mask")) {
            trace_unasked(frame);
        }
    });
}

void MaskedRays::list_by_mask(Frame& frame) {
    const LightSummary& summary = frame.summary();
    std::vector<float>& visibility = frame.visibility_on_cpu();
    listed_.resize(visibility.size());
    classes_.assign(visibility.size(), static_cast<std::uint8_t>(PenumbraMask::Class::Maybe));
    // A light without extent has no mask: one ray each.
    if (frame.plan().runs("penumbra mask")) {
        mask_.read_classes(classes_);
    }
    for (std::size_t i = 0; i < listed_.size(); ++i) {
        const bool asked = summary.mask[i] != 0;
        const auto found = static_cast<PenumbraMask::Class>(classes_[i]);
        listed_[i] = asked && found == PenumbraMask::Class::Maybe ? 1 : 0;
        visibility[i] = !asked ? -1.0F : (found == PenumbraMask::Class::Umbra ? 0.0F : 1.0F);
    }
}

void MaskedRays::trace_unasked(Frame& frame) const {
    const View& view = frame.view();
    const bool by_pilot = frame.plan().runs(kPilot);
    std::vector<std::uint8_t> unasked(view.size());
    for (std::size_t i = 0; i < unasked.size(); ++i) {
        const bool maybe = by_pilot || static_cast<PenumbraMask::Class>(classes_[i]) == PenumbraMask::Class::Maybe;
        unasked[i] = view.hit(i) && frame.summary().mask[i] == 0 && maybe ? 1 : 0;
    }
    std::vector<float> nobodys(view.size(), -1.0F);
    if (by_pilot) {
        std::vector<std::uint8_t> open(view.size());
        find_penumbrae(frame.ray_scene(), view, frame.light(), unasked, options_.seed, open, nobodys, frame.control());
        unasked = std::move(open);
    }
    trace_masked(frame.ray_scene(), view, frame.light(), unasked, options_, nobodys, frame.control());
}

void MaskedRays::classify_by_pilot(Frame& frame) {
    const std::vector<float>& visibility = frame.visibility_on_cpu();
    classes_.resize(listed_.size());
    for (std::size_t i = 0; i < listed_.size(); ++i) {
        const auto sure = visibility[i] > 0.0F ? PenumbraMask::Class::Lit : PenumbraMask::Class::Umbra;
        const bool decided = frame.summary().mask[i] != 0 && listed_[i] == 0;
        classes_[i] = static_cast<std::uint8_t>(decided ? sure : PenumbraMask::Class::Maybe);
    }
}

std::vector<Statistic> MaskedRays::statistics(Frame& frame) {
    if (!frame.plan().runs("rays")) {
        return {};
    }
    std::vector<Statistic> all;
    std::uint64_t rays = counts_.rays;
    if (frame.plan().runs(kPilot)) {
        classify_by_pilot(frame);
        rays += frame.summary().lit_pixels;
    }
    if (frame.plan().runs("penumbra mask") || frame.plan().runs(kPilot)) {
        all = PenumbraMask::statistics(frame.summary(), classes_);
        if (check_rays_ > 0) {
            all.push_back(wrongly_sure(frame));
        }
    }
    const auto pixels = static_cast<double>(std::max<std::uint64_t>(1, counts_.pixels));
    const auto asked = static_cast<double>(std::max<std::uint64_t>(1, frame.summary().lit_pixels));
    all.push_back(
        {"full_share", "Pixels with all rays", "share of the mask", static_cast<double>(counts_.full_pixels) / asked});
    all.push_back({"rays", "Rays cast", "rays", static_cast<double>(rays)});
    all.push_back({"rays_per_traced_pixel", "Rays per traced pixel", "rays", static_cast<double>(rays) / pixels});
    return all;
}

Statistic MaskedRays::wrongly_sure(Frame& frame) const {
    const LightSummary& summary = frame.summary();
    std::vector<std::uint8_t> sure(classes_.size());
    for (std::size_t i = 0; i < sure.size(); ++i) {
        const bool maybe = static_cast<PenumbraMask::Class>(classes_[i]) == PenumbraMask::Class::Maybe;
        sure[i] = summary.mask[i] != 0 && !maybe ? 1 : 0;
    }
    std::vector<float> found(sure.size(), 1.0F);
    const MaskedTraceOptions plain{.rays = check_rays_, .first_rays = check_rays_, .share = 0, .seed = options_.seed};
    trace_masked(frame.ray_scene(), frame.view(), frame.light(), sure, plain, found, frame.control());
    std::uint64_t wrong = 0;
    for (std::size_t i = 0; i < sure.size(); ++i) {
        const bool lit = static_cast<PenumbraMask::Class>(classes_[i]) == PenumbraMask::Class::Lit;
        wrong += sure[i] != 0 && found[i] != (lit ? 1.0F : 0.0F) ? 1 : 0;
    }
    return {"mask_wrong", "Wrongly sure, by " + std::to_string(check_rays_) + " rays each", "share of the mask",
            static_cast<double>(wrong) / static_cast<double>(std::max<std::uint64_t>(1, summary.lit_pixels))};
}

std::vector<DebugView> MaskedRays::debug_views(const Plan& plan) const {
    return plan.runs("penumbra mask") ? PenumbraMask::debug_views() : std::vector<DebugView>{};
}

DebugImage MaskedRays::debug_image(Frame& frame, std::string_view id) {
    return mask_.debug_image(frame, id);
}

}  // namespace penumbra
