#include "techniques/plateaus/plateaus.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "geometry/cone_base.h"
#include "geometry/light_region.h"
#include "passes/debug_picture.h"
#include "passes/frame.h"
#include "scene/setting_forms.h"
#include "techniques/all_lights.h"

namespace penumbra {

namespace {

constexpr const char* kLookup = "techniques/plateaus/lookup.frag";
constexpr const char* kNoPlane = "every visible receiver lies on a plane with a texture of its own";
constexpr double kClipAtLight = 0.999;  ///< of the light's height: what is higher has no bounded image
constexpr int kBorder_px = 2;
constexpr std::size_t kMostPieces = std::size_t{1}
                                    << 19U;  ///< of slopes cut to tiles, on one plane; the rest stays whole
constexpr int kLevels = 5;  ///< of the pyramid of covered cells: every second one is used, 4, 16 and 64 texels wide
enum class SiftPass { All, Bound, Cut };                      ///< PASS of sift.vert
constexpr double kNothingDarkest = 4095.0 * 4096.0 + 4095.0;  ///< lit, from the height 0 (slopes.frag)

const std::vector<std::string> kFalloffs{"linear", "sine", "smoothstep", "disc", "disc_full"};

std::vector<SettingInfo> plateau_settings() {
    std::vector<SettingInfo> settings{
        number_setting("size", "Texture size", "px",
                       "Longer side of the largest plane's texture; smaller planes get less.", 1024, 16, 16384,
                       {128, 256, 512, 1024, 2048}),
        number_setting("planes", "Planes", "", "How many planes get a texture, those that fill most pixels first.", 8,
                       0, 15, {1, 4, 8, 15}),
        name_setting("plane", "Plane",
                     "auto: planes found in the view; or the name of the one object whose planes count.", "auto"),
        choice_setting("extent", "Extent",
                       "view: the part of a plane that is seen; object: all of its objects' faces on it.",
                       {"view", "object"}),
        number_setting("plane_tolerance", "Plane tolerance", "",
                       "Unevenness of a plane, in radii of what is seen of the scene.", 1e-4, 0.0, 0.1),
        number_setting("smallest_plane", "Smallest plane", "",
                       "Share of the lit pixels below which a plane gets no texture.", 0.01, 0.0, 1.0),
        choice_setting(
            "light_shape", "Light shape",
            "own: the light's own outline as each point of the plane sees it; disc: a disc of its area, parallel to "
            "the plane.",
            {"own", "disc"}),
        choice_setting(
            "radius_model", "Radius model",
            "Growth of a penumbra with its caster's height h: disc R h / (H - h), linear k h, sun h tan(a) / cos(t); "
            "auto: disc, for a sun sun.",
            {"auto", "linear", "disc", "sun"}),
        number_setting("k", "Width per height", "", "Linear radius model: k of r = k h; 0: from the light's size.", 0.0,
                       0.0, 10.0),
        choice_setting("match", "Match",
                       "outer: the outer half of the penumbra is as wide as the truth's; width: as wide as all of it.",
                       {"outer", "width"}),
        choice_setting(
            "sheet_mode", "Sheets",
            "envelope: cones of all points of an edge; bilinear: the paper's patch; tess: the patch as triangles.",
            {"envelope", "bilinear", "tess"}),
        swept_when(number_setting("cells", "Cells", "",
                                  "Tessellated sheets: cells along each side; 0: as many as 1/255 asks for.", 0, 0, 32,
                                  {2, 8, 32}),
                   "sheet_mode", "tess"),
        choice_setting("cones", "Cones",
                       "analytic, or fans of triangles; fans with bilinear and tessellated sheets only.",
                       {"analytic", "fan"}),
        swept_when(number_setting("segments", "Segments", "", "Triangles of a fan.", 36, 12, 72, {12, 36, 72}), "cones",
                   "fan"),
        choice_setting("edges", "Edges",
                       "silhouette; facing: all edges of light-facing triangles; all: every edge, both sides.",
                       {"silhouette", "facing", "all"}),
        choice_setting("falloff", "Falloff", "Profile of a slope; disc and disc_full: exact on a straight edge.",
                       kFalloffs),
        choice_setting("sides", "Sides",
                       "outer: as published; both: the inner half of the penumbra too, with exact areas.",
                       {"outer", "both"}, {std::string{"outer"}, std::string{"both"}}),
        number_setting("dark", "Darkest", "", "V in the umbra.", 0.0, 0.0, 1.0),
        number_setting("smallest_radius", "Smallest radius", "texel", "Lower limit of a penumbra's width; 0: none.",
                       0.0, 0.0, 8.0),
        number_setting("corner_radius", "Corner radius", "",
                       "Rectangle lights: share of the half sides that is rounded.", 0.0, 0.0, 1.0),
        number_setting("lozenge_radius", "Lozenge radius", "", "Line lights: half width over half length.", 0.02, 0.001,
                       1.0),
        choice_setting("store", "Store", "float; byte: 8 bits; depth: a 16-bit depth buffer, darkest by depth test.",
                       {"float", "byte", "depth"}),
        number_setting("hither", "Hither", "", "Depth of the umbra, where depth is stored.", 0.0, 0.0, 0.9),
        number_setting("yon", "Yon", "", "Depth of full light, where depth is stored.", 1.0, 0.1, 1.0),
        choice_setting(
            "off_planes", "Off planes",
            "Receivers on no plane: hard; or slopes of the plane behind them, narrowed by their height, or as "
            "projected.",
            {"hard", "narrowed", "projected"}),
    };
    settings.push_back(silhouette_setting());
    for (SettingInfo& setting : map_settings("slope", true)) {
        setting.sweep.clear();  // of the depth map, which only receivers off the planes see
        settings.push_back(std::move(setting));
    }
    return settings;
}

int index_of(const std::vector<std::string>& names, const std::string& name) {
    return static_cast<int>(std::ranges::find(names, name) - names.begin());
}

EdgeChoice edge_choice(const std::string& name) {
    return name == "silhouette" ? EdgeChoice::Silhouettes
                                : (name == "facing" ? EdgeChoice::LightFacing : EdgeChoice::All);
}

/// Textures in a row, bottom aligned.
DebugImage side_by_side(const std::vector<BakedTexture>& textures, std::string caption) {
    DebugImage image;
    image.caption = std::move(caption);
    for (const BakedTexture& texture : textures) {
        image.width_px += texture.width_px;
        image.height_px = std::max(image.height_px, texture.height_px);
    }
    image.rgb.assign(static_cast<std::size_t>(image.width_px) * image.height_px, glm::vec3{0.25F});
    int left = 0;
    for (const BakedTexture& texture : textures) {
        for (int y = 0; y < texture.height_px; ++y) {
            for (int x = 0; x < texture.width_px; ++x) {
                image.rgb[static_cast<std::size_t>(y) * image.width_px + left + x] =
                    glm::vec3{texture.visibility[static_cast<std::size_t>(y) * texture.width_px + x]};
            }
        }
        left += texture.width_px;
    }
    return image;
}

DebugImage planes_picture(const View& view, const PlanarReceivers& receivers) {
    DebugImage image{view.width, view.height, {}, "Each plane with a texture in a colour of its own; grey: none."};
    for (std::size_t i = 0; i < view.size(); ++i) {
        const std::uint8_t p = receivers.plane_of_pixel[i];
        const float hue = 2.399963F * static_cast<float>(p);  // the golden angle keeps neighbours apart
        const glm::vec3 colour = 0.6F + 0.3F * glm::cos(hue + glm::vec3{0.0F, 2.094F, 4.189F});
        const float shade = 0.4F + 0.6F * std::abs(view.normal_ws[i].z);
        image.rgb.push_back(!view.hit(i) ? glm::vec3{0.0F}
                                         : (p == PlanarReceivers::kNone ? glm::vec3{0.5F * shade} : shade * colour));
    }
    return image;
}

/// Largest height of the casters' boxes over the plane, and the largest distance from the pass's origin.
glm::dvec2 reach_of_casters(const LightSummary& summary, const PlanarReceiver& plane, const glm::dvec3& origin_ws) {
    glm::dvec2 reach{0.0};
    for (const Bounds& box : summary.caster_bounds_ws) {
        const double up = glm::dot(box.half_size(), glm::abs(plane.normal));
        reach.x = std::max(reach.x, plane.height(box.centre()) + up);
        reach.y = std::max(reach.y, glm::length(box.centre() - origin_ws) + box.radius());
    }
    return reach;
}

/// A rectangle around the shadow that a caster's box throws on a plane, plane coordinates; empty: it throws none.
struct Shadow {
    glm::dvec2 low_m{std::numeric_limits<double>::infinity()};
    glm::dvec2 high_m{-std::numeric_limits<double>::infinity()};
    [[nodiscard]] bool meets(const glm::dvec2& from_m, const glm::dvec2& to_m) const noexcept {
        return glm::all(glm::lessThanEqual(low_m, to_m)) && glm::all(glm::greaterThanEqual(high_m, from_m));
    }
};

/// @param heights  least and largest height that casts, metres; below the light's
Shadow shadow_of(const Bounds& box, const PlanarReceiver& plane, const plateau::PlaneLight& light,
                 const glm::dvec2& heights) {
    const glm::dvec3 offset = box.centre() - plane.origin_ws;
    const glm::dvec3 middle{glm::dot(offset, plane.axis_x), glm::dot(offset, plane.axis_y), plane.height(box.centre())};
    const glm::dvec3 half{glm::dot(box.half_size(), glm::abs(plane.axis_x)),
                          glm::dot(box.half_size(), glm::abs(plane.axis_y)),
                          glm::dot(box.half_size(), glm::abs(plane.normal))};
    const double lowest = std::max(middle.z - half.z, heights.x);
    const double highest = std::min(middle.z + half.z, heights.y);
    Shadow shadow;
    for (unsigned i = 0; i < 8 && lowest <= highest; ++i) {
        const glm::dvec2 at =
            plateau::project({middle.x + ((i & 1U) != 0 ? half.x : -half.x),
                              middle.y + ((i & 2U) != 0 ? half.y : -half.y), (i & 4U) != 0 ? highest : lowest},
                             light);
        shadow.low_m = glm::min(shadow.low_m, at);
        shadow.high_m = glm::max(shadow.high_m, at);
    }
    return shadow;
}

}  // namespace

const TechniqueInfo& Plateaus::description() {
    static const TechniqueInfo info{
        .id = "plateaus",
        .title = "Plateaus",
        .paper = "Haines2001",
        .summary =
            "One texture for each receiver plane: the hard shadow with slopes around it, cones and sheets grown from "
            "the silhouettes, the darkest wins.",
        .randomised = false,
        .on_cpu = false,
        .lights = all_light_kinds(),
        .settings = plateau_settings(),
        .knob = "size",
    };
    return info;
}

Plateaus::Plateaus(const Settings& settings)
    : finding_{.most = get_int(settings, "planes"),
               .tolerance_m = 0.0,
               .least_share = get_double(settings, "smallest_plane"),
               .whole = get_choice(settings, "extent") == "object",
               .only = get_choice(settings, "plane") == "auto" ? "" : get_choice(settings, "plane")},
      shape_{.own_shape = get_choice(settings, "light_shape") == "own",
             .linear_radius = get_choice(settings, "radius_model") == "linear",
             .k = get_double(settings, "k"),
             .match = get_choice(settings, "match") == "width" ? 2.0 : 1.0,
             .corner_radius = get_double(settings, "corner_radius"),
             .lozenge_radius = get_double(settings, "lozenge_radius"),
             .least_radius_texels = get_double(settings, "smallest_radius")},
      plane_tolerance_{get_double(settings, "plane_tolerance")},
      size_px_{get_int(settings, "size")},
      sheets_{static_cast<Sheets>(index_of({"envelope", "bilinear", "tess"}, get_choice(settings, "sheet_mode")))},
      cells_{get_int(settings, "cells")},
      fans_{get_choice(settings, "cones") == "fan"},
      segments_{get_int(settings, "segments")},
      edges_{edge_choice(get_choice(settings, "edges"))},
      store_{static_cast<Store>(index_of({"float", "byte", "depth"}, get_choice(settings, "store")))},
      hither_yon_{get_double(settings, "hither"), get_double(settings, "yon")},
      falloff_{index_of(kFalloffs, get_choice(settings, "falloff"))},
      dark_{get_double(settings, "dark")},
      both_sides_{get_choice(settings, "sides") == "both"},
      narrow_{get_choice(settings, "off_planes") == "narrowed"},
      soft_off_planes_{get_choice(settings, "off_planes") != "hard"},
      map_{{.size_px = get_int(settings, "map_size"),
            .bias = map_bias_from(settings),
            .facing_test = get_bool(settings, "facing_test")}},
      silhouettes_{{.source = silhouette_source(settings), .choice = edges_}} {
    if (hither_yon_.x >= hither_yon_.y) {
        throw InvalidSettings("plateaus.hither: " + std::to_string(hither_yon_.x) + " is not below plateaus.yon, " +
                              std::to_string(hither_yon_.y) + "; give a smaller one");
    }
    const std::string& model = get_choice(settings, "radius_model");
    if (shape_.linear_radius || model == "sun") {  // models of circles
        shape_.own_shape = false;
        shape_.linear_radius = true;
    }
    if (edges_ != EdgeChoice::Silhouettes) {
        soft_off_planes_ = false;  // a receiver's own edges would be its nearest casters
    }
    if (both_sides_) {  // exact areas stand for sheets, and need the sign that only floats have
        sheets_ = Sheets::Envelope;
        store_ = Store::Float;
    }
}

Verdict Plateaus::supports(const Light& /*light*/) const {
    return {};
}

bool Plateaus::slopes_off_planes(const Layout& layout) const noexcept {
    return layout.map && !layout.hard && soft_off_planes_ && store_ != Store::Depth && !layout.blocks.empty();
}

bool Plateaus::skips_umbra() const noexcept {
    return store_ != Store::Depth && !both_sides_ && !slopes_off_planes(layout_);
}

bool Plateaus::sifts(const LightSummary& summary, const Layout& layout) const noexcept {
    return !summary.keeps("silhouette-under-umbra") &&
           !slopes_off_planes(layout);  // those read slopes under the umbra too
}

bool Plateaus::skips_unseen(const LightSummary& summary, const Layout& layout) const noexcept {
    // A texture of whole objects is for baking, and where depth is the store there is no second depth to skip by.
    return !summary.keeps("texel-without-pixel") && !slopes_off_planes(layout) && !finding_.whole &&
           store_ != Store::Depth;
}

Plateaus::Layout Plateaus::lay_out(const LightSummary& summary) const {
    Layout layout;
    const Light& light = *summary.light;
    const View& view = *summary.view;
    layout.origin_ws = summary.receivers_ws.centre();
    PlanarReceiverOptions finding = finding_;
    finding.tolerance_m = plane_tolerance_ * summary.receivers_ws.radius();
    layout.receivers = find_planar_receivers(*summary.scene, view, summary.mask, finding);
    PlanarReceivers& receivers = layout.receivers;

    // Planes over which the light stands too low are left to the depth map.
    std::vector<std::uint8_t> renumbered(receivers.planes.size() + 1, PlanarReceivers::kNone);
    std::vector<PlanarReceiver> served;
    for (std::size_t p = 0; p < receivers.planes.size(); ++p) {
        if (light_serves(receivers.planes[p], light)) {
            renumbered[p] = static_cast<std::uint8_t>(served.size());
            served.push_back(receivers.planes[p]);
        } else {
            receivers.pixels_on_none += receivers.planes[p].pixels;
        }
    }
    if (served.size() != receivers.planes.size()) {
        for (std::uint8_t& p : receivers.plane_of_pixel) {
            p = p == PlanarReceivers::kNone ? p : renumbered[p];
        }
        receivers.planes = std::move(served);
    }

    // Pixels off the planes look up where their light's ray goes on to: a little more of each plane for them.
    std::vector<plateau::PlaneLight> lights;
    lights.reserve(receivers.planes.size());
    for (const PlanarReceiver& plane : receivers.planes) {
        lights.push_back(light_on(plane, light));
    }
    std::vector<glm::dvec2> low;
    std::vector<glm::dvec2> high;
    for (const PlanarReceiver& plane : receivers.planes) {
        low.push_back(plane.low_m);
        high.push_back(plane.high_m);
    }
    for (std::size_t i = 0; receivers.pixels_on_none > 0 && soft_off_planes_ && i < view.size(); ++i) {
        if (summary.mask[i] == 0 || receivers.plane_of_pixel[i] != PlanarReceivers::kNone) {
            continue;
        }
        const glm::dvec3 p_ws = view.eye_ws + glm::dvec3{view.position_cr[i]};
        for (std::size_t p = 0; p < receivers.planes.size(); ++p) {
            const PlanarReceiver& plane = receivers.planes[p];
            const glm::dvec3 offset = p_ws - plane.origin_ws;
            const glm::dvec3 at{glm::dot(offset, plane.axis_x), glm::dot(offset, plane.axis_y), plane.height(p_ws)};
            if (at.z > 0.0 && (lights[p].w == 0.0 || at.z < kClipAtLight * lights[p].z)) {
                const glm::dvec2 more = 0.25 * (plane.high_m - plane.low_m);
                const glm::dvec2 s =
                    glm::clamp(plateau::project(at, lights[p]), plane.low_m - more, plane.high_m + more);
                low[p] = glm::min(low[p], s);
                high[p] = glm::max(high[p], s);
            }
        }
    }

    double widest = 0.0;
    for (std::size_t p = 0; p < receivers.planes.size(); ++p) {
        const PlanarReceiver& plane = receivers.planes[p];
        const glm::dvec2 reach = reach_of_casters(summary, plane, layout.origin_ws);
        // Float32 roundings of the casters' own coordinates must not lift the plane's mesh off it.
        const double least = std::max(finding.tolerance_m, 2e-6 * reach.y);
        double largest = std::max(1.01 * reach.x, 2.0 * least);
        if (lights[p].w != 0.0) {
            largest = std::min(largest, kClipAtLight * lights[p].z);
        }
        gpu::PlateauPlane block = make_plateau_plane(plane, light, shape_, layout.origin_ws, {least, largest});
        const double share =
            std::sqrt(static_cast<double>(plane.pixels) / static_cast<double>(receivers.planes[0].pixels));
        const double size = std::max(std::min(64.0, static_cast<double>(size_px_)), std::round(size_px_ * share));
        const glm::dvec2 extent = high[p] - low[p];
        const double longer = std::max({extent.x, extent.y, 4.0 * least});
        const double texel = longer / std::max(1.0, size - 2.0 * kBorder_px);
        const glm::ivec2 size_px =
            glm::max(glm::ivec2{glm::ceil(extent / texel - 1e-9)}, glm::ivec2{1}) + 2 * kBorder_px;
        const glm::dvec2 corner = low[p] - kBorder_px * texel;
        block.window = glm::vec4{glm::vec2{corner}, static_cast<float>(texel), static_cast<float>(1.0 / texel)};
        block.size.x = size_px.x;
        block.size.y = size_px.y;
        const double sigma =
            block.heights.z > 0.0F ? block.heights.z * largest : plateau::image_scale(largest, lights[p]);
        const double cosine = lights[p].z / glm::length(glm::dvec3{lights[p]});
        const double reach_m = shape_.match * std::max(disc_radius(light), light_region(light).radius());
        widest = std::max(widest, sigma * reach_m / cosine / texel);
        if (const double radius = disc_radius(light); radius > 0.0) {
            block.normal.w = static_cast<float>(shape_.least_radius_texels * texel / radius);
        }
        layout.width_px = std::max(layout.width_px, size_px.x);
        layout.height_px = std::max(layout.height_px, size_px.y);
        const bool parallel = block.half_u.z == 0.0F && block.half_v.z == 0.0F && block.dual_v.w == 0.0F;
        const PlateauLight variant = plateau_light(light, shape_);
        layout.frames.push_back(variant.frame != PlateauLight::Frame::Ball && parallel ? PlateauLight::Frame::Parallel
                                                                                       : variant.frame);
        layout.blocks.push_back(block);
    }
    layout.widest_texels = widest;
    layout.hard = !summary.has_extent ||
                  (shape_.k <= 0.0 && shape_.least_radius_texels <= 0.0 && widest < 0.5 && !layout.blocks.empty());
    layout.map = layout.hard || receivers.pixels_on_none > 0 || summary.keeps("every-receiver-on-a-plane");
    return layout;
}

std::vector<std::uint32_t> Plateaus::casters_onto(const LightSummary& summary, const Layout& layout,
                                                  std::size_t plane) {
    const gpu::PlateauPlane& block = layout.blocks[plane];
    const PlanarReceiver& receiver = layout.receivers.planes[plane];
    const plateau::PlaneLight light = light_on(receiver, *summary.light);
    const glm::dvec2 heights{0.5 * static_cast<double>(block.heights.x), block.heights.y};
    const double texel = block.window.z;  // one more all around: roundings
    const glm::dvec2 low = glm::dvec2{block.window} - texel;
    const glm::dvec2 high = low + texel * (glm::dvec2{block.size} + 2.0);
    std::vector<std::uint32_t> casters;
    for (std::size_t c = 0; c < summary.casters.size(); ++c) {
        if (summary.keeps("caster-outside-face") ||
            shadow_of(summary.caster_bounds_ws[c], receiver, light, heights).meets(low, high)) {
            casters.push_back(summary.casters[c]);
        }
    }
    return casters;
}

std::string Plateaus::step_of(const Layout& layout, std::size_t plane) {
    return "plateau " + std::to_string(plane + 1) + ", " + layout.receivers.planes[plane].name;
}

FieldOfUse Plateaus::field_of_use() const {
    return {.needs_small_light = !both_sides_,
            .needs_round_light = true,
            .needs_clear_light = true,
            .needs_light_above_horizon = map_.facing_test()};
}

Plan Plateaus::plan(const LightSummary& summary) const {
    Plan plan;
    const LightSummary::Trivial trivial = summary.trivial();
    if (!trivial.reason.empty()) {
        plan.leave_out("plateaus", trivial.rule, trivial.reason);
        plan.leave_out("lookup", trivial.rule, trivial.reason);
        return plan;
    }
    const Layout layout = lay_out(summary);
    if (layout.map) {
        Plan map;
        map_.plan(summary, "lookup", map);
        map.steps.pop_back();  // the lookup itself, which comes last
        plan = map;
    } else {
        plan.leave_out("depth map", "every-receiver-on-a-plane", kNoPlane);
        if (summary.casters_outside > 0) {
            plan.leave_out("casters out of reach", "caster-outside-hull",
                           std::to_string(summary.casters_outside) +
                               " casters lie outside the space between the light and the visible receivers");
        }
    }
    const std::string rule = summary.has_extent ? "penumbra-under-half-a-texel" : "light-without-extent";
    if (layout.hard && !summary.keeps(rule)) {
        const std::string reason = summary.has_extent
                                       ? "no penumbra is wider than half a texel"
                                       : "all points of the light coincide, so every penumbra has the width 0";
        plan.leave_out("silhouettes", rule, reason);
        plan.leave_out("plateaus", rule, reason);
    } else if (!layout.blocks.empty()) {
        const std::size_t draws = summary.casters.size() * layout.blocks.size();
        std::size_t drawn = 0;
        for (std::size_t p = 0; p < layout.blocks.size(); ++p) {
            drawn += casters_onto(summary, layout, p).size();
        }
        if (drawn < draws) {
            plan.leave_out("casters beside the planes", "caster-outside-face",
                           std::to_string(draws - drawn) + " of " + std::to_string(draws) +
                               " draws of a caster onto a plane would touch no texel of its texture");
        }
        plan.run("silhouettes");
        for (std::size_t p = 0; p < layout.blocks.size(); ++p) {
            plan.run(step_of(layout, p));
        }
        if (sifts(summary, layout)) {
            plan.leave_out("hidden silhouettes", "silhouette-under-umbra",
                           "found on the device for each plane: all of an edge's sheet and cone lies under the umbra, "
                           "or where no pixel looks");
        }
        if (cuts_to_tiles(summary, layout)) {
            plan.leave_out("tiles of wide slopes", "slope-never-darkest",
                           "found on the device by bounds of each slope over each tile of " +
                               std::to_string(PENUMBRA_PLATEAU_TILE) + " texels");
        }
        if (skips_unseen(summary, layout)) {
            plan.leave_out("unseen texels", "texel-without-pixel", "no pixel of the view looks them up");
        }
    }
    plan.run("lookup");
    return plan;
}

Defines Plateaus::defines(std::size_t plane) const {
    return {{"GAUGE", std::to_string(static_cast<int>(light_.gauge))},
            {"FRAME", std::to_string(static_cast<int>(layout_.frames[plane]))},
            {"SIDES", both_sides_ ? "2" : "1"},
            {"HEIGHTS", slopes_off_planes(layout_) ? "1" : "0"},
            {"STORE_DEPTH", store_ == Store::Depth ? "1" : "0"}};
}

const Program& Plateaus::lookup(Frame& frame) const {
    Defines all = layout_.map ? map_.defines() : Defines{};
    all.insert(all.end(), {{"REST", layout_.map ? "1" : "0"},
                           {"HARD", layout_.hard ? "1" : "0"},
                           {"NARROW", narrow_ ? "1" : "0"},
                           {"FALLOFF", std::to_string(falloff_)},
                           {"GAUGE", "0"},
                           {"FRAME", "0"},
                           {"SIDES", both_sides_ ? "2" : "1"},
                           {"HEIGHTS", slopes_off_planes(layout_) ? "1" : "0"},
                           {"STORE_DEPTH", store_ == Store::Depth ? "1" : "0"}});
    return frame.device().programs.get({"lib/fullscreen.vert", kLookup}, all);
}

void Plateaus::prepare(Frame& frame) {
    if (!frame.plan().runs("lookup")) {
        return;
    }
    layout_ = lay_out(frame.summary());
    light_ = plateau_light(frame.light(), shape_);
    if (layout_.map) {
        map_.allocate(frame);
    }
    const View& view = frame.view();
    plane_of_pixel_ = TextureImage::make_2d(GL_R8UI, view.width, view.height, "plane of each pixel");
    plane_of_pixel_.upload(std::span<const std::uint8_t>{layout_.receivers.plane_of_pixel});
    gpu::PlateauBlock block{};
    block.origin_cr = glm::vec4{glm::vec3{layout_.origin_ws - frame.summary().eye_ws}, 0.0F};
    block.counts.x = static_cast<int>(layout_.blocks.size());
    std::ranges::copy(layout_.blocks, block.planes);
    block_.replace(std::span<const gpu::PlateauBlock>{&block, 1});
    static_cast<void>(lookup(frame));
    if (!frame.plan().runs("silhouettes")) {
        return;
    }

    const int layers = static_cast<int>(layout_.blocks.size());
    const int width = layout_.width_px;
    const int height = layout_.height_px;
    const GLenum format = store_ == Store::Depth ? GL_DEPTH_COMPONENT16 : (store_ == Store::Byte ? GL_R8 : GL_R32F);
    slopes_ = TextureImage::make_array(format, width, height, layers, "plateaus");
    umbra_ = both_sides_ ? TextureImage::make_array(GL_R8, width, height, layers, "umbrae") : TextureImage{};
    darkest_ = slopes_off_planes(layout_)
                   ? TextureImage::make_array(GL_R32F, width, height, layers, "heights of the darkest casters")
                   : TextureImage{};
    sifts_ = sifts(frame.summary(), layout_);
    cuts_to_tiles_ = cuts_to_tiles(frame.summary(), layout_);
    const bool skips = skips_unseen(frame.summary(), layout_);
    wanted_ = skips ? TextureImage::make_array(GL_DEPTH_COMPONENT16, width, height, layers, "texels looked up")
                    : TextureImage{};
    if (skips) {
        wanted_.upload(std::span<const std::uint16_t>{texels_looked_up(view)});
    }
    skip_depth_ = skips || skips_umbra()
                      ? TextureImage::make_2d(GL_DEPTH_COMPONENT16, width, height, "texels without slopes")
                      : TextureImage{};
    const glm::ivec2 blocks = (glm::ivec2{width, height} + 63) / 64;
    covered_ = sifts_ ? TextureImage::make_2d(GL_RGBA8, 16 * blocks.x, 16 * blocks.y, "covered cells", kLevels)
                      : TextureImage{};
    no_attributes_ = VertexArray::create();
    umbra_targets_.clear();
    slope_targets_.clear();
    for (int layer = 0; layer < layers; ++layer) {
        RenderTarget& umbra = umbra_targets_.emplace_back("plateau's umbra");
        RenderTarget& slopes = slope_targets_.emplace_back("plateau");
        for (RenderTarget* target : {&umbra, &slopes}) {
            if (store_ == Store::Depth) {
                target->attach_depth(slopes_, layer);
            } else {
                target->attach_colour(0, slopes_, layer);
            }
            if (skip_depth_) {
                target->attach_depth(skip_depth_);
            }
        }
        if (both_sides_) {
            umbra.attach_colour(1, umbra_, layer);
        }
        if (darkest_) {
            slopes.attach_colour(1, darkest_, layer);
        }
    }
    draws_ = StorageBuffer(static_cast<std::size_t>(layers) * sizeof(gpu::PlaneDraws), "draws of planes");
    silhouettes_.prepare(frame, frame.gpu_scene(), frame.adjacency(), frame.summary().casters);
    const GpuScene& scene = frame.gpu_scene();
    std::vector<std::uint32_t> first_box(std::max<std::size_t>(1, scene.instance_count()), 0);
    std::size_t boxes = 0;
    for (const std::uint32_t i : frame.summary().casters) {
        first_box[i] = static_cast<std::uint32_t>(boxes);
        boxes += scene.meshes()[scene.mesh_of_instance(i)]->positions_local.size();
    }
    const bool mail = edges_ != EdgeChoice::Silhouettes || fans_;
    mailboxes_ = StorageBuffer(mail && sheets_ != Sheets::Envelope ? boxes * sizeof(std::uint32_t) : 0, "mailboxes");
    first_box_ = StorageBuffer::from(first_box, "mailboxes of instances");
}

void Plateaus::bind_block() {
    block_.bind_uniform(2);
}

std::vector<std::uint16_t> Plateaus::texels_looked_up(const View& view) const {
    const std::size_t layer = static_cast<std::size_t>(layout_.width_px) * layout_.height_px;
    std::vector<std::uint16_t> wanted(layer * layout_.blocks.size(), 0);
    constexpr double kRounding = 0.05;  // of the shader's texel coordinates, and more
    for (std::size_t i = 0; i < view.size(); ++i) {
        const std::size_t p = layout_.receivers.plane_of_pixel[i];
        if (p >= layout_.blocks.size()) {
            continue;
        }
        const PlanarReceiver& plane = layout_.receivers.planes[p];
        const gpu::PlateauPlane& block = layout_.blocks[p];
        const glm::dvec3 offset = view.eye_ws + glm::dvec3{view.position_cr[i]} - plane.origin_ws;
        const glm::dvec2 at{glm::dot(offset, plane.axis_x), glm::dot(offset, plane.axis_y)};
        const glm::dvec2 texel = (at - glm::dvec2{block.window}) / static_cast<double>(block.window.z) - 0.5;
        const glm::ivec2 last = glm::ivec2{block.size} - 1;
        const glm::ivec2 low = glm::clamp(glm::ivec2{glm::floor(texel - kRounding)}, glm::ivec2{0}, last);
        const glm::ivec2 high = glm::clamp(glm::ivec2{glm::floor(texel + kRounding)} + 1, glm::ivec2{0}, last);
        for (int y = low.y; y <= high.y; ++y) {
            std::uint16_t* row = wanted.data() + p * layer + static_cast<std::size_t>(y) * layout_.width_px;
            std::fill(row + low.x, row + high.x + 1, std::uint16_t{0xffff});
        }
    }
    return wanted;
}

void Plateaus::draw_umbra(Frame& frame, std::size_t plane, bool whole) {
    RenderTarget& target = umbra_targets_[plane];
    target.bind();
    const glm::ivec4 size = layout_.blocks[plane].size;
    glViewport(0, 0, size.x, size.y);
    glEnable(GL_SCISSOR_TEST);
    glScissor(0, 0, size.x, size.y);
    glDisable(GL_BLEND);
    glClipControl(GL_LOWER_LEFT, GL_ZERO_TO_ONE);
    glDisable(GL_DEPTH_TEST);
    glDepthMask(GL_FALSE);
    if (store_ == Store::Depth || skip_depth_) {
        glEnable(GL_DEPTH_TEST);
        glDepthMask(GL_TRUE);
        glDepthFunc(store_ == Store::Depth ? GL_LESS : GL_ALWAYS);
        if (wanted_ && !whole) {  // depth 0 already where no pixel looks, so that no slope is computed there
            glCopyImageSubData(wanted_.name(), GL_TEXTURE_2D_ARRAY, 0, 0, 0, static_cast<GLint>(plane),
                               skip_depth_.name(), GL_TEXTURE_2D, 0, 0, 0, 0, size.x, size.y, 1);
        } else {
            target.clear_depth(1.0F);
        }
    }
    if (store_ != Store::Depth) {
        target.clear_colour(0, glm::vec4{1.0F});
        if (both_sides_) {
            target.clear_colour(1, glm::vec4{1.0F});
        }
        glDepthMask(skips_umbra() ? GL_TRUE : GL_FALSE);  // else slopes are wanted under the umbra
    }
    const Program& program =
        frame.device().programs.get({"techniques/plateaus/umbra.vert", "techniques/plateaus/umbra.frag"},
                                    {{"GAUGE", "0"},
                                     {"FRAME", "0"},
                                     {"UMBRA_COPY", both_sides_ ? "1" : "0"},
                                     {"STORE_DEPTH", store_ == Store::Depth ? "1" : "0"}});
    program.set("plane_index", static_cast<int>(plane));
    if (store_ == Store::Depth) {
        program.set("hither_yon", hither_yon_);
    }
    instances_.bind_storage(0);
    bind_block();
    program.use();
    glEnable(GL_CLIP_DISTANCE0);
    glEnable(GL_CLIP_DISTANCE1);
    frame.gpu_scene().draw(casters_onto(frame.summary(), layout_, plane), Cull::None);
    glDisable(GL_CLIP_DISTANCE0);
    glDisable(GL_CLIP_DISTANCE1);
    glDisable(GL_SCISSOR_TEST);
}

void Plateaus::find_covered(Frame& frame, std::size_t plane, bool whole) {
    const glm::ivec2 size{layout_.blocks[plane].size};
    const bool wanted = wanted_ && !whole;
    const bool skipped = skips_umbra() && skip_depth_;  // it holds both: umbra, and what nobody looks up
    bind_block();
    for (int level = 0; level < kLevels; level += 2) {
        const Program& program =
            frame.device().programs.get({"techniques/plateaus/covered.comp"}, {{"LEVEL", std::to_string(level)},
                                                                               {"SKIPPED", skipped ? "1" : "0"},
                                                                               {"WANTED", wanted ? "1" : "0"},
                                                                               {"SIDES", both_sides_ ? "2" : "1"}});
        // Whole cells of the coarsest level, so that each level finds all cells of the one below.
        const glm::ivec2 cells = ((size + 63) / 64) << (4 - level);
        program.set("plane_index", static_cast<int>(plane));
        program.set("cells", cells);
        if (level == 0 && skipped) {
            skip_depth_.bind(4);
        } else if (level == 0) {
            slopes_.bind(4);
            if (wanted) {
                wanted_.bind(6);
            }
        } else {
            covered_.bind(4);
        }
        covered_.bind_image(0, GL_WRITE_ONLY, level);
        program.use();
        const auto groups = (glm::uvec2{cells} + 7U) / 8U;
        glDispatchCompute(groups.x, groups.y, 1);
        StorageBuffer::barrier();
    }
}

bool Plateaus::cuts_to_tiles(const LightSummary& summary, const Layout& layout) const noexcept {
    return !summary.keeps("slope-never-darkest") && sheets_ == Sheets::Envelope && !slopes_off_planes(layout);
}

void Plateaus::sift(Frame& frame, std::size_t plane, bool keep_all, bool tiles) {
    const std::vector<Draw> all = draws();
    gpu::PlaneDraws counts{};
    glm::ivec3 per_edge{0};
    for (std::size_t i = 0; i < all.size(); ++i) {
        per_edge[static_cast<int>(i)] = all[i].per_edge;
    }
    for (gpu::PlateauDraw& draw : counts.draws) {
        draw.instance_count = 1;
    }
    counts.wide.instance_count = 1;
    draws_.upload(std::span<const gpu::PlaneDraws>{&counts, 1}, plane);
    const bool fans = fans_ || edges_ != EdgeChoice::Silhouettes;
    const bool hull = sheets_ == Sheets::Tessellated || !draws_tight();
    const char* cones = sheets_ == Sheets::Envelope ? (hull ? "0" : "1") : (fans ? "2" : "1");
    silhouettes_.bind(0);
    bind_block();
    listed_.bind_storage(5);
    draws_.bind_storage(6);
    if (!keep_all) {
        covered_.bind(4);
    }
    if (tiles) {
        const glm::ivec2 across =
            (glm::ivec2{layout_.blocks[plane].size} + PENUMBRA_PLATEAU_TILE - 1) / PENUMBRA_PLATEAU_TILE;
        const std::vector<float> lit(static_cast<std::size_t>(across.x) * across.y, 1.0F);
        darkness_.replace(std::span<const float>{lit});
        darkness_.bind_storage(7);
    }
    glEnable(GL_RASTERIZER_DISCARD);
    for (const SiftPass pass : {SiftPass::All, SiftPass::Bound, SiftPass::Cut}) {
        const bool wide = pass != SiftPass::All;
        if ((wide && !tiles) || (pass == SiftPass::Bound && keep_all)) {
            continue;
        }
        Defines more = defines(plane);
        more.insert(more.end(), {{"HULL", hull ? "1" : "0"},
                                 {"CONES", cones},
                                 {"SHEET", sheets_ == Sheets::Envelope ? "0" : "1"},
                                 {"KEEP_ALL", keep_all ? "1" : "0"},
                                 {"TILES", tiles ? "1" : "0"},
                                 {"PASS", std::to_string(static_cast<int>(pass))}});
        const Program& program =
            frame.device().programs.get({"techniques/plateaus/sift.vert", "techniques/plateaus/nothing.frag"}, more);
        program.set("plane_index", static_cast<int>(plane));
        if (pass != SiftPass::Bound) {
            program.set("vertices_per_edge", per_edge);
        }
        if (tiles) {
            program.set("first_wide_entry", static_cast<unsigned>(first_wide()));
        }
        if (pass == SiftPass::Cut) {
            program.set("first_tile_entry", static_cast<unsigned>(first_piece()));
            program.set("most_tile_entries", static_cast<unsigned>(kMostPieces));
        }
        program.use();
        if (wide) {
            glBindVertexArray(no_attributes_.name());
            glBindBuffer(GL_DRAW_INDIRECT_BUFFER, draws_.name());
            glDrawArraysIndirect(GL_POINTS,
                                 buffer_offset(plane * sizeof(gpu::PlaneDraws) + offsetof(gpu::PlaneDraws, wide)));
            glBindVertexArray(0);
        } else {
            silhouettes_.draw(frame, GL_POINTS, 1);
        }
        StorageBuffer::barrier();
    }
    glDisable(GL_RASTERIZER_DISCARD);
}

std::uint64_t Plateaus::first_piece() const noexcept {
    return std::max<std::uint64_t>(1, silhouettes_.capacity());
}

std::uint64_t Plateaus::first_wide() const noexcept {
    return first_piece() + kMostPieces;
}

void Plateaus::send_mail(Frame& frame) {
    const std::vector<std::uint32_t> nobody(mailboxes_.bytes() / sizeof(std::uint32_t), 0xffffffffU);
    mailboxes_.upload(std::span<const std::uint32_t>{nobody});
    const Program& program =
        frame.device().programs.get({"techniques/plateaus/mailbox.vert", "techniques/plateaus/umbra.frag"},
                                    {{"UMBRA_COPY", "0"}, {"STORE_DEPTH", "0"}});
    silhouettes_.bind(0);
    mailboxes_.bind_storage(3);
    first_box_.bind_storage(4);
    program.use();
    glEnable(GL_RASTERIZER_DISCARD);
    silhouettes_.draw(frame, GL_POINTS, 1);
    glDisable(GL_RASTERIZER_DISCARD);
    StorageBuffer::barrier();
}

bool Plateaus::draws_tight() const noexcept {
    // Around an outline a penumbra lies in the sheets of its edges and the sectors of its corners. Without corners, and
    // on the inner side, it takes all that the light's image sweeps.
    return sheets_ != Sheets::Envelope || (edges_ == EdgeChoice::Silhouettes && !both_sides_);
}

std::vector<Plateaus::Draw> Plateaus::draws() const {
    const int count = cells_ > 0 ? cells_ : 32;
    const auto part = [&](int number, int sheet, int first, int per_edge, int rows = 0) {
        return Draw{{{"PART", std::to_string(number)},
                     {"SHEET", std::to_string(sheet)},
                     {"FIRST_VERTEX", std::to_string(first)},
                     {"CELLS", std::to_string(count)},
                     {"CELLS_BY_RULE", cells_ > 0 ? "0" : "1"},
                     {"SEGMENTS", std::to_string(segments_)},
                     {"MAILBOX", number == 3 ? "1" : "0"},
                     {"PER_EDGE", std::to_string(per_edge)}},
                    per_edge,
                    rows};
    };
    if (sheets_ == Sheets::Envelope) {
        return {draws_tight() ? part(0, 0, 0, 15) : part(1, 0, 0, 6)};
    }
    const bool fans = fans_ || edges_ != EdgeChoice::Silhouettes;
    std::vector<Draw> all;
    if (sheets_ == Sheets::Bilinear) {
        all.push_back(part(0, 1, 0, fans ? 6 : 15));
    } else {
        all.push_back(part(2, 1, 0, 6 * count, count));
        if (!fans) {
            all.push_back(part(0, 1, 6, 9));
        }
    }
    if (fans) {
        all.push_back(part(3, 1, 0, 3 * segments_));
    }
    return all;
}

void Plateaus::draw_primitives(Frame& frame, std::size_t plane) {
    const std::vector<Draw> all = draws();
    silhouettes_.bind(0);
    bind_block();
    listed_.bind_storage(5);
    mailboxes_.bind_storage(3);
    first_box_.bind_storage(4);
    for (std::size_t i = 0; i < 2 * all.size(); ++i) {
        const Draw& draw = all[i % all.size()];
        const bool pieces = i >= all.size();
        if (pieces && (!cuts_to_tiles_ || wireframe_)) {
            break;
        }
        Defines compiled = defines(plane);
        compiled.insert(compiled.end(), draw.defines.begin(), draw.defines.end());
        compiled.push_back({"TILED", pieces ? "1" : "0"});
        if (wireframe_) {
            compiled.push_back({"HIDDEN", show_hidden_ ? "1" : "0"});
        }
        const Program& program = frame.device().programs.get(
            {"techniques/plateaus/slopes.vert",
             wireframe_ ? "techniques/plateaus/wireframe.frag" : "techniques/plateaus/slopes.frag"},
            compiled);
        program.set("plane_index", static_cast<int>(plane));
        program.set("first_entry", static_cast<unsigned>(pieces ? first_piece() : 0));
        if (store_ == Store::Depth && !wireframe_) {
            program.set("hither_yon", hither_yon_);
        }
        glBindVertexArray(no_attributes_.name());
        glBindBuffer(GL_DRAW_INDIRECT_BUFFER, draws_.name());
        const std::size_t command = plane * sizeof(gpu::PlaneDraws) + offsetof(gpu::PlaneDraws, draws) +
                                    ((pieces ? 3 : 0) + i % all.size()) * sizeof(gpu::PlateauDraw);
        for (GLenum k = 0; pieces && k < 4; ++k) {
            glEnable(GL_CLIP_DISTANCE0 + k);
        }
        for (int row = 0; row < std::max(1, draw.rows); ++row) {
            if (draw.rows > 0) {
                program.set("row", row);
            }
            program.use();
            glDrawArraysIndirect(GL_TRIANGLES, buffer_offset(command));
        }
        glBindVertexArray(0);
        for (GLenum k = 0; pieces && k < 4; ++k) {
            glDisable(GL_CLIP_DISTANCE0 + k);
        }
    }
}

void Plateaus::draw_slopes(Frame& frame, std::size_t plane) {
    RenderTarget& target = slope_targets_[plane];
    target.bind();
    const glm::ivec4 size = layout_.blocks[plane].size;
    glViewport(0, 0, size.x, size.y);
    if (store_ == Store::Depth) {
        glEnable(GL_DEPTH_TEST);
        glDepthMask(GL_TRUE);
        glDepthFunc(GL_LESS);
    } else {
        if (skip_depth_) {
            glEnable(GL_DEPTH_TEST);
            glDepthFunc(GL_LESS);
        } else {
            glDisable(GL_DEPTH_TEST);
        }
        glDepthMask(GL_FALSE);
        glEnable(GL_BLEND);
        glBlendEquation(GL_MIN);
        glBlendFunc(GL_ONE, GL_ONE);
    }
    if (darkest_) {
        glEnable(GL_SCISSOR_TEST);
        glScissor(0, 0, size.x, size.y);
        target.clear_colour(1, glm::vec4{static_cast<float>(kNothingDarkest)});
        glDisable(GL_SCISSOR_TEST);
    }
    if (both_sides_) {
        umbra_.bind(2);
    }
    glDisable(GL_CULL_FACE);
    draw_primitives(frame, plane);
    glDisable(GL_BLEND);
    glBlendEquation(GL_FUNC_ADD);
    glDisable(GL_DEPTH_TEST);
    glDepthMask(GL_FALSE);
}

void Plateaus::update(Frame& frame) {
    if (!frame.plan().runs("lookup")) {
        return;
    }
    if (layout_.map) {
        map_.update(frame);
    }
    frame.step("silhouettes", [&] {
        const Light& light = frame.light();
        silhouettes_.extract(
            frame,
            light.kind == LightKind::Sun ? glm::dvec4{-light.direction_ws, 0.0} : glm::dvec4{light.position_ws, 1.0},
            layout_.origin_ws);
        if (mailboxes_.bytes() > sizeof(std::uint32_t)) {
            send_mail(frame);
        }
        // Whole records, pieces, and the wide records that pieces are cut from.
        const std::uint64_t all = first_piece();
        const std::size_t bytes = (cuts_to_tiles_ ? first_wide() + all : all) * sizeof(glm::uvec2);
        if (listed_.bytes() < bytes) {
            listed_ = StorageBuffer(bytes, "silhouettes of a plane");
        }
    });
    if (!frame.plan().runs("silhouettes")) {
        return;
    }
    const auto placed = frame.gpu_scene().relative_to(layout_.origin_ws);
    instances_.replace(std::span<const gpu::InstanceBlock>{placed});
    for (std::size_t p = 0; p < layout_.blocks.size(); ++p) {
        frame.step(step_of(layout_, p), [&] { draw_plane(frame, p, false); });
    }
    drawn_whole_ = !wanted_;
}

void Plateaus::draw_plane(Frame& frame, std::size_t plane, bool whole) {
    draw_umbra(frame, plane, whole);
    if (sifts_) {
        find_covered(frame, plane, whole);
    }
    sift(frame, plane, !sifts_, cuts_to_tiles_);
    draw_slopes(frame, plane);
}

void Plateaus::resolve(Frame& frame) {
    frame.step("lookup", [&] {
        const Program& program = lookup(frame);
        if (layout_.map) {
            map_.bind(program);
        }
        program.set("dark", static_cast<float>(dark_));
        program.set("hither_yon", hither_yon_);
        bind_block();
        plane_of_pixel_.bind(4);
        if (slopes_) {
            slopes_.bind(5);
        }
        if (darkest_) {
            darkest_.bind(6);
        }
        frame.resolve_with(program);
    });
}

std::vector<Statistic> Plateaus::statistics(Frame& frame) {
    if (!frame.plan().runs("silhouettes")) {
        return {};
    }
    double all = 0.0;
    double hidden = 0.0;
    double pieces = 0.0;
    for (const gpu::PlaneDraws& plane : draws_.read<gpu::PlaneDraws>()) {
        all += plane.in_window;
        hidden += plane.hidden;
        pieces += std::min<double>(plane.tiles, static_cast<double>(kMostPieces));
    }
    return {{"silhouettes", "Silhouettes whose slopes meet a plane's window", "edges, plane by plane", all},
            {"hidden_silhouettes", "Of these left out, for they change nothing", "edges, plane by plane", hidden},
            {"slope_pieces", "Pieces that wide slopes were cut to", "tiles, edge by edge", pieces}};
}

std::size_t Plateaus::memory_bytes() const noexcept {
    std::size_t bytes = map_.bytes() + silhouettes_.bytes() + mailboxes_.bytes() + first_box_.bytes() +
                        listed_.bytes() + draws_.bytes() + darkness_.bytes();
    for (const TextureImage* texture :
         {&slopes_, &umbra_, &skip_depth_, &covered_, &wanted_, &darkest_, &plane_of_pixel_}) {
        bytes += *texture ? texture->bytes() : 0;
    }
    return bytes;
}

std::vector<DebugView> Plateaus::debug_views(const Plan& plan) const {
    std::vector<DebugView> views;
    if (plan.runs("silhouettes")) {
        views.push_back({"silhouettes", "Silhouettes as the light's centre sees them"});
        views.push_back({"plateaus", "Plateaus: the texture of each plane"});
        views.push_back({"primitives", "Sheets and cones as triangles over the first plane's texture"});
        views.push_back({"planes", "Receiver planes found in the view"});
    }
    return views;
}

DebugImage Plateaus::debug_image(Frame& frame, std::string_view id) {
    if (id == "silhouettes") {
        return view_picture(
            frame, "Edges where light-facing and averted triangles meet: slopes grow from them.",
            [&](RenderTarget& target) {
                draw_silhouettes_in_view(frame, target, silhouettes_, layout_.origin_ws, {1.0F, 0.6F, 0.1F});
            });
    }
    if (id == "planes") {
        return planes_picture(frame.view(), layout_.receivers);
    }
    if (id == "primitives") {
        return primitives_picture(frame);
    }
    const std::vector<BakedTexture> textures = bake(frame);
    return side_by_side(textures, "V on each plane, largest first; black is the hard shadow, its rim the slopes.");
}

DebugImage Plateaus::primitives_picture(Frame& frame) {
    if (layout_.blocks.empty()) {
        return {};
    }
    std::vector<BakedTexture> textures = bake(frame);
    textures.resize(1);
    DebugImage image = side_by_side(textures, "");
    const glm::ivec4 size = layout_.blocks[0].size;
    const TextureImage colour = TextureImage::make_2d(GL_RGBA32F, size.x, size.y, "picture of sheets and cones");
    RenderTarget target{"picture of sheets and cones"};
    target.attach_colour(0, colour);
    // What was left out first, then what was drawn over it. The counts are those of the frame, not of the whole
    // texture, so the umbra is drawn once more as for that.
    draw_umbra(frame, 0, false);
    if (sifts_) {
        find_covered(frame, 0, false);
    }
    target.bind();
    target.clear_colour(0, glm::vec4{0.0F});
    wireframe_ = true;
    for (const bool hidden_ones : {true, false}) {
        sift(frame, 0, hidden_ones || !sifts_, false);
        target.bind();
        glDisable(GL_DEPTH_TEST);
        glDisable(GL_BLEND);
        glPolygonMode(GL_FRONT_AND_BACK, GL_LINE);
        show_hidden_ = hidden_ones && sifts_;
        draw_primitives(frame, 0);
        glPolygonMode(GL_FRONT_AND_BACK, GL_FILL);
    }
    wireframe_ = false;
    show_hidden_ = false;
    const gpu::PlaneDraws counts = draws_.read<gpu::PlaneDraws>()[0];
    sift(frame, 0, !sifts_, cuts_to_tiles_);
    draw_slopes(frame, 0);
    drawn_whole_ = drawn_whole_ && !wanted_;
    const std::vector<glm::vec4> lines = colour.read<glm::vec4>();
    for (std::size_t i = 0; i < lines.size() && i < image.rgb.size(); ++i) {
        image.rgb[i] = lines[i].w > 0.0F ? glm::vec3{lines[i]} : 0.75F * image.rgb[i];
    }
    image.caption = "Triangles of the slopes over the first plane's texture: sheets blue, cones orange; red: " +
                    std::to_string(counts.hidden) + " of " + std::to_string(counts.in_window) +
                    " silhouettes were left out, under the umbra or where no pixel looks.";
    return image;
}

std::vector<BakedTexture> Plateaus::bake(Frame& frame) {
    std::vector<BakedTexture> textures;
    if (!frame.plan().runs("silhouettes")) {
        return textures;
    }
    for (std::size_t p = 0; p < layout_.blocks.size() && !drawn_whole_; ++p) {
        draw_plane(frame, p, true);
    }
    drawn_whole_ = true;
    const std::vector<float> all = slopes_.read<float>();
    const std::size_t layer = static_cast<std::size_t>(layout_.width_px) * layout_.height_px;
    for (std::size_t p = 0; p < layout_.blocks.size(); ++p) {
        const PlanarReceiver& plane = layout_.receivers.planes[p];
        const gpu::PlateauPlane& block = layout_.blocks[p];
        BakedTexture& texture = textures.emplace_back();
        texture.name = plane.name;
        texture.width_px = block.size.x;
        texture.height_px = block.size.y;
        for (int y = 0; y < block.size.y; ++y) {
            for (int x = 0; x < block.size.x; ++x) {
                double v = all[p * layer + static_cast<std::size_t>(y) * layout_.width_px + x];
                if (store_ == Store::Depth) {
                    v = (v - hither_yon_.x) / static_cast<double>(hither_yon_.y - hither_yon_.x);
                }
                v = std::min(std::abs(v), 1.0);
                v = both_sides_ ? v : plateau::falloff(static_cast<plateau::Falloff>(falloff_), v);
                texture.visibility.push_back(static_cast<float>(dark_ + (1.0 - dark_) * v));
            }
        }
        const glm::dvec2 low{block.window};
        const glm::dvec2 high = low + static_cast<double>(block.window.z) * glm::dvec2{block.size};
        const std::array<glm::dvec2, 4> uv{low, {high.x, low.y}, high, {low.x, high.y}};
        for (std::size_t c = 0; c < 4; ++c) {
            texture.corners_ws[c] = plane.origin_ws + uv[c].x * plane.axis_x + uv[c].y * plane.axis_y;
        }
    }
    return textures;
}

}  // namespace penumbra
