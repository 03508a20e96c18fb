#include "techniques/linear_light_maps/linear_light_maps.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>

#include "passes/casters_beside.h"
#include "passes/frame.h"
#include "scene/setting_forms.h"
#include "techniques/all_lights.h"

namespace penumbra {

namespace {

constexpr const char* kDepths = "depth maps";
constexpr const char* kSurfaces = "receiver depth maps";
constexpr const char* kSkins = "skins";
constexpr const char* kLookups = "lookups";
constexpr const char* kPlacement = "sample placement";
constexpr const char* kRest = "maps beyond the windows";
constexpr const char* kReadBack = "read back";
constexpr int kMostSamples = 17;

std::vector<SettingInfo> linear_settings() {
    std::vector<SettingInfo> settings = map_settings("slope", false);
    for (SettingInfo& setting : settings) {
        if (setting.id == "bias") {  // the lit faces' own edges are what skins hang on
            std::erase(setting.choices, "second_depth");
        }
    }
    settings.push_back(number_setting("samples", "Samples", "maps",
                                      "Places on each line, both ends among them; 2 as published, 3 where penumbrae "
                                      "overlap.",
                                      2, 2, kMostSamples, {2, 3, 4, 5, 9}));
    settings.push_back(number_setting("lines", "Lines", "lines",
                                      "Lines that stand for a light with an area; 0: one for round lights, 1 to 4 for "
                                      "others by their proportions.",
                                      0, 0, 64, {1, 2, 4, 8}));
    settings.push_back(choice_setting("layout", "Layout of lines",
                                      "strips along the light's longest axis, or its sides (published for triangles); "
                                      "auto: sides for triangles.",
                                      {"auto", "strips", "sides"}));
    settings.push_back(
        choice_setting("edge_filter", "Edge filter", "Laplacian of Gaussian on the depth maps.", {"log3", "log5"}));
    settings.push_back(number_setting("edge_threshold", "Edge threshold", "",
                                      "Of the filter's answer to a jump that makes the shortest skin.", 0.5, 0.3, 0.7));
    settings.push_back(number_setting("dead_zone", "Dead zone", "",
                                      "Least size of the smaller of the filter's two answers at an edge, of the "
                                      "threshold; log5 takes a fifth of it.",
                                      0.25, 0.05, 0.3));
    settings.push_back(number_setting("least_skin", "Least skin", "texel",
                                      "Shorter skins are no penumbra; a huge value leaves plain hard shadows.", 1.0,
                                      0.5, 1e9));
    settings.push_back(choice_setting("transition", "Transition",
                                      "linear along a skin (published), or exact for receivers of any shape.",
                                      {"linear", "exact"}));
    settings.push_back(choice_setting("conflict", "Overlapping skins",
                                      "nearest to the sample (published), or the darkest.", {"nearest", "darkest"}));
    settings.push_back(toggle_setting("clamp", "Clamp", "A segment counts 1 at most; off as published.", true));
    settings.push_back(toggle_setting(
        "rim_rule", "Rims and walls",
        "Keeps a caster's own rims and grazed walls lit: entries and skins that belong to another surface than the "
        "point's do not darken it. Off as published.",
        true));
    settings.push_back(toggle_setting("adaptive", "Adaptive samples",
                                      "Halves segments that two samples cannot serve, from maps read back.", false));
    settings.push_back(number_setting("max_samples", "Most samples", "maps", "On each line, with adaptive samples.", 9,
                                      2, kMostSamples));
    settings.push_back(choice_setting("weights", "Weights",
                                      "visibility: the share of the light that is seen; irradiance: the share of it "
                                      "that arrives, by each sample's local illumination.",
                                      {"visibility", "irradiance"}));
    settings.push_back(choice_setting("engine", "Engine",
                                      "gl; software: depth maps read back, all else in float64 on the processor.",
                                      {"gl", "software"}));
    return settings;
}

SkinRules rules_from(const Settings& settings) {
    SkinRules rules;
    rules.kernel = get_choice(settings, "edge_filter") == "log5" ? LogKernel::Five : LogKernel::Three;
    rules.log_share = get_double(settings, "edge_threshold");
    rules.dead_zone = get_double(settings, "dead_zone") * (rules.kernel == LogKernel::Five ? 0.2 : 1.0);
    rules.least_skin_px = get_double(settings, "least_skin");
    rules.wall_rule = get_bool(settings, "rim_rule");
    rules.exact = get_choice(settings, "transition") == "exact";
    rules.darkest = get_choice(settings, "conflict") == "darkest";
    return rules;
}

RodLayout layout_from(const Settings& settings) {
    const std::string& layout = get_choice(settings, "layout");
    return layout == "sides" ? RodLayout::Sides : layout == "strips" ? RodLayout::Strips : RodLayout::Auto;
}

std::string number_in_words(double value) {
    std::array<char, 32> text{};
    std::snprintf(text.data(), text.size(), "%.2g", value);
    return text.data();
}

/// Middle of the visible receivers, relative to the eye.
glm::dvec3 middle_of_receivers(const LightSummary& summary) {
    glm::dvec3 sum{0.0};
    for (const glm::vec3& p_cr : summary.receiver_points_cr) {
        sum += glm::dvec3{p_cr};
    }
    return sum / std::max<double>(1.0, static_cast<double>(summary.receiver_points_cr.size()));
}

/// Direction in which the visible receivers extend least: a floor's normal.
glm::dvec3 upright_of(const LightSummary& summary, const glm::dvec3& middle_cr) {
    glm::dmat3 spread{0.0};
    for (const glm::vec3& p_cr : summary.receiver_points_cr) {
        const glm::dvec3 p = glm::dvec3{p_cr} - middle_cr;
        spread += glm::outerProduct(p, p);
    }
    // The least eigenvector is the largest one of trace - spread.
    const double trace = spread[0][0] + spread[1][1] + spread[2][2];
    if (!(trace > 0.0)) {
        return glm::dvec3{0.0};
    }
    glm::dmat3 power = glm::dmat3{1.0} - spread / trace;
    for (int i = 0; i < 12; ++i) {  // the power 4096
        power = power * power;
        power /= std::abs(power[0][0]) + std::abs(power[1][1]) + std::abs(power[2][2]);
    }
    const glm::dvec3* longest = &power[0];
    for (const glm::dvec3* column : {&power[1], &power[2]}) {
        longest = glm::length(*column) > glm::length(*longest) ? column : longest;
    }
    return glm::normalize(*longest);
}

/// What is done in place of the light, in words: "sphere as 1 line, 0.52 m along (1, 0, 0)".
std::string stand_in(const Light& light, std::size_t lines, const glm::dvec3& half_ws) {
    const double length = 2.0 * glm::length(half_ws);
    const glm::dvec3 along = length > 0.0 ? 2.0 * half_ws / length : glm::dvec3{0.0};
    const bool sphere = light.kind == LightKind::Point || light.kind == LightKind::Spot;
    std::string words = sphere ? "sphere" : std::string{to_string(light.kind)};
    words += lines == 1 ? " as 1 line, " : " as " + std::to_string(lines) + " lines, the first ";
    words += number_in_words(length) + (light.kind == LightKind::Sun ? " (slope)" : " m") + " along (";
    for (int i = 0; i < 3; ++i) {
        words += (i > 0 ? ", " : "") + number_in_words(std::abs(along[i]) < 0.005 ? 0.0 : along[i]);
    }
    return words + ")";
}

bool round_without_axes(LightKind kind) {
    return kind == LightKind::Point || kind == LightKind::Spot || kind == LightKind::Sun;
}

/// Receivers that are no casters, or the other way round: skins then need maps of their own.
bool needs_surface_map(const LightSummary& summary) noexcept {
    return summary.has_extent && (summary.receivers_not_casting > 0 || summary.keeps("every-receiver-casts"));
}

}  // namespace

const TechniqueInfo& LinearLightMaps::description() {
    static const TechniqueInfo info{
        .id = "linear_light_maps",
        .title = "Linear light maps",
        .paper = "Heidrich2000",
        .summary =
            "Two or a few samples on a line light, each with a depth map and a visibility channel from its neighbour's "
            "depth discontinuities.",
        .randomised = false,
        .on_cpu = false,
        .lights = all_light_kinds(),
        .settings = linear_settings(),
        .knob = "samples",
    };
    return info;
}

LinearLightMaps::LinearLightMaps(const Settings& settings)
    : samples_{get_int(settings, "samples")},
      most_samples_{get_bool(settings, "adaptive") ? get_int(settings, "max_samples") : 0},
      strips_{get_int(settings, "lines")},
      layout_{layout_from(settings)},
      size_px_{get_int(settings, "map_size")},
      bias_{map_bias_from(settings)},
      facing_test_{get_bool(settings, "facing_test")},
      clamp_{get_bool(settings, "clamp")},
      rim_rule_{get_bool(settings, "rim_rule")},
      local_{get_choice(settings, "weights") == "irradiance"},
      software_{get_choice(settings, "engine") == "software"},
      rules_{rules_from(settings)},
      skins_{rules_} {}

Verdict LinearLightMaps::supports(const Light& /*light*/) const {
    return {};
}

std::vector<LinearRod> LinearLightMaps::segments_of(const LightSummary& summary, const glm::dvec3& middle_cr) const {
    const Light& light = *summary.light;
    RodSurroundings surroundings;
    if (!summary.receiver_points_cr.empty() && round_without_axes(light.kind)) {
        surroundings.towards_ws = (summary.eye_ws - light.position_ws) + middle_cr;
        surroundings.upright_ws = upright_of(summary, middle_cr);
    }
    return linear_rods(light, layout_, strips_, surroundings);
}

std::vector<LinearLightMaps::Rod> LinearLightMaps::fit_rods(const LightSummary& summary,
                                                            const std::vector<std::vector<double>>& places) const {
    const glm::dvec3 middle_cr = middle_of_receivers(summary);
    std::vector<Rod> rods;
    int layer = 0;
    for (const LinearRod& segment : segments_of(summary, middle_cr)) {
        Rod rod;
        rod.segment = segment;
        rod.views = fit_linear_views(
            summary, segment,
            places.empty() ? even_places(summary.has_extent || summary.keeps("light-without-extent") ? samples_ : 1)
                           : places[rods.size()],
            summary.eye_ws + middle_cr, size_px_);
        rod.first_layer = layer;
        layer += rod.layers();
        rods.push_back(std::move(rod));
    }
    return rods;
}

std::string LinearLightMaps::no_skins(const LightSummary& summary, const std::vector<Rod>& rods) const {
    if (summary.keeps("skin-under-threshold")) {
        return {};
    }
    double longest = 0.0;
    for (const Rod& rod : rods) {
        for (std::size_t i = 0; i < rod.views.windows.size(); ++i) {
            longest = std::max(longest, SkinPass::longest_skin_px(rod.views, i));
        }
    }
    return longest < 0.99 * rules_.least_skin_px
               ? "no skin can be longer than " + number_in_words(longest) + " texels, of " +
                     number_in_words(rules_.least_skin_px) + " that the shortest needs"
               : std::string{};
}

FieldOfUse LinearLightMaps::field_of_use() const {
    return {.needs_line_light = strips_ == 0, .needs_clear_light = true, .needs_light_above_horizon = facing_test_};
}

Plan LinearLightMaps::plan(const LightSummary& summary) const {
    Plan plan;
    const LightSummary::Trivial trivial = summary.trivial();
    if (!trivial.reason.empty()) {
        for (const char* step : {kDepths, kSkins, kLookups}) {
            plan.leave_out(step, trivial.rule, trivial.reason);
        }
        return plan;
    }
    const std::vector<Rod> rods = fit_rods(summary);
    if (summary.has_extent && summary.light->kind != LightKind::Line) {
        plan.run(stand_in(*summary.light, rods.size(), rods.front().segment.half_ws));
    }
    if (most_samples_ > 0 && summary.has_extent) {
        plan.run(kPlacement);
    }
    plan.run(kDepths);
    std::size_t windows_without_receivers = 0;
    for (const Rod& rod : rods) {
        windows_without_receivers += rod.views.windows_without_receivers.size();
    }
    const bool rest = std::ranges::any_of(rods, [](const Rod& rod) { return !rod.views.outside_cr.empty(); });
    if (rest) {
        plan.run(kRest);
    } else if (!summary.keeps("cube-face-without-receivers")) {
        plan.leave_out(kRest, "cube-face-without-receivers",
                       "no visible receiver lies close to the line through one of the light's lines");
    }
    if (windows_without_receivers > 0) {
        plan.leave_out("windows without receivers", "cube-face-without-receivers",
                       std::to_string(windows_without_receivers) +
                           " of the windows around the light's lines hold no visible receiver");
    }
    CastersBeside beside;
    for (const Rod& rod : rods) {
        for (const LinearWindow& window : rod.views.windows) {
            for (const MapFace& face : window.faces) {
                beside.add(summary, face);
            }
        }
    }
    beside.tell(plan);
    if (summary.casters_outside > 0) {
        plan.leave_out("casters out of reach", "caster-outside-hull",
                       std::to_string(summary.casters_outside) +
                           " casters lie outside the space between the light and the visible receivers");
    }
    if (!summary.has_extent && !summary.keeps("light-without-extent")) {
        plan.leave_out("further depth maps", "light-without-extent",
                       "the light has no extent: all " + std::to_string(samples_) + " samples are the same point");
        plan.leave_out(kSkins, "light-without-extent", "the light has no extent, so its shadows are hard");
    } else if (const std::string reason = no_skins(summary, rods); !reason.empty()) {
        plan.leave_out(kSkins, "skin-under-threshold", reason);
    } else {
        if (needs_surface_map(summary)) {
            plan.run(kSurfaces);
        } else {
            plan.leave_out(kSurfaces, "every-receiver-casts",
                           "every visible receiver is among the casters, so their maps hold it");
        }
        plan.run(software_ ? kReadBack : kSkins);
    }
    if (software_ && !plan.runs(kReadBack)) {
        plan.run(kReadBack);
    }
    plan.run(kLookups);
    return plan;
}

void LinearLightMaps::allocate(Frame& frame) {
    int layers = 0;
    for (const Rod& rod : rods_) {
        layers += rod.layers();
    }
    rest_.clear();
    for (const Rod& rod : rods_) {
        rest_.add(frame.summary(), rod.views, rod.segment.weight, frame.light().direction_ws, size_px_);
    }
    if (sums_needed() && (!sums_ || sums_.width() != frame.view().width || sums_.height() != frame.view().height)) {
        sums_ = TextureImage::make_2d(GL_RG32F, frame.view().width, frame.view().height, "linear light sums");
        sums_target_ = RenderTarget{"linear light sums"};
        sums_target_.attach_colour(0, sums_);
    }
    if (layers == 0) {
        return;
    }
    maps_.allocate(size_px_, layers, "linear light maps");
    if (frame.plan().runs(kSurfaces)) {
        surface_maps_.allocate(size_px_, layers, "receiver maps of linear lights");
    }
    if (!software_) {
        skins_.allocate(size_px_, layers);
    }
}

void LinearLightMaps::prepare(Frame& frame) {
    if (frame.plan().runs(kLookups)) {
        rods_ = fit_rods(frame.summary());
        allocate(frame);
    }
}

const DepthMap& LinearLightMaps::surfaces(const Frame& frame) const {
    return frame.plan().runs(kSurfaces) ? surface_maps_ : maps_;
}

void LinearLightMaps::draw_skins(Frame& frame) {
    for (const Rod& rod : rods_) {
        skins_.draw(frame, rod.views, surfaces(frame).texture(), rod.first_layer);
    }
}

void LinearLightMaps::place_samples(Frame& frame) {
    const LightSummary& summary = frame.summary();
    const glm::dvec3 middle_cr = middle_of_receivers(summary);
    std::vector<std::vector<double>> places;
    undersampled_ = 0.0;
    for (const LinearRod& segment : segments_of(summary, middle_cr)) {
        const SamplePlacement::Result found =
            placement_.find(frame, segment, summary.eye_ws + middle_cr, even_places(samples_),
                            std::max(samples_, most_samples_), size_px_, rules_);
        undersampled_ += segment.weight * found.undersampled;
        places.push_back(found.places);
    }
    rods_ = fit_rods(summary, places);
}

void LinearLightMaps::update(Frame& frame) {
    if (!frame.plan().runs(kLookups)) {
        return;
    }
    frame.step(kPlacement, [&] { place_samples(frame); });
    frame.step(kDepths, [&] {
        if (!frame.plan().runs(kPlacement)) {
            rods_ = fit_rods(frame.summary());
        }
        allocate(frame);
        for (const Rod& rod : rods_) {
            render_linear_depths(frame, maps_, setup_, rod.views, rod.segment.centre_ws, rod.first_layer, size_px_,
                                 false);
        }
    });
    frame.step(kSurfaces, [&] {
        for (const Rod& rod : rods_) {
            render_linear_depths(frame, surface_maps_, setup_, rod.views, rod.segment.centre_ws, rod.first_layer,
                                 size_px_, true);
        }
    });
    frame.step(kRest, [&] { rest_.render(frame, size_px_); });
    frame.step(kSkins, [&] { draw_skins(frame); });
    if (!software_ && !frame.plan().runs(kSkins)) {
        for (const Rod& rod : rods_) {
            skins_.clear(rod.first_layer, rod.layers());
        }
    }
    frame.step(kReadBack, [&] {
        engine_.clear();
        if (maps_.texture()) {
            const std::vector<float> stored = maps_.texture().read<float>();
            for (const Rod& rod : rods_) {
                engine_.add(rod.views, rod.segment.weight, rules_, stored, rod.first_layer, size_px_);
            }
        }
    });
}

const Program& LinearLightMaps::combination(Frame& frame, const Rod& rod, const LinearViews::Group& group) const {
    Defines defines = bias_.defines(rod.views.central(group), facing_test_);
    defines.push_back({"SAMPLES", std::to_string(rod.views.samples())});
    defines.push_back({"ONE_WINDOW", rod.views.in_one_window ? "1" : "0"});
    defines.push_back({"SURFACE_MAP", frame.plan().runs(kSurfaces) ? "1" : "0"});
    defines.push_back({"CONFLICT_MIN", rules_.darkest ? "1" : "0"});
    defines.push_back({"RIM", rim_rule_ ? "1" : "0"});
    defines.push_back({"CLAMP", clamp_ ? "1" : "0"});
    defines.push_back({"SUM", sums_needed() ? "1" : "0"});
    if (local_) {
        const LightKind kind = frame.light().kind;
        defines.push_back({"LOCAL", kind == LightKind::Line                               ? "1"
                                    : kind == LightKind::Sun                              ? "4"
                                    : kind == LightKind::Point || kind == LightKind::Spot ? "3"
                                                                                          : "2"});
    } else {
        defines.push_back({"LOCAL", "0"});
    }
    return frame.device().programs.get({"lib/fullscreen.vert", "techniques/linear_light_maps/combine.frag"}, defines);
}

void LinearLightMaps::combine(Frame& frame, const Rod& rod, const LinearViews::Group& group) {
    const LinearViews& views = rod.views;
    setup_.bind_for_lookup(
        make_map_block(views.central(group), frame.light(), rod.segment.centre_ws, frame.summary().eye_ws, size_px_));
    const Program& program = combination(frame, rod, group);
    bias_.set_uniforms(program);
    const auto samples = static_cast<std::size_t>(views.samples());
    std::vector<glm::vec4> shifts;
    double widest_texel = 0.0;
    for (std::size_t window = group.first; window < group.first + group.count; ++window) {
        for (int sample = 0; sample < views.samples(); ++sample) {
            shifts.emplace_back(glm::vec2{views.shift_from_central(window, sample)}, 0.0F, 0.0F);
        }
        const glm::dvec2 step = views.windows[window].step;
        widest_texel = std::max({widest_texel, step.x, step.y});
    }
    std::vector<glm::vec4> places;
    const double length = views.along.back() - views.along.front();
    for (std::size_t i = 0; i < samples; ++i) {
        // Samples that all coincide share the light evenly.
        const double share = i + 1 == samples ? 0.0
                             : length > 0.0   ? (views.along[i + 1] - views.along[i]) / length
                                              : 1.0 / static_cast<double>(samples - 1);
        places.emplace_back(views.along[i], share, 0.0, 0.0);
    }
    program.set("first_layer", rod.first_layer + static_cast<int>(group.first) * views.samples());
    program.set("views", std::span<const glm::vec4>{shifts});
    program.set("places", std::span<const glm::vec4>{places});
    // Beyond the depth that a tilted receiver spans in a texel: some 16 texels' width.
    program.set("rim", static_cast<float>(views.orthographic ? 16.0 * widest_texel : 3e-2));
    if (sums_needed()) {
        program.set("weight", static_cast<float>(rod.segment.weight));
    }
    if (!views.in_one_window) {
        set_windows(program, views);
        program.set("first_window", static_cast<int>(group.first));
    }
    if (local_ && !views.orthographic) {
        program.set("shine_ws",
                    glm::vec3{frame.light().kind == LightKind::Line ? views.u_ws : frame.light().direction_ws});
    }
    maps_.texture().bind(2);
    skins_.channels().bind(3);
    if (frame.plan().runs(kSurfaces)) {
        surface_maps_.texture().bind(4);
    }
    frame.bind_view();
    if (!sums_needed()) {
        frame.write_visibility_with(program);
    } else {
        frame.fullscreen().draw(sums_target_, program);
    }
}

void LinearLightMaps::accumulate(Frame& frame) {
    sums_target_.bind();
    sums_target_.clear_colour(0, glm::vec4{0.0F});
    glEnable(GL_BLEND);
    glBlendEquation(GL_FUNC_ADD);
    glBlendFunc(GL_ONE, GL_ONE);
    if (!software_) {
        for (const Rod& rod : rods_) {
            for (const LinearViews::Group& group : rod.views.groups()) {
                combine(frame, rod, group);
            }
        }
    }
    rest_.accumulate(frame, sums_target_, bias_, facing_test_);
    glDisable(GL_BLEND);
}

LinearLookup LinearLightMaps::software_lookup() const {
    LinearLookup lookup;
    lookup.bias_px = bias_.mode == MapBias::Mode::None ? 0.0 : static_cast<double>(bias_.constant);
    lookup.slope_cap_px = bias_.mode == MapBias::Mode::None || bias_.mode == MapBias::Mode::Constant
                              ? 0.0
                              : static_cast<double>(bias_.slope_cap);
    lookup.rim_rule = rim_rule_;
    lookup.clamp = clamp_;
    lookup.facing_test = facing_test_;
    return lookup;
}

void LinearLightMaps::resolve_in_software(Frame& frame) {
    std::vector<glm::vec2> rest;
    if (!rest_.empty()) {
        accumulate(frame);
        rest = sums_.read<glm::vec2>();
    }
    LinearLookup lookup = software_lookup();
    const Light& light = frame.light();
    if (light.kind == LightKind::Sun) {
        lookup.parallel = true;
        double widest = 0.0;
        for (const Rod& rod : rods_) {
            const glm::dvec2 step = rod.views.windows.front().step;
            widest = std::max({widest, step.x, step.y});
        }
        lookup.rim = 16.0 * widest;
    }
    SoftwareEngine::Local local;
    if (local_) {
        local = [&light](const glm::dvec3& sample_ws, const glm::dvec3& along_ws, const glm::dvec3& p_ws,
                         const glm::dvec3& n_ws) {
            if (light.kind == LightKind::Sun) {
                return std::max(0.0, -glm::dot(n_ws, light.direction_ws));
            }
            const glm::dvec3 to = sample_ws - p_ws;
            const double distance = glm::length(to);
            const double cosine = std::max(0.0, glm::dot(n_ws, to)) / distance;
            const double shine = light.kind == LightKind::Line    ? glm::length(glm::cross(to, along_ws))
                                 : round_without_axes(light.kind) ? distance
                                                                  : std::max(0.0, -glm::dot(light.direction_ws, to));
            return cosine * shine / (distance * distance * distance);
        };
    }
    engine_.resolve(frame, lookup, local, rest, frame.visibility_on_cpu());
}

void LinearLightMaps::resolve(Frame& frame) {
    frame.step(kLookups, [&] {
        if (std::ranges::all_of(rods_, [](const Rod& rod) { return rod.views.windows.empty(); }) && rest_.empty()) {
            std::ranges::fill(frame.visibility_on_cpu(), 1.0F);  // nothing is seen
        } else if (software_) {
            resolve_in_software(frame);
        } else if (!sums_needed()) {
            combine(frame, rods_.front(), rods_.front().views.groups().front());
        } else {
            accumulate(frame);
            sums_.bind(0);
            frame.write_visibility_with(
                frame.device().programs.get({"lib/fullscreen.vert", "techniques/linear_light_maps/divide.frag"}));
        }
    });
}

std::size_t LinearLightMaps::memory_bytes() const noexcept {
    return maps_.bytes() + surface_maps_.bytes() + skins_.bytes() + rest_.bytes() + placement_.bytes() +
           (sums_ ? sums_.bytes() : 0);
}

}  // namespace penumbra
