#include "techniques/smoothies/smoothies.h"

#include <algorithm>

#include "passes/debug_picture.h"
#include "passes/frame.h"
#include "scene/setting_forms.h"
#include "techniques/all_lights.h"

namespace penumbra {

namespace {

constexpr const char* kSilhouettes = "silhouettes";
constexpr const char* kBuffer = "smoothie buffer";
constexpr const char* kInner = "inner edges";
constexpr const char* kLookup = "lookup";
constexpr int kInnerUnit = 5;
constexpr glm::vec3 kOrange{1.0F, 0.45F, 0.1F};

const std::vector<std::string> kWidths{"light", "disc", "fixed"};
const std::vector<std::string> kFilters{"bilinear", "published", "nearest"};
const std::vector<std::string> kFalloffs{"sinusoidal", "linear", "cubic", "disc"};
const std::vector<std::string> kCorners{"fan", "thesis", "none"};
const std::vector<std::string> kPasses{"merged", "separate"};
const std::vector<std::string> kResize{"pixel", "vertex"};
const std::vector<std::string> kDepthFrom{"receivers", "casters"};
const std::vector<std::string> kStore{"auto", "on", "off"};

std::vector<SettingInfo> smoothie_settings() {
    std::vector<SettingInfo> settings = map_settings("slope", false);
    settings.push_back(silhouette_setting());
    settings.push_back(
        choice_setting("width", "Width",
                       "Of the smoothies: what the light's shape gives, or a disc of its area; or the plain t "
                       "as published, whatever the light.",
                       kWidths));
    settings.push_back(
        number_setting("t", "Plain width t", "half map",
                       "Width of a smoothie with width = fixed, in half extents of the map (a sun: metres of "
                       "penumbra per metre behind the caster); 0.02 to 0.2 are useful, 0 switches it off.",
                       0.05, 0.0, 4.0));
    settings.push_back(choice_setting("falloff", "Falloff", "From alpha to V.", kFalloffs));
    settings.push_back(
        choice_setting("filter", "Filter",
                       "Three-way test per texel, then bilinear; or the published shader, whose umbra grows by "
                       "up to a texel; or the nearest texel alone.",
                       kFilters));
    settings.push_back(toggle_setting(
        "remap", "Remap", "Penumbrae open with the distance from the contact; off: one width everywhere.", true));
    settings.push_back(
        choice_setting("corners", "Corners",
                       "Wedges of each fan of triangles; or the thesis' tip triangles where more than two "
                       "silhouettes meet; or none.",
                       kCorners));
    settings.push_back(
        choice_setting("depth_from", "Receiver depth",
                       "Whose depth the remap divides by: the nearest receiver's, or as published the nearest "
                       "caster's, too wide on receivers that do not cast.",
                       kDepthFrom));
    settings.push_back(
        choice_setting("store_depth", "Smoothie depth",
                       "Keep the smoothies' own depth for receivers in front of them: where one may be, always, "
                       "or never as in the published short form.",
                       kStore));
    settings.push_back(
        choice_setting("sides", "Sides",
                       "outer: as published, dark inside the hard edge; both: the inner half of the penumbra "
                       "too, with exact areas instead of the falloff (ours, not in the paper).",
                       {"outer", "both"}, {std::string{"outer"}, std::string{"both"}}));
    settings.push_back(choice_setting(
        "passes", "Passes", "Depth and alpha of the smoothies in one pass, or in two as published.", kPasses));
    settings.push_back(choice_setting("resize", "Remap at",
                                      "Every texel, or at the outer vertices alone: cheaper to shade, wrong where the "
                                      "receiver's depth jumps.",
                                      kResize));
    return settings;
}

template <class E>
E chosen(const Settings& settings, const char* id, const std::vector<std::string>& choices) {
    const auto found = std::ranges::find(choices, get_choice(settings, id));
    return static_cast<E>(found - choices.begin());
}

Falloff falloff_from(const Settings& settings) {
    const std::string& name = get_choice(settings, "falloff");
    return name == "linear"  ? Falloff::Linear
           : name == "cubic" ? Falloff::Cubic
           : name == "disc"  ? Falloff::Disc
                             : Falloff::Sinusoidal;
}

SmoothieOptions options_from(const Settings& settings) {
    return {.width = chosen<SmoothieOptions::Width>(settings, "width", kWidths),
            .t = get_double(settings, "t"),
            .remap = get_bool(settings, "remap"),
            .resize_per_vertex = get_choice(settings, "resize") == "vertex",
            .depth_from_casters = get_choice(settings, "depth_from") == "casters",
            .corners = chosen<SmoothieOptions::Corners>(settings, "corners", kCorners),
            .passes = chosen<SmoothieOptions::Passes>(settings, "passes", kPasses)};
}

}  // namespace

const TechniqueInfo& Smoothies::description() {
    static const TechniqueInfo info{
        .id = "smoothies",
        .title = "Smoothies",
        .paper = "Chan2004",
        .summary =
            "A depth map, and quads glued outside the silhouettes that carry the outer half of the penumbra: "
            "soft, fast and a look rather than a simulation.",
        .randomised = false,
        .on_cpu = false,
        .lights = all_light_kinds(),
        .settings = smoothie_settings(),
        .knob = "map_size",
    };
    return info;
}

Smoothies::Smoothies(const Settings& settings)
    : filter_{chosen<Filter>(settings, "filter", kFilters)},
      falloff_{falloff_from(settings)},
      store_{chosen<Store>(settings, "store_depth", kStore)},
      both_sides_{get_choice(settings, "sides") == "both"},
      options_{options_from(settings)},
      bias_{map_bias_from(settings)},
      map_{{.size_px = get_int(settings, "map_size"),
            .bias = bias_,
            .facing_test = get_bool(settings, "facing_test"),
            .with_receivers = true,
            .receivers_without_extent = options_.width == SmoothieOptions::Width::Fixed}},
      silhouettes_{{.source = silhouette_source(settings)}},
      buffer_{options_} {}

Verdict Smoothies::supports(const Light& /*light*/) const {
    return {};
}

bool Smoothies::has_width(const LightSummary& summary) const noexcept {
    return options_.width == SmoothieOptions::Width::Fixed ? options_.t > 0.0 : summary.has_extent;
}

bool Smoothies::reads_depth(const LightSummary& summary) const noexcept {
    if (store_ != Store::Auto) {
        return store_ == Store::On;
    }
    // Independent of what else is kept; culled casters leave no nearest surface.
    const auto casts = [&](std::uint32_t receiver) {
        const auto found = std::ranges::find(summary.casters, receiver);
        return found != summary.casters.end() &&
               summary.caster_needed[static_cast<std::size_t>(found - summary.casters.begin())] != 0;
    };
    return bias_.cull() != Cull::None || !std::ranges::all_of(summary.receivers, casts);
}

FieldOfUse Smoothies::field_of_use() const {
    return {.needs_small_light = !both_sides_,
            .needs_round_light = true,
            .needs_clear_light = true,
            .needs_light_above_horizon = map_.facing_test()};
}

Plan Smoothies::plan(const LightSummary& summary) const {
    Plan plan;
    if (!map_.plan(summary, kLookup, plan)) {
        return plan;
    }
    Plan own;
    const bool fixed = options_.width == SmoothieOptions::Width::Fixed;
    if (has_width(summary) || summary.keeps(fixed ? "smoothie-without-width" : "light-without-extent")) {
        own.run(kSilhouettes);
        own.run(kBuffer);
        if (both_sides_) {
            own.run(kInner);
        }
        if (!reads_depth(summary) && !summary.keeps("every-receiver-casts") && store_ == Store::Auto) {
            own.leave_out("smoothie depth", "every-receiver-casts",
                          "every visible receiver casts, so the depth map tells what lies in front of a smoothie");
        }
    } else if (fixed) {
        own.leave_out(kSilhouettes, "smoothie-without-width", "t is 0, so the smoothies cover nothing");
        own.leave_out(kBuffer, "smoothie-without-width", "t is 0, so the smoothies cover nothing");
    } else {
        own.leave_out(kSilhouettes, "light-without-extent", "the light has no extent: its hard shadow is the truth");
        own.leave_out(kBuffer, "light-without-extent", "the light has no extent: its hard shadow is the truth");
    }
    plan.steps.insert(plan.steps.end() - 1, own.steps.begin(), own.steps.end());
    return plan;
}

const Program& Smoothies::lookup(Frame& frame) {
    const LightSummary& summary = frame.summary();
    // Without extent the hard shadow is the truth, and nothing softens it.
    const bool point = options_.width != SmoothieOptions::Width::Fixed && !summary.has_extent;
    int stored = store_ == Store::Off ? 3 : 0;
    if (reads_depth(summary)) {
        stored = options_.passes == SmoothieOptions::Passes::Merged ? 1 : 2;
    }
    Defines defines = buffer_.ramp_defines(frame, map_);
    defines.insert(defines.end(), {{"FILTER", std::to_string(static_cast<int>(point ? Filter::Nearest : filter_))},
                                   {"FALLOFF", std::to_string(static_cast<int>(falloff_))},
                                   {"STORED", std::to_string(stored)},
                                   {"SMOOTHIES", frame.plan().runs(kBuffer) ? "1" : "0"},
                                   {"BOTH_SIDES", both_sides_ && has_width(summary) ? "1" : "0"},
                                   InnerEdges::define(kInnerUnit)});
    return map_.lookup(frame, "techniques/smoothies/smoothies.frag", defines);
}

void Smoothies::prepare(Frame& frame) {
    if (!frame.plan().runs(kLookup)) {
        return;
    }
    map_.allocate(frame);
    static_cast<void>(lookup(frame));
    if (frame.plan().runs(kBuffer)) {
        silhouettes_.prepare(frame, frame.gpu_scene(), frame.adjacency(), frame.summary().casters);
    }
}

void Smoothies::update(Frame& frame) {
    if (!frame.plan().runs(kLookup)) {
        return;
    }
    map_.update(frame);
    if (map_.frustum().faces.empty()) {
        return;
    }
    frame.step(kSilhouettes, [&] {
        const Light& light = frame.light();
        const glm::dvec4 light_ws = light.kind == LightKind::Sun ? glm::dvec4{-light.direction_ws, 0.0}
                                                                 : glm::dvec4{map_.frustum().origin_ws, 1.0};
        silhouettes_.extract(frame, light_ws, map_.frustum().origin_ws);
    });
    frame.step(kBuffer, [&] {
        const bool with_depth = reads_depth(frame.summary()) || frame.summary().keeps("every-receiver-casts");
        buffer_.allocate(map_.size_px(), static_cast<int>(map_.frustum().faces.size()), with_depth);
        buffer_.draw(frame, silhouettes_, map_);
    });
    frame.step(kInner, [&] { inner_.draw(frame, silhouettes_, map_, buffer_.inner_reach(frame, map_)); });
}

void Smoothies::resolve(Frame& frame) {
    frame.step(kLookup, [&] {
        const Program& program = lookup(frame);
        map_.bind(program);
        if (buffer_.alpha()) {
            buffer_.alpha().bind(3);
        }
        if (buffer_.depth()) {
            buffer_.depth().bind(4);
        }
        if (frame.plan().runs(kInner)) {
            inner_.bind(kInnerUnit);
            if (program.has("light_u_ws")) {
                inner_.set_uniforms(program);
                buffer_.set_light(program, frame, map_);
            }
        }
        frame.resolve_with(program);
    });
}

std::size_t Smoothies::memory_bytes() const noexcept {
    return map_.bytes() + silhouettes_.bytes() + buffer_.bytes() + inner_.bytes();
}

std::vector<DebugView> Smoothies::debug_views(const Plan& plan) const {
    std::vector<DebugView> views;
    if (plan.runs(kLookup)) {
        views.push_back(depth_map_view());
    }
    if (plan.runs(kBuffer)) {
        views.push_back({"silhouettes", "Silhouettes as the light finds them, in the camera's view"});
        views.push_back({"silhouettes_from_light", "Silhouettes in the depth map"});
        views.push_back({"smoothies", "Quads and wedges outside the silhouettes, in the depth map"});
        views.push_back({"smoothie_alpha", "Alpha of the smoothie buffer"});
    }
    return views;
}

DebugImage Smoothies::debug_image(Frame& frame, std::string_view id) {
    if (id == "silhouettes") {
        return view_picture(
            frame, "Orange: silhouettes of all casters as seen from the light's centre.", [&](RenderTarget& target) {
                draw_silhouettes_in_view(frame, target, silhouettes_, map_.frustum().origin_ws, kOrange);
            });
    }
    if (id == "silhouettes_from_light") {
        return map_picture(frame, map_, "Orange: silhouettes in the light's view.",
                           [&](int face, RenderTarget& target) {
                               draw_silhouettes_in_map(frame, target, silhouettes_, map_, face, kOrange);
                           });
    }
    if (id == "smoothies") {
        return map_picture(frame, map_, "Yellow: smoothies as drawn, as wide as a ramp can be; orange: silhouettes.",
                           [&](int face, RenderTarget& target) {
                               buffer_.draw_outlines(frame, target, silhouettes_, map_, face);
                               draw_silhouettes_in_map(frame, target, silhouettes_, map_, face, kOrange);
                           });
    }
    if (id == "smoothie_alpha") {
        return texture_picture(buffer_.alpha(), 0, 0.0F, 1.0F,
                               "Smallest alpha of all smoothies over each texel: dark at the silhouette, white at the "
                               "rim and where there is none.");
    }
    return depth_map_picture(frame, map_);
}

}  // namespace penumbra
