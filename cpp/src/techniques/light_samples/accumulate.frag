// One sample point of the light [HeckbertHerf1997]: its hard shadow, weighted, is added to the sum by blending.
#include "lib/map_lookup.glsl"
#include "lib/bias.glsl"
#include "lib/receiver.glsl"

layout(binding = 0) uniform usampler2D receivers;
layout(binding = 2) uniform sampler2DArray depth_map;
uniform int first_layer;
#if SPHERE
// A sphere is sampled all over; a sample counts by the solid angle that its patch subtends at the receiver.
uniform vec3 sphere_normal_ws;
uniform float sphere_radius_m;
#endif

layout(location = 0) out vec2 sums;  // x weighted visibility, y weight

void main() {
    Receiver receiver = read_receiver(receivers, ivec2(gl_FragCoord.xy));
    float weight = 1.0;
#if SPHERE
    // The distance is measured in radii, so that no scale of the scene leaves float32's range.
    vec3 l = to_light(receiver.position_cr) / sphere_radius_m;
    float distance_squared = dot(l, l);
    weight = max(0.0, -dot(sphere_normal_ws, l)) / max(distance_squared * sqrt(distance_squared), 1e-30);
#endif
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
    weight = receiver.seen ? weight : 1.0;
    sums = vec2(receiver.seen && dark ? 0.0 : weight, weight);
}
