#include "techniques/light_samples/light_samples.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "passes/asked_pixels.h"
#include "passes/casters_beside.h"
#include "passes/frame.h"
#include "techniques/all_lights.h"

namespace penumbra {

namespace {

std::vector<SettingInfo> light_samples_settings() {
    std::vector<SettingInfo> settings = map_settings("slope", false);
    settings.push_back({.id = "samples",
                        .label = "Samples",
                        .unit = "maps",
                        .help = "Points on the light, each with a depth map of its own.",
                        .default_value = 16,
                        .minimum = 1,
                        .maximum = 4096,
                        .choices = {},
                        .sweep = {4, 16, 64, 256}});
    settings.push_back({.id = "pattern",
                        .label = "Pattern",
                        .unit = "",
                        .help = "Where the points lie: jittered in strata, centres of a grid, or the R2 sequence.",
                        .default_value = std::string{"jittered"},
                        .minimum = 0,
                        .maximum = 0,
                        .choices = {"jittered", "grid", "r2"},
                        .sweep = {}});
    settings.push_back({.id = "seed",
                        .label = "Seed",
                        .unit = "",
                        .help = "Of the jitter; the same for all pixels.",
                        .default_value = 1,
                        .minimum = 0,
                        .maximum = 2147483647,
                        .choices = {},
                        .sweep = {}});
    settings.push_back({.id = "memory_mib",
                        .label = "Map memory",
                        .unit = "MiB",
                        .help = "Maps are kept between frames if all of them fit into this; else redrawn every frame.",
                        .default_value = 512,
                        .minimum = 0,
                        .maximum = 65536,
                        .choices = {},
                        .sweep = {}});
    settings.push_back({.id = "mask",
                        .label = "Penumbra mask",
                        .unit = "",
                        .help = "Looks samples up only where a penumbra may be; elsewhere the light's centre decides.",
                        .default_value = false,
                        .minimum = 0,
                        .maximum = 0,
                        .choices = {},
                        .sweep = {}});
    for (SettingInfo& setting : PenumbraMask::settings()) {
        settings.push_back(std::move(setting));
    }
    return settings;
}

}  // namespace

const TechniqueInfo& LightSamples::description() {
    static const TechniqueInfo info{
        .id = "light_samples",
        .title = "Averaged shadow maps",
        .paper = "HeckbertHerf1997",
        .summary =
            "N hard shadow maps from points of the light, averaged: right for every scene as N grows, at N times the "
            "cost.",
        .randomised = true,
        .on_cpu = false,
        .lights = all_light_kinds(),
        .settings = light_samples_settings(),
        .knob = "samples",
    };
    return info;
}

LightSamples::LightSamples(const Settings& settings)
    : count_{get_int(settings, "samples")},
      size_px_{get_int(settings, "map_size")},
      pattern_{get_choice(settings, "pattern")},
      seed_{static_cast<std::uint32_t>(get_int(settings, "seed"))},
      memory_cap_bytes_{static_cast<std::size_t>(get_int(settings, "memory_mib")) << 20U},
      facing_test_{get_bool(settings, "facing_test")},
      masked_{get_bool(settings, "mask")},
      bias_{map_bias_from(settings)},
      mask_{PenumbraMask::options_from(settings)} {}

Verdict LightSamples::supports(const Light& /*light*/) const {
    return {};
}

namespace {

/// The cap of a sphere light outside of which no receiver sees anything: receivers within the angle b of the axis see
/// surface points up to b + acos(R / d) from it, d their distance.
SphereCap visible_cap(const LightSummary& summary) {
    const Light& light = *summary.light;
    const glm::dvec3 eye_from_light = summary.eye_ws - light.position_ws;
    SphereCap cap;
    glm::dvec3 mean{0.0};
    for (const ReceiverTile& tile : summary.tiles) {
        const glm::dvec3 p = 0.5 * (glm::dvec3{tile.low_cr} + glm::dvec3{tile.high_cr}) + eye_from_light;
        if (glm::length(p) > 0.0) {
            mean += glm::normalize(p) * static_cast<double>(tile.pixel_count);
        }
    }
    if (!(glm::length(mean) > 0.0)) {
        return cap;
    }
    cap.axis_ws = glm::normalize(mean);
    double widest = 0.0;
    for (const glm::vec3& p_cr : summary.receiver_points_cr) {
        const glm::dvec3 p = glm::dvec3{p_cr} + eye_from_light;
        const double distance = glm::length(p);
        if (distance <= light.radius_m) {
            return {cap.axis_ws, -1.0};
        }
        const double angle = std::acos(std::clamp(glm::dot(p, cap.axis_ws) / distance, -1.0, 1.0));
        widest = std::max(widest, angle + std::acos(light.radius_m / distance));
    }
    cap.least_cosine = std::cos(std::min(widest, std::numbers::pi));
    return cap;
}

}  // namespace

std::vector<LightSamples::Sample> LightSamples::fit_samples(const LightSummary& summary) const {
    std::vector<Sample> samples;
    int layer = 0;
    const LightKind kind = summary.light->kind;
    const bool sphere = (kind == LightKind::Point || kind == LightKind::Spot) && summary.has_extent;
    const SphereCap cap = sphere ? visible_cap(summary) : SphereCap{};
    std::vector<LightSamplePoint> points = sample_points(*summary.light, count_, pattern_, seed_, cap);
    if (!summary.has_extent && summary.keeps("light-without-extent")) {
        points.resize(static_cast<std::size_t>(count_), points.front());
    }
    for (const LightSamplePoint& point : points) {
        Sample sample;
        sample.point = point;
        sample.frustum = fit_map_frustum(summary, point.position_ws, point.direction_ws, {.size_px = size_px_});
        sample.block = make_map_block(sample.frustum, *summary.light, point.direction_ws, summary.eye_ws, size_px_);
        sample.first_layer = layer;
        layer += static_cast<int>(sample.frustum.faces.size());
        samples.push_back(std::move(sample));
    }
    return samples;
}

namespace {

bool mask_runs(const Frame& frame) {
    return frame.plan().runs("penumbra mask");
}
Define mask_define(const Frame& frame) {
    return {"MASK", mask_runs(frame) ? "1" : "0"};
}

}  // namespace

FieldOfUse LightSamples::field_of_use() const {
    return {.needs_clear_light = true, .needs_light_above_horizon = facing_test_};
}

Plan LightSamples::plan(const LightSummary& summary) const {
    Plan plan;
    const LightSummary::Trivial trivial = summary.trivial();
    if (!trivial.reason.empty()) {
        plan.leave_out("depth maps", trivial.rule, trivial.reason);
        plan.leave_out("lookups", trivial.rule, trivial.reason);
        plan.leave_out("mean", trivial.rule, trivial.reason);
        return plan;
    }
    if (masked_ && !summary.keep.everything && count_ > 1) {
        PenumbraMask::plan(summary, plan);
    }
    plan.run("depth maps");
    if (!summary.has_extent && count_ > 1 && !summary.keeps("light-without-extent")) {
        plan.leave_out("further depth maps", "light-without-extent",
                       "the light has no extent: all " + std::to_string(count_) + " samples are the same point");
    }
    CastersBeside beside;
    for (const Sample& sample : fit_samples(summary)) {
        for (const MapFace& face : sample.frustum.faces) {
            beside.add(summary, face);
        }
    }
    beside.tell_of_hull(summary, plan);
    beside.tell(plan);
    plan.run("lookups");
    plan.run("mean");
    return plan;
}

void LightSamples::prepare(Frame& frame) {
    if (!frame.plan().runs("lookups")) {
        return;
    }
    mask_.prepare(frame);
    const LightKind kind = frame.light().kind;
    samples_ = fit_samples(frame.summary());
    sphere_ =
        (kind == LightKind::Point || kind == LightKind::Spot) && frame.summary().has_extent && samples_.size() > 1;
    std::size_t layers = 0;
    std::size_t most = 0;
    for (const Sample& sample : samples_) {
        layers += sample.frustum.faces.size();
        most = std::max(most, sample.frustum.faces.size());
    }
    const std::size_t layer_bytes =
        sizeof(float) * static_cast<std::size_t>(size_px_) * static_cast<std::size_t>(size_px_);
    keep_maps_ = layers * layer_bytes <= memory_cap_bytes_ &&
                 layers <= static_cast<std::size_t>(frame.device().context.limits().max_array_layers);
    maps_.allocate(size_px_, static_cast<int>(std::max<std::size_t>(1, keep_maps_ ? layers : most)),
                   "light sample maps");
    sums_ = TextureImage::make_2d(GL_RG32F, frame.view().width, frame.view().height, "light sample sums");
    sums_target_ = RenderTarget{"light sample sums"};
    sums_target_.attach_colour(0, sums_);
    if (mask_runs(frame)) {
        stencil_ = TextureImage::make_2d(GL_DEPTH24_STENCIL8, frame.view().width, frame.view().height,
                                         "light samples' penumbra mask");
        sums_target_.attach_depth(stencil_);
    }
}

void LightSamples::render_maps(Frame& frame, std::size_t index, int first_layer) {
    const Sample& sample = samples_[index];
    setup_.bind_for_depth(frame.gpu_scene(), sample.frustum, sample.block);
    for (std::size_t face = 0; face < sample.frustum.faces.size(); ++face) {
        maps_.render(frame, frame.gpu_scene(), casters_in(frame.summary(), sample.frustum.faces[face]), face,
                     first_layer + static_cast<int>(face), bias_.cull());
    }
}

void LightSamples::update(Frame& frame) {
    mask_.update(frame);
    frame.step("depth maps", [&] {
        samples_ = fit_samples(frame.summary());
        if (keep_maps_) {
            for (std::size_t i = 0; i < samples_.size(); ++i) {
                frame.control().check();
                render_maps(frame, i, samples_[i].first_layer);
            }
        }
    });
}

const Program& LightSamples::accumulation(Frame& frame, const Sample& sample) const {
    Defines defines = bias_.defines(sample.frustum, facing_test_);
    defines.push_back({"SPHERE", sphere_ ? "1" : "0"});
    return frame.device().programs.get({"lib/fullscreen.vert", "techniques/light_samples/accumulate.frag"}, defines);
}

void LightSamples::accumulate(Frame& frame, const Sample& sample, int first_layer, const AskedPixels& asked) {
    setup_.bind_for_lookup(sample.block);
    const Program& program = accumulation(frame, sample);
    bias_.set_uniforms(program);
    program.set("first_layer", first_layer);
    if (sphere_) {
        program.set("sphere_normal_ws", glm::vec3{sample.point.normal_ws});
        program.set("sphere_radius_m", static_cast<float>(frame.light().radius_m));
    }
    glEnable(GL_BLEND);
    glBlendEquation(GL_FUNC_ADD);
    glBlendFunc(GL_ONE, GL_ONE);
    if (mask_runs(frame)) {
        glEnable(GL_STENCIL_TEST);
        glStencilFunc(GL_EQUAL, 1, 0xFFU);
    }
    asked.draw(frame, sums_target_, program);
    glDisable(GL_STENCIL_TEST);
    glDisable(GL_BLEND);
}

void LightSamples::resolve(Frame& frame) {
    mask_.classify(frame);
    frame.step("lookups", [&] {
        sums_target_.bind();
        sums_target_.clear_colour(0, glm::vec4{0.0F});
        if (mask_runs(frame)) {
            mask_.write_stencil(frame, sums_target_);
        }
        frame.bind_view();
        const AskedPixels asked{frame.summary()};
        for (std::size_t i = 0; i < samples_.size(); ++i) {
            frame.control().check();
            int first_layer = samples_[i].first_layer;
            if (!keep_maps_) {  // too much memory for all maps: each is drawn just before it is looked up
                first_layer = 0;
                render_maps(frame, i, first_layer);
                frame.bind_view();
            }
            maps_.texture().bind(2);
            accumulate(frame, samples_[i], first_layer, asked);
        }
    });
    frame.step("mean", [&] {
        sums_.bind(0);
        glDisable(GL_BLEND);
        if (mask_runs(frame)) {
            mask_.classes().bind(4);
        }
        frame.write_visibility_with(frame.device().programs.get(
            {"lib/fullscreen.vert", "techniques/light_samples/divide.frag"}, {mask_define(frame)}));
    });
}

std::size_t LightSamples::memory_bytes() const noexcept {
    return maps_.bytes() + (sums_ ? sums_.bytes() : 0) + (stencil_ ? stencil_.bytes() : 0) + mask_.bytes();
}

std::vector<Statistic> LightSamples::statistics(Frame& frame) {
    if (!mask_runs(frame)) {
        return {};
    }
    std::vector<std::uint8_t> classes(frame.view().size());
    mask_.read_classes(classes);
    return PenumbraMask::statistics(frame.summary(), classes);
}

std::vector<DebugView> LightSamples::debug_views(const Plan& plan) const {
    return plan.runs("penumbra mask") ? PenumbraMask::debug_views() : std::vector<DebugView>{};
}

DebugImage LightSamples::debug_image(Frame& frame, std::string_view id) {
    return mask_.debug_image(frame, id);
}

}  // namespace penumbra
