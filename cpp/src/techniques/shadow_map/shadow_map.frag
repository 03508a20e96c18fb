// Hard shadow map [Williams1978]: one comparison with the nearest texel.
#include "lib/map_lookup.glsl"
#include "lib/bias.glsl"
#include "lib/receiver.glsl"

layout(binding = 0) uniform usampler2D receivers;
layout(binding = 2) uniform sampler2DArray depth_map;
#if BIAS_MODE == 6
layout(binding = 3) uniform sampler2DArray second_map;
#endif

layout(location = 0) out float visibility;

void main() {
    Receiver receiver = read_receiver(receivers, ivec2(gl_FragCoord.xy));
    MapPoint at = find_biased(receiver.position_cr, receiver.normal_ws);
    // No early return: where pixels of one block part ways, a rasteriser on the CPU pays for both.
    bool outside = at.face < 0;
    ivec2 texel = clamp(ivec2(at.texel), ivec2(0), ivec2(map.counts.y - 1));
    int layer = max(at.face, 0);
    float z_ls = at.z_ls - depth_bias(at, 0.5) + plane_offset(at, vec2(texel) + 0.5 - at.texel);
    float stored = texelFetch(depth_map, ivec3(texel, layer), 0).r;
#if BIAS_MODE == 6
    // Compared half-way between the first two layers; a surface with nothing behind it is the last one and lit.
    float second = texelFetch(second_map, ivec3(texel, layer), 0).r;
    bool lit = second <= 0.0 || z_ls <= 0.5 * (linear_depth(layer, stored) + linear_depth(layer, second));
#else
    bool lit = window_depth(layer, z_ls) >= stored;
#endif
    bool dark = !outside && !lit;
#if FACING_TEST
    dark = dark || at.towards_m <= 0.0;
#endif
    visibility = receiver.seen && dark ? 0.0 : 1.0;
}
