// Receivers in none of a rod's windows: the hard shadow of one sample, with its weight, as light_samples has it.
#include "lib/map_lookup.glsl"
#include "lib/bias.glsl"
#include "lib/receiver.glsl"
#include "techniques/linear_light_maps/linear_windows.glsl"

layout(binding = 0) uniform usampler2D receivers;
layout(binding = 2) uniform sampler2DArray depth_map;

uniform int first_layer;
uniform vec3 rod_centre_cr;
uniform float weight;

layout(location = 0) out vec2 sums;  // x weighted visibility, y weight

void main() {
    Receiver receiver = read_receiver(receivers, ivec2(gl_FragCoord.xy));
    MapPoint at = find_biased(receiver.position_cr, receiver.normal_ws);
    bool outside = at.face < 0;
    int face = max(at.face, 0);
    ivec2 texel = clamp(ivec2(at.texel), ivec2(0), ivec2(map.counts.y - 1));
    float z_ls = at.z_ls - depth_bias(at, 0.5) + plane_offset(at, vec2(texel) + 0.5 - at.texel);
    float stored = texelFetch(depth_map, ivec3(texel, first_layer + face), 0).r;
    bool dark = !outside && window_depth(face, z_ls) < stored;
#if FACING_TEST
    dark = dark || at.towards_m <= 0.0;
#endif
    bool mine = receiver.seen && find_window(receiver.position_cr - rod_centre_cr) < 0;
    sums = mine ? vec2(dark ? 0.0 : weight, weight) : vec2(0.0);
}
