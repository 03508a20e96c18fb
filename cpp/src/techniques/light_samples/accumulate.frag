// One sample point of the light [HeckbertHerf1997]: its hard shadow, weighted, is added to the sum by blending.
#include "lib/map_lookup.glsl"
#include "lib/bias.glsl"

layout(binding = 0) uniform sampler2D position_texture;
layout(binding = 1) uniform sampler2D normal_texture;
layout(binding = 2) uniform sampler2DArray depth_map;
uniform int first_layer;
#if SPHERE
// A sphere is sampled all over; a sample counts by the solid angle that its patch subtends at the receiver.
uniform vec3 sphere_normal_ws;
uniform float sphere_radius_m;
#endif

layout(location = 0) out vec2 sums;  // x weighted visibility, y weight

void main() {
    ivec2 pixel = ivec2(gl_FragCoord.xy);
    vec4 position = texelFetch(position_texture, pixel, 0);
    vec3 n_ws = texelFetch(normal_texture, pixel, 0).xyz;
    float weight = 1.0;
#if SPHERE
    // The distance is measured in radii, so that no scale of the scene leaves float32's range.
    vec3 l = to_light(position.xyz) / sphere_radius_m;
    float distance_squared = dot(l, l);
    weight = max(0.0, -dot(sphere_normal_ws, l)) / max(distance_squared * sqrt(distance_squared), 1e-30);
#endif
    MapPoint at = find_biased(position.xyz, n_ws);
    bool outside = at.face < 0;
    int face = max(at.face, 0);
    ivec2 texel = clamp(ivec2(at.texel), ivec2(0), ivec2(map.counts.y - 1));
    float z_ls = at.z_ls - depth_bias(at, 0.5) + plane_offset(at, vec2(texel) + 0.5 - at.texel);
    float stored = texelFetch(depth_map, ivec3(texel, first_layer + face), 0).r;
    bool dark = !outside && window_depth(face, z_ls) < stored;
#if FACING_TEST
    dark = dark || at.towards_m <= 0.0;
#endif
    weight = position.w != 0.0 ? weight : 1.0;
    sums = vec2(position.w != 0.0 && dark ? 0.0 : weight, weight);
}
