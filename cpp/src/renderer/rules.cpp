#include "penumbra/plan.h"

namespace penumbra {

const std::vector<RuleInfo>& rules() {
    static const std::vector<RuleInfo> table{
        {"light-without-pixels", "no visible receiver lies where the light shines", 0.0},
        {"light-without-shadow", "shadows are switched off for the light, so V is 1", 0.0},
        {"light-without-casters", "no caster lies between the light and a visible receiver, so V is 1", 0.0},
        {"light-without-extent", "all points of the light coincide, so one sample is all samples", 0.0},
        {"caster-outside-hull",
         "a separating plane keeps the caster apart from the hull of light and visible receivers", 0.0},
        {"cube-face-without-receivers", "no visible receiver projects into the face of the light's cube", 0.0},
        {"every-receiver-casts",
         "every visible receiver casts, so the depth map of casters serves as that of receivers", 0.0},
        {"penumbra-under-half-a-texel",
         "every penumbra is narrower than half a texel of the map, and narrower ones are never drawn", 0.0},
        {"skin-under-threshold", "no skin can be as long as the shortest that is drawn, whatever the depth maps hold",
         0.0},
        {"every-receiver-on-a-plane", "every visible receiver lies on a plane with a texture of its own", 0.0},
        {"silhouette-under-umbra", "all texels that an edge's slopes reach are black already, or looked up by no pixel",
         0.0},
        {"slope-never-darkest",
         "all over a tile of the texture another edge's slope is darker, or the edge's own is white", 0.0},
        {"texel-without-pixel", "no pixel of the view looks the texel up", 0.0},
        {"eye-outside-volume",
         "a separating plane keeps the caster apart from the hull of light, eye and near rectangle, so that its volume "
         "is counted in front of what is seen and needs no caps",
         0.0},
        {"device-without-depth-bounds", "the device has no GL_EXT_depth_bounds_test, so the stencil bit masks as well",
         0.0},
        {"smoothie-without-width", "t is 0, so that smoothies cover no texel", 0.0},
        {"kernel-on-one-side",
         "the nearest and the farthest depth under the kernel lie on one side of the receiver, so all comparisons "
         "agree",
         0.0},
        {"mask-without-penumbra", "the light has no extent, so that no pixel lies in a penumbra to be masked", 0.0},
        {"pixel-outside-mask", "the pixel sees no surface, or one that faces away from the whole light", 0.0},
        {"reference-pixel-decided",
         "the reference's pilot rays of a pixel and its neighbours show no penumbra, so it gets the least number of "
         "rays "
         "that its standard error allows (tolerance: that error, 0.002 unless asked otherwise)",
         0.002},
    };
    return table;
}

}  // namespace penumbra
