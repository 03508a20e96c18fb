// Hard shadow map [Williams1978]: one comparison with the nearest texel.
#include "lib/map_lookup.glsl"
#include "lib/bias.glsl"

layout(binding = 0) uniform sampler2D position_texture;
layout(binding = 1) uniform sampler2D normal_texture;
layout(binding = 2) uniform sampler2DArray depth_map;
#ifdef MIDPOINT
layout(binding = 3) uniform sampler2DArray second_map;
#endif
uniform int facing_test;

layout(location = 0) out float visibility;

void main() {
    ivec2 pixel = ivec2(gl_FragCoord.xy);
    vec4 position = texelFetch(position_texture, pixel, 0);
    visibility = 1.0;
    if (position.w == 0.0) {
        return;
    }
    vec3 n_ws = texelFetch(normal_texture, pixel, 0).xyz;
    if (facing_test != 0 && dot(n_ws, to_light(position.xyz)) <= 0.0) {
        visibility = 0.0;
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
    float stored = texelFetch(depth_map, ivec3(texel, at.face), 0).r;
#ifdef MIDPOINT
    // Compared half-way between the first two layers; a surface with nothing behind it is the last one and lit.
    float second = texelFetch(second_map, ivec3(texel, at.face), 0).r;
    if (second <= 0.0) {
        return;
    }
    float middle = 0.5 * (linear_depth(at.face, stored) + linear_depth(at.face, second));
    visibility = z_ls <= middle ? 1.0 : 0.0;
#else
    visibility = window_depth(at.face, z_ls) >= stored ? 1.0 : 0.0;
#endif
}
