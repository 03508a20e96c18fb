#include "techniques/penumbra_maps/penumbra_maps.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <map>

#include "geometry/simplify.h"
#include "passes/debug_picture.h"
#include "passes/edge_space.h"
#include "passes/frame.h"
#include "scene/setting_forms.h"
#include "techniques/all_lights.h"

namespace penumbra {

namespace {

constexpr const char* kLookup = "lookup";
constexpr const char* kSilhouettes = "silhouettes";
constexpr const char* kPenumbra = "penumbra map";
constexpr const char* kInner = "inner edges";
constexpr const char* kPack = "pack";

std::vector<SettingInfo> penumbra_settings() {
    std::vector<SettingInfo> settings = map_settings("slope", true);
    settings.push_back(silhouette_setting());
    settings.push_back(choice_setting("sides", "Sides",
                                      "outer: as published, V = 0 at the hard edge; both: ours, V = 1/2 there.",
                                      {"outer", "both"}, {std::string{"outer"}, std::string{"both"}}));
    settings.push_back(choice_setting(
        "mode", "Construction", "exact: analytic cones, affine inverse depths; literal: facets and subdivided sheets.",
        {"exact", "literal"}));
    settings.push_back(
        choice_setting("ramp", "Ramp",
                       "What is linear: depth along the light ray (published), the image plane, or exact on "
                       "tilted edges too; auto: depth, with both sides exact.",
                       {"auto", "depth", "image", "exact"}));
    settings.push_back(
        choice_setting("falloff", "Falloff",
                       "auto: smoothstep (published) for round lights, linear for others, with both sides the "
                       "area of the light's shape.",
                       {"auto", "smoothstep", "linear", "area"}));
    settings.push_back(choice_setting(
        "shape", "Light shape", "disc of equal area (published), sphere for point and spot lights, or the light's own.",
        {"disc", "sphere", "light"}));
    settings.push_back(choice_setting("filter", "Filter", "Texels of a lookup: one, or four with a comparison each.",
                                      {"nearest", "gathered"}));
    settings.push_back(toggle_setting("trim_cones", "Trim cones",
                                      "Draws of each cone only the wedge between its sheets; exact mode only.", true));
    settings.push_back(swept_when(
        number_setting("facets", "Facets", "", "Triangles of a cone; literal mode only.", 24, 3, 64, {6, 12, 24, 48}),
        "mode", "literal"));
    settings.push_back(swept_when(
        number_setting("sheet_parts", "Sheet parts", "",
                       "Most parts of a sheet whose ends differ in depth; literal mode only.", 8, 1, 32, {1, 2, 8, 32}),
        "mode", "literal"));
    settings.push_back(
        number_setting("caster_triangles", "Caster triangles", "",
                       "Simplifies all casters together to about this many triangles, and raises the bias by how "
                       "far they may stand off; 0: in full.",
                       0, 0, 1 << 30));
    settings.push_back(
        choice_setting("combine", "Keep the darkest by",
                       "Minimum blending, or depth written and tested (published); auto: the mode's own.",
                       {"auto", "minimum", "depth_test"}));
    settings.push_back(
        choice_setting("precision", "Precision", "Of the penumbra map.", {"float32", "float16", "byte"}));
    settings.push_back(toggle_setting(
        "packed", "Packed", "Depth and penumbra in one texture: one fetch per lookup, one more pass.", false));
    return settings;
}

std::size_t index_of(const Settings& settings, const std::string& id, const std::vector<SettingInfo>& infos) {
    const std::string& value = get_choice(settings, id);
    for (const SettingInfo& info : infos) {
        if (info.id == id) {
            return static_cast<std::size_t>(std::ranges::find(info.choices, value) - info.choices.begin());
        }
    }
    return 0;
}

/// The factor by which a transform stretches at most.
double largest_stretch(const glm::dmat3& m) {
    const glm::dmat3 squared = glm::transpose(m) * m;
    glm::dvec3 v{1.0, 0.7, 0.4};
    double stretch = 0.0;
    for (int i = 0; i < 40; ++i) {
        const glm::dvec3 next = squared * v;
        const double length = glm::length(next);
        stretch = std::sqrt(length / glm::length(v));
        v = length > 0.0 ? next / length : v;
    }
    return stretch;
}

/// How much wider than its radius a sphere's image can be in a map: 1 / cosine of the angle from the axis.
double widest_stretch(const MapFrustum& frustum) {
    double widest = 1.0;
    for (const MapFace& face : frustum.faces) {
        const glm::dvec2 corner = glm::max(glm::abs(face.low), glm::abs(face.high));
        widest = std::max(widest, std::sqrt(1.0 + glm::dot(corner, corner)));
    }
    return widest;
}

std::string number_in_words(double value) {
    std::array<char, 32> text{};
    std::snprintf(text.data(), text.size(), "%.2g", value);
    return text.data();
}

}  // namespace

const TechniqueInfo& PenumbraMaps::description() {
    static const TechniqueInfo info{
        .id = "penumbra_maps",
        .title = "Penumbra maps",
        .paper = "WymanHansen2003",
        .summary =
            "Cones and sheets from the silhouettes into a second light-space map: soft outside of the hard edge.",
        .randomised = false,
        .on_cpu = false,
        .lights = all_light_kinds(),
        .settings = penumbra_settings(),
        .knob = "map_size",
    };
    return info;
}

PenumbraMaps::Options PenumbraMaps::options_from(const Settings& settings) {
    const std::vector<SettingInfo>& infos = description().settings;
    Options options;
    options.literal = get_choice(settings, "mode") == "literal";
    options.both_sides = get_choice(settings, "sides") == "both";
    options.gather = get_choice(settings, "filter") == "gathered";
    options.trim = get_bool(settings, "trim_cones");
    options.packed = get_bool(settings, "packed");
    options.facets = get_int(settings, "facets");
    options.parts = get_int(settings, "sheet_parts");
    options.caster_triangles = get_int(settings, "caster_triangles");
    options.shape = static_cast<ConeShape>(index_of(settings, "shape", infos));
    const std::size_t ramp = index_of(settings, "ramp", infos);
    options.ramp = ramp > 0 ? static_cast<Ramp>(ramp - 1) : options.both_sides ? Ramp::Exact : Ramp::Depth;
    const std::size_t falloff = index_of(settings, "falloff", infos);
    if (falloff > 0) {
        options.falloff = static_cast<Falloff>(falloff - 1);
    }
    const std::size_t combine = index_of(settings, "combine", infos);
    options.by_depth_test = combine > 0 ? combine == 2 : options.literal;
    constexpr std::array<GLenum, 3> kFormats{GL_R32F, GL_R16F, GL_R8};
    options.format = kFormats[index_of(settings, "precision", infos)];
    return options;
}

PenumbraMaps::PenumbraMaps(const Settings& settings)
    : options_{options_from(settings)},
      map_{{.size_px = get_int(settings, "map_size"),
            .bias = map_bias_from(settings),
            .facing_test = get_bool(settings, "facing_test"),
            .with_receivers = true,
            .shared_layers = true,
            .along_light_normal = options_.shape == ConeShape::Light}},
      silhouettes_{{.source = silhouette_source(settings)}} {
    if (options_.caster_triangles > 0) {
        map_.use_casters(caster_scene_);
    }
}

Verdict PenumbraMaps::supports(const Light& /*light*/) const {
    return {};
}

std::string PenumbraMaps::too_narrow(const LightSummary& summary) const {
    if (summary.keeps("penumbra-under-half-a-texel")) {
        return {};
    }
    const MapFrustum frustum = map_.fit(summary);
    double widest = 0.0;
    for (const MapFace& face : frustum.faces) {
        const ConeBase base = cone_base(*summary.light, options_.shape, face.ls_from_world);
        const EdgeRange range = edge_range(face, face.orthographic ? 0.0 : base.reach);
        double nearest = range.z_high;
        for (const Bounds& box : summary.caster_bounds_ws) {
            for (unsigned i = 0; i < 8; ++i) {
                const glm::dvec3 corner{(i & 1U) != 0 ? box.high.x : box.low.x, (i & 2U) != 0 ? box.high.y : box.low.y,
                                        (i & 4U) != 0 ? box.high.z : box.low.z};
                nearest = std::min(nearest, (face.ls_from_world * (corner - frustum.origin_ws)).z);
            }
        }
        nearest = std::max(nearest, range.z_low);
        const double gap = face.orthographic ? range.z_high - nearest : 1.0 / nearest - range.w_far;
        const glm::dvec2 step = (face.high - face.low) / static_cast<double>(map_.size_px());
        widest = std::max(widest, base.reach * gap / std::min(step.x, step.y));
    }
    // The shaders leave out each primitive under half a texel, so that nothing would be drawn.
    return widest < 0.49 ? "no penumbra is wider than " + number_in_words(widest) + " texels" : std::string{};
}

FieldOfUse PenumbraMaps::field_of_use() const {
    return {.needs_small_light = !options_.both_sides,
            .needs_round_light = true,
            .needs_clear_light = true,
            .needs_light_above_horizon = map_.facing_test()};
}

Plan PenumbraMaps::plan(const LightSummary& summary) const {
    Plan plan;
    if (!map_.plan(summary, kLookup, plan)) {
        return plan;
    }
    // The lookup comes last.
    const Step lookup_step = plan.steps.back();
    plan.steps.pop_back();
    const std::string narrow = summary.has_extent ? too_narrow(summary) : std::string{};
    std::vector<const char*> soft{kSilhouettes, kPenumbra};
    if (options_.both_sides) {
        soft.push_back(kInner);
    }
    if (options_.packed) {
        soft.push_back(kPack);
    }
    for (const char* step : soft) {
        if (!summary.has_extent && !summary.keeps("light-without-extent")) {
            plan.leave_out(step, "light-without-extent", "the light has no extent, so its shadows are hard");
        } else if (!narrow.empty()) {
            plan.leave_out(step, "penumbra-under-half-a-texel", narrow);
        } else {
            plan.run(step);
        }
    }
    plan.steps.push_back(lookup_step);
    return plan;
}

PenumbraMaps::Falloff PenumbraMaps::falloff() const {
    if (options_.falloff) {
        return *options_.falloff;
    }
    if (options_.both_sides) {
        return Falloff::Area;
    }
    return bases_.front().kind == ConeBase::Kind::Polygon ? Falloff::Linear : Falloff::Smoothstep;
}

Defines PenumbraMaps::shape_defines() const {
    const ConeBase& base = bases_.front();
    return {{"CONE_BASE", std::to_string(base.kind == ConeBase::Kind::Ellipse   ? 0
                                         : base.kind == ConeBase::Kind::Polygon ? 1
                                                                                : 2)},
            {"LIGHT_CORNERS", std::to_string(base.corners.size())},
            {"FALLOFF", std::to_string(static_cast<int>(falloff()))},
            {"SIDES_BOTH", options_.both_sides ? "1" : "0"}};
}

Defines PenumbraMaps::drawing_defines() const {
    Defines all = map_.defines();
    const Defines shape = shape_defines();
    all.insert(all.end(), shape.begin(), shape.end());
    const bool area_of_polygon = falloff() == Falloff::Area && bases_.front().kind == ConeBase::Kind::Polygon;
    all.push_back({"RAMP", std::to_string(static_cast<int>(options_.ramp))});
    all.push_back({"NEEDS_FOOT", options_.ramp == Ramp::Exact || area_of_polygon ? "1" : "0"});
    all.push_back({"COMBINE_LESS", options_.by_depth_test ? "1" : "0"});
    return all;
}

const Program& PenumbraMaps::lookup(Frame& frame) const {
    if (!soft_ && !options_.gather) {
        return map_.lookup(frame, "techniques/shadow_map/shadow_map.frag");
    }
    if (!soft_) {
        return map_.lookup(frame, "techniques/penumbra_maps/lookup.frag",
                           {{"SOFT", "0"}, {"GATHER", "1"}, {"PACKED", "0"}, {"SIDES_BOTH", "0"}});
    }
    Defines more = shape_defines();
    more.push_back({"SOFT", "1"});
    more.push_back({"GATHER", options_.gather ? "1" : "0"});
    more.push_back({"PACKED", options_.packed ? "1" : "0"});
    if (options_.both_sides) {
        more.push_back(InnerEdges::define(5));
    }
    return map_.lookup(frame, "techniques/penumbra_maps/lookup.frag", more);
}

void PenumbraMaps::allocate(Frame& frame) {
    map_.allocate(frame);
    bases_.clear();
    for (const MapFace& face : map_.frustum().faces) {
        bases_.push_back(cone_base(frame.light(), options_.shape, face.ls_from_world));
    }
    // A polygon that one face sees edge on becomes a disc there; then all faces take it, for one program serves all.
    if (!bases_.empty() && !std::ranges::all_of(bases_, [&](const ConeBase& base) {
            return base.kind == bases_.front().kind && base.corners.size() == bases_.front().corners.size();
        })) {
        for (std::size_t i = 0; i < bases_.size(); ++i) {
            bases_[i] = cone_base(frame.light(), ConeShape::Disc, map_.frustum().faces[i].ls_from_world);
        }
    }
    const int layers = static_cast<int>(bases_.size());
    soft_ = layers > 0 && frame.plan().runs(kPenumbra);
    if (!soft_) {
        return;
    }
    const int size_px = map_.size_px();
    MapLayers& shared = *frame.map_layers();
    if (!penumbra_ || penumbra_.texture().layers() != layers) {
        penumbra_ = MapLayers::Lease{};
        packed_ = MapLayers::Lease{};
        penumbra_ = shared.take(options_.format, size_px, layers, "penumbra map");
        if (options_.packed) {
            packed_ = shared.take(GL_RG32F, size_px, layers, "packed map");
        }
        attached_ = glm::uvec2{0};
    }
    attach();
}

void PenumbraMaps::attach() {
    const glm::uvec2 generations{penumbra_.generation(), packed_ ? packed_.generation() : 0};
    if (attached_ == generations) {
        return;
    }
    attached_ = generations;
    targets_.clear();
    packed_targets_.clear();
    const int layers = penumbra_.texture().layers();
    const int size_px = map_.size_px();
    if (options_.by_depth_test) {
        order_ = TextureImage::make_2d(GL_DEPTH_COMPONENT32F, size_px, size_px, "penumbra map's order");
    }
    for (int layer = 0; layer < layers; ++layer) {
        targets_.emplace_back("penumbra map");
        targets_.back().attach_colour(0, penumbra_.texture(), layer);
        if (options_.by_depth_test) {
            targets_.back().attach_depth(order_);
        }
        if (options_.packed) {
            packed_targets_.emplace_back("packed map");
            packed_targets_.back().attach_colour(0, packed_.texture(), layer);
        }
    }
}

void PenumbraMaps::prepare(Frame& frame) {
    if (!frame.plan().runs(kLookup)) {
        return;
    }
    if (options_.caster_triangles > 0) {
        simplify_casters(frame);
    }
    allocate(frame);
    static_cast<void>(lookup(frame));
    if (!soft_) {
        return;
    }
    // Casters that only a kept rule brings in must not matter, and a disc of equal area may reach where the light's
    // own shape does not.
    const LightSummary& summary = frame.summary();
    std::vector<std::uint32_t> casters;
    for (std::size_t i = 0; i < summary.casters.size(); ++i) {
        if (summary.caster_needed[i] != 0) {
            casters.push_back(summary.casters[i]);
        }
    }
    if (options_.caster_triangles > 0) {
        caster_adjacency_.update(caster_scene_);
        silhouettes_.prepare(frame, caster_scene_, caster_adjacency_, casters);
    } else {
        silhouettes_.prepare(frame, frame.gpu_scene(), frame.adjacency(), casters);
    }
    if (options_.both_sides) {
        inner_.allocate(map_.size_px(), static_cast<int>(bases_.size()));
    }
}

void PenumbraMaps::simplify_casters(Frame& frame) {
    Scene scene;
    scene.instances = frame.scene().instances;
    std::size_t triangles = 0;
    for (const Instance& instance : scene.instances) {
        triangles += instance.casts ? instance.mesh->triangles.size() : 0;
    }
    const double share = triangles > 0 ? options_.caster_triangles / static_cast<double>(triangles) : 1.0;
    std::map<const Mesh*, SimplifiedMesh> simplified;
    double deviation_m = 0.0;
    for (Instance& instance : scene.instances) {
        if (!instance.casts || !(share < 1.0)) {
            continue;
        }
        auto found = simplified.find(instance.mesh.get());
        if (found == simplified.end()) {
            const auto wanted = static_cast<std::size_t>(share * static_cast<double>(instance.mesh->triangles.size()));
            frame.control().check();
            found = simplified.emplace(instance.mesh.get(), simplify(instance.mesh, std::max<std::size_t>(4, wanted)))
                        .first;
        }
        instance.mesh = found->second.mesh;
        deviation_m =
            std::max(deviation_m, found->second.deviation * largest_stretch(glm::dmat3{instance.world_from_local}));
    }
    caster_scene_.update(scene);
    map_.set_bias_metres(deviation_m);
}

void PenumbraMaps::set_shape(const Program& program, const ConeBase& base) {
    program.set("light_reach", base.kind == ConeBase::Kind::Ellipse ? 1.0F : static_cast<float>(base.reach));
    if (base.kind == ConeBase::Kind::Polygon) {
        std::vector<glm::vec4> corners;
        std::vector<glm::vec4> sides;
        for (std::size_t i = 0; i < base.corners.size(); ++i) {
            const glm::dvec2 a = base.corners[i];
            const glm::dvec2 along = base.corners[(i + 1) % base.corners.size()] - a;
            const glm::dvec2 normal{along.y, -along.x};
            const double height = glm::dot(normal, a);
            corners.emplace_back(glm::vec2{a}, 0.0F, 0.0F);
            sides.emplace_back(glm::vec2{height > 0.0 ? -normal / height : glm::dvec2{0.0}}, 0.0F, 0.0F);
        }
        program.set("light_corner", std::span<const glm::vec4>{corners});
        program.set("light_side", std::span<const glm::vec4>{sides});
    }
}

void PenumbraMaps::set_contact(const Program& program, const MapFace& face) {
    // Below this the penumbra is narrower than the rounding of depths; perspective: a share of the edge's w.
    program.set("contact", face.orthographic ? static_cast<float>(1e-6 * (face.far_m - face.near_m)) : 1e-6F);
}

void PenumbraMaps::draw_primitives(Frame& frame, std::size_t face_index, std::string_view fragment) {
    const Defines defines = drawing_defines();
    const MapFace& face = map_.frustum().faces[face_index];
    const ConeBase& base = bases_[face_index];
    ProgramLibrary& programs = frame.device().programs;
    map_.bind_space();
    map_.receiver_texture().bind(2);
    silhouettes_.bind(2);
    const EdgeRange range = edge_range(face, face.orthographic ? 0.0 : base.reach);
    const glm::dvec2 step = (face.high - face.low) / static_cast<double>(map_.size_px());
    const auto set_up = [&](const Program& program) {
        set_edge_space(program, static_cast<int>(face_index), range, base.ip_from_unit);
        set_shape(program, base);
        program.set("texels_per_w", static_cast<float>(base.reach / std::min(step.x, step.y)));
        if (fragment.empty()) {
            set_contact(program, face);
        }
        program.use();
    };
    if (!options_.literal) {
        const Program& program = programs.get({"techniques/penumbra_maps/exact.vert",
                                               fragment.empty() ? "techniques/penumbra_maps/exact.frag" : fragment},
                                              defines);
        program.set("trim_cones", options_.trim);
        set_up(program);
        silhouettes_.draw(frame, GL_TRIANGLES, 12);
        return;
    }
    const int facets = base.kind == ConeBase::Kind::Polygon ? static_cast<int>(base.corners.size()) : options_.facets;
    for (const bool cones : {true, false}) {
        Defines part = defines;
        part.push_back({"LITERAL_CONES", cones ? "1" : "0"});
        part.push_back({"FACETS", std::to_string(facets)});
        part.push_back({"PARTS", std::to_string(options_.parts)});
        set_up(programs.get({"techniques/penumbra_maps/literal.vert",
                             fragment.empty() ? "techniques/penumbra_maps/literal.frag" : fragment},
                            part));
        silhouettes_.draw(frame, GL_TRIANGLES, cones ? 3 * facets : 6 * options_.parts);
    }
}

void PenumbraMaps::draw_penumbra(Frame& frame) {
    glClipControl(GL_LOWER_LEFT, GL_ZERO_TO_ONE);
    if (options_.by_depth_test) {
        glEnable(GL_DEPTH_TEST);
        glDepthMask(GL_TRUE);
        glDepthFunc(GL_LESS);
    } else {
        glDisable(GL_DEPTH_TEST);
        glEnable(GL_BLEND);
        glBlendEquation(GL_MIN);
    }
    for (std::size_t i = 0; i < targets_.size(); ++i) {
        targets_[i].bind();
        targets_[i].clear_colour(0, glm::vec4{1.0F});
        if (options_.by_depth_test) {
            targets_[i].clear_depth(1.0F);
        }
        draw_primitives(frame, i, {});
    }
    glDisable(GL_DEPTH_TEST);
    glDisable(GL_BLEND);
    glBlendEquation(GL_FUNC_ADD);
}

void PenumbraMaps::pack(Frame& frame) {
    const Program& program = frame.device().programs.get({"lib/fullscreen.vert", "techniques/penumbra_maps/pack.frag"});
    map_.texture().bind(2);
    penumbra_.texture().bind(3);
    for (std::size_t i = 0; i < packed_targets_.size(); ++i) {
        program.set("layer", static_cast<int>(i));
        frame.fullscreen().draw(packed_targets_[i], program);
    }
}

void PenumbraMaps::update(Frame& frame) {
    if (!frame.plan().runs(kLookup)) {
        return;
    }
    map_.update(frame);
    allocate(frame);
    if (!soft_) {
        return;
    }
    frame.step(kSilhouettes, [&] {
        const Light& light = frame.light();
        const glm::dvec4 from =
            light.kind == LightKind::Sun ? glm::dvec4{-light.direction_ws, 0.0} : glm::dvec4{light.position_ws, 1.0};
        silhouettes_.extract(frame, from, map_.frustum().origin_ws);
    });
    frame.step(kPenumbra, [&] { draw_penumbra(frame); });
    frame.step(kInner, [&] {
        const ConeBase& base = bases_.front();
        double widest = base.kind == ConeBase::Kind::Ellipse ? 1.0 : base.reach;
        if (base.kind == ConeBase::Kind::Sphere) {
            widest *= widest_stretch(map_.frustum());
        }
        inner_.draw(frame, silhouettes_, map_, {.fixed = 0.0, .per_w = widest, .ip_from_unit = base.ip_from_unit});
    });
    frame.step(kPack, [&] { pack(frame); });
}

void PenumbraMaps::resolve(Frame& frame) {
    frame.step(kLookup, [&] {
        const Program& program = lookup(frame);
        map_.bind(program);
        if (soft_) {
            if (options_.packed) {
                packed_.texture().bind(2);
            } else {
                penumbra_.texture().bind(4);
            }
            if (options_.both_sides) {
                inner_.bind(5);
                inner_.set_uniforms(program);
                program.set("one", 1);
                set_shape(program, bases_.front());
                set_contact(program, map_.frustum().faces.front());
            }
        }
        frame.resolve_with(program);
    });
}

std::vector<DebugView> PenumbraMaps::debug_views(const Plan& plan) const {
    if (!plan.runs(kLookup)) {
        return {};
    }
    std::vector<DebugView> views{depth_map_view()};
    if (plan.runs(kPenumbra)) {
        views.push_back({"silhouettes", "Silhouettes in the view"});
        views.push_back({"silhouettes_in_map", "Silhouettes as the light sees them"});
        views.push_back({"cones_and_sheets", "Cones and sheets as the light sees them"});
        views.push_back({"penumbra_map", "Penumbra map"});
    }
    if (plan.runs(kInner)) {
        views.push_back({"inner_edges", "Distance from the nearest edge inside shadows"});
    }
    return views;
}

DebugImage PenumbraMaps::debug_image(Frame& frame, std::string_view id) {
    const glm::vec3 line{1.0F, 0.55F, 0.1F};
    if (id == "silhouettes") {
        return view_picture(frame, "edges that the light's centre sees as an outline; faint: behind a surface",
                            [&](RenderTarget& target) {
                                draw_silhouettes_in_view(frame, target, silhouettes_, map_.frustum().origin_ws, line);
                            });
    }
    if (id == "silhouettes_in_map") {
        return map_picture(frame, map_, "edges that the light's centre sees as an outline",
                           [&](int face, RenderTarget& target) {
                               draw_silhouettes_in_map(frame, target, silhouettes_, map_, face, line);
                           });
    }
    if (id == "cones_and_sheets") {
        return map_picture(frame, map_, "cones and sheets down to the deepest receiver, as triangles",
                           [&](int face, RenderTarget&) {
                               glPolygonMode(GL_FRONT_AND_BACK, GL_LINE);
                               constexpr const char* kFlat = "techniques/penumbra_maps/debug_flat.frag";
                               draw_primitives(frame, static_cast<std::size_t>(face), kFlat);
                           });
    }
    if (id == "penumbra_map") {
        return texture_picture(penumbra_.texture(), 0, 0.0F, 1.0F,
                               "intensity of the nearest surfaces, white where nothing is drawn");
    }
    if (id == "inner_edges") {
        double widest = 0.0;
        for (std::size_t i = 0; i < bases_.size(); ++i) {
            const MapFace& face = map_.frustum().faces[i];
            const double unit = bases_[i].kind == ConeBase::Kind::Ellipse ? bases_[i].reach : 1.0;
            widest = std::max(widest, 0.1 * glm::length(face.high - face.low) / std::max(unit, 1e-30));
        }
        return texture_picture(inner_.texture(), 2, 0.0F, static_cast<float>(widest),
                               "distance from the nearest edge inside shadows, black where there is none");
    }
    return depth_map_picture(frame, map_);
}

std::vector<Statistic> PenumbraMaps::statistics(Frame& frame) {
    const MapLayers::Usage usage = frame.map_layers()->usage();
    return {{"map_arrays", "Map arrays, of all lights", "arrays", static_cast<double>(usage.arrays)},
            {"map_layers", "Layers in use in them", "layers", static_cast<double>(usage.layers_used)}};
}

std::size_t PenumbraMaps::memory_bytes() const noexcept {
    const auto of = [](const TextureImage& texture) { return texture ? texture.bytes() : 0; };
    return map_.bytes() + silhouettes_.bytes() + inner_.bytes() +
           (options_.caster_triangles > 0 ? caster_scene_.memory_bytes() + caster_adjacency_.memory_bytes() : 0) +
           (penumbra_ ? of(penumbra_.texture()) : 0) + (packed_ ? of(packed_.texture()) : 0) + of(order_);
}

}  // namespace penumbra
