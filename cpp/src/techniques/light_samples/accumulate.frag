// One sample point of the light [HeckbertHerf1997]: its hard shadow, weighted, is added to the sum by blending.
#include "lib/map_lookup.glsl"
#include "lib/bias.glsl"

layout(binding = 0) uniform sampler2D position_texture;
layout(binding = 1) uniform sampler2D normal_texture;
layout(binding = 2) uniform sampler2DArray depth_map;
uniform int facing_test;
uniform int first_layer;
// A sphere is sampled all over; a sample counts by the solid angle that its patch subtends at the receiver.
uniform int sphere;
uniform vec3 sphere_normal_ws;

layout(location = 0) out vec2 sums;  // x weighted visibility, y weight

void main() {
    ivec2 pixel = ivec2(gl_FragCoord.xy);
    vec4 position = texelFetch(position_texture, pixel, 0);
    sums = vec2(1.0);
    if (position.w == 0.0) {
        return;
    }
    vec3 n_ws = texelFetch(normal_texture, pixel, 0).xyz;
    vec3 l = to_light(position.xyz);
    float weight = 1.0;
    if (sphere != 0) {
        float distance_squared = dot(l, l);
        weight = max(0.0, -dot(sphere_normal_ws, l)) / max(distance_squared * sqrt(distance_squared), 1e-30);
    }
    sums = vec2(weight);
    if (weight == 0.0) {
        return;
    }
    if (facing_test != 0 && dot(n_ws, l) <= 0.0) {
        sums.x = 0.0;
        return;
    }
    MapPoint at = find_in_map(position.xyz, n_ws);
    if (at.face < 0) {
        return;
    }
    if (bias_mode == BIAS_NORMAL_OFFSET) {
        MapPoint moved = find_in_map(offset_receiver(position.xyz, n_ws, at.texel_m), n_ws);
        if (moved.face >= 0) {
            at = moved;
        }
    }
    ivec2 texel = clamp(ivec2(floor(at.texel)), ivec2(0), ivec2(map.counts.y - 1));
    float z_ls = at.z_ls - depth_bias(at, 0.5) + plane_offset(at, vec2(texel) + 0.5 - at.texel);
    float stored = texelFetch(depth_map, ivec3(texel, first_layer + at.face), 0).r;
    sums.x = window_depth(at.face, z_ls) >= stored ? weight : 0.0;
}
