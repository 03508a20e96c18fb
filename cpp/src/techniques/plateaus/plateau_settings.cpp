// What `plateaus` can be told, and what it makes of it.
#include <algorithm>

#include "penumbra/error.h"
#include "scene/setting_forms.h"
#include "techniques/all_lights.h"
#include "techniques/plateaus/plateaus.h"

namespace penumbra {

namespace {

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

}  // namespace penumbra
