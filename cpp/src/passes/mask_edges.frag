// The nearest edge of each texel, by maximum blending of w. An edge that the light's centre cannot see is left out: one
// that hides it is nearer, and serves in its place (decision 0011). It counts as hidden only if all nine texels around
// hold something nearer, by more than they differ among themselves: at the bottom of a fold all are nearer too.
#include "lib/map_lookup.glsl"
#include "lib/mask_space.glsl"

layout(binding = 2) uniform sampler2DArray depth_map;
uniform int face_index;

in float w_near;
flat in float w_most;
flat in float looked_up;
layout(location = 0) out float nearest;

void main() {
    float w = min(w_near, w_most);
    ivec2 texel = ivec2(gl_FragCoord.xy);
    float deepest = 1e30, highest = 0.0;
    for (int y = -1; y <= 1; ++y) {
        for (int x = -1; x <= 1; ++x) {
            ivec2 at = clamp(texel + ivec2(x, y), ivec2(0), ivec2(map.counts.y - 1));
            float stored = texelFetch(depth_map, ivec3(at, face_index), 0).r;
            deepest = min(deepest, stored);
            highest = max(highest, stored);
        }
    }
    float hiding = mask_w_from_stored(face_index, deepest);
    float differ = mask_w_from_stored(face_index, highest) - hiding;
    if (looked_up > 0.5 && hiding > w * (1.0 + 1e-4) + differ) {
        discard;
    }
    nearest = w;
}
