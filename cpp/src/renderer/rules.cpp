#include <algorithm>

#include "penumbra/error.h"
#include "penumbra/plan.h"
#include "penumbra/technique.h"

namespace penumbra {

const std::vector<RuleInfo>& rules() {
    static const std::vector<std::string> every = [] {
        std::vector<std::string> ids;
        for (const TechniqueInfo& info : techniques()) {
            ids.push_back(info.id);
        }
        return ids;
    }();
    // A rule added here must be proved in tests/cpp/techniques/rules_gl_test.cpp, which looks for it.
    static const std::vector<RuleInfo> table{
        {"instance-without-effect",
         "the instance is not seen by the camera and casts no shadow, and no other instance of its mesh is "
         "or does",
         0.0, RuleStage::Export, every},
        {"frame-unchanged",
         "the view's surfaces, the light, the casters in reach, the visible receivers and the settings are "
         "those of a frame whose V is kept",
         0.0, RuleStage::Frame, every},
        {"light-without-pixels", "no visible receiver lies where the light shines", 0.0, RuleStage::Frame, every},
        {"light-without-shadow", "shadows are switched off for the light, so V is 1", 0.0, RuleStage::Frame, every},
        {"light-without-casters", "no caster lies between the light and a visible receiver, so V is 1", 0.0,
         RuleStage::Frame, every},
        {"light-without-extent",
         "all points of the light coincide, so one sample is all samples and every penumbra has the width "
         "0",
         0.0,
         RuleStage::LightSpace,
         {"smoothies", "penumbra_maps", "plateaus", "linear_light_maps", "light_samples", "ray_traced"}},
        {"caster-outside-hull",
         "a separating plane keeps the caster apart from the hull of light and visible receivers, and from what is "
         "looked "
         "up beside them on a map",
         0.0,
         RuleStage::LightSpace,
         {"shadow_map", "shadow_volume", "hybrid", "pcf", "smoothies", "penumbra_maps", "plateaus", "linear_light_maps",
          "light_samples", "masked_rays"}},
        {"caster-outside-face",
         "the caster lies beside the map, or beyond all visible receivers in it",
         0.0,
         RuleStage::LightSpace,
         {"shadow_map", "hybrid", "pcf", "smoothies", "penumbra_maps", "plateaus", "linear_light_maps",
          "light_samples"}},
        {"cube-face-without-receivers",
         "no visible receiver projects into the face of the light's cube",
         0.0,
         RuleStage::LightSpace,
         {"shadow_map", "hybrid", "pcf", "smoothies", "penumbra_maps", "plateaus", "linear_light_maps"}},
        {"every-receiver-casts",
         "every visible receiver casts, so the depth map of casters serves as that of receivers",
         0.0,
         RuleStage::LightSpace,
         {"smoothies", "penumbra_maps", "linear_light_maps"}},
        {"penumbra-under-half-a-texel",
         "every penumbra is narrower than half a texel of the map, and narrower ones are never drawn",
         0.0,
         RuleStage::LightSpace,
         {"penumbra_maps", "plateaus"}},
        {"skin-under-threshold",
         "no skin can be as long as the shortest that is drawn, whatever the depth maps hold",
         0.0,
         RuleStage::LightSpace,
         {"linear_light_maps"}},
        {"every-receiver-on-a-plane",
         "every visible receiver lies on a plane with a texture of its own",
         0.0,
         RuleStage::LightSpace,
         {"plateaus"}},
        {"silhouette-under-umbra",
         "all texels that an edge's slopes reach are black already, or looked up by no pixel",
         0.0,
         RuleStage::LightSpace,
         {"plateaus"}},
        {"slope-never-darkest",
         "all over a tile of the texture another edge's slope is darker, or the edge's own is white",
         0.0,
         RuleStage::LightSpace,
         {"plateaus"}},
        {"texel-without-pixel", "no pixel of the view looks the texel up", 0.0, RuleStage::LightSpace, {"plateaus"}},
        {"eye-outside-volume",
         "a separating plane keeps the caster apart from the hull of light, eye and near rectangle, so "
         "that its volume is counted in front of what is seen and needs no caps",
         0.0,
         RuleStage::ViewSpace,
         {"shadow_volume", "hybrid"}},
        {"device-without-depth-bounds",
         "the device has no GL_EXT_depth_bounds_test, so the stencil bit masks as well",
         0.0,
         RuleStage::ViewSpace,
         {"hybrid"}},
        {"smoothie-without-width",
         "t is 0, so that smoothies cover no texel",
         0.0,
         RuleStage::LightSpace,
         {"smoothies"}},
        {"kernel-on-one-side",
         "the nearest and the farthest depth under the kernel lie on one side of the receiver, so all "
         "comparisons agree",
         0.0,
         RuleStage::ViewSpace,
         {"pcf"}},
        {"mask-without-penumbra",
         "the light has no extent, so that no pixel lies in a penumbra to be masked",
         0.0,
         RuleStage::LightSpace,
         {"light_samples", "masked_rays"}},
        {"pixel-outside-mask",
         "the pixel sees no surface, or one that faces away from the whole light; on the device: all pixels of a tile "
         "of 16 x 16",
         0.0, RuleStage::ViewSpace, every},
        {"reference-pixel-decided",
         "the reference's pilot rays of a pixel and its neighbours show no penumbra, so it gets the least "
         "number of rays that its standard error allows (tolerance: that error, 0.002 unless asked "
         "otherwise)",
         0.002,
         RuleStage::Reference,
         {}},
    };
    return table;
}

Keep::Keep(bool every, std::vector<std::string> ids) : everything{every}, rules{std::move(ids)} {
    everything = everything || std::ranges::find(rules, "all") != rules.end();
    std::erase(rules, "all");
    std::ranges::sort(rules);
    for (const std::string& id : rules) {
        if (!std::ranges::any_of(penumbra::rules(), [&](const RuleInfo& rule) { return rule.id == id; })) {
            throw InvalidSettings("there is no rule \"" + id + "\" to keep; penumbra techniques --rules lists them");
        }
    }
}

}  // namespace penumbra
