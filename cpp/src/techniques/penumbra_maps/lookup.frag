// Hard shadow first, then what the penumbra map holds at the same texel [P 2.6].
// SIDES_BOTH: inside the hard shadow the light that passes the nearest edge. GATHER: four texels, each with its own
// comparison, blended bilinearly. PACKED: depth and penumbra in one texture. SOFT 0: no penumbra is wide enough for a map.
#include "lib/map_lookup.glsl"
#include "lib/bias.glsl"
#include "lib/receiver.glsl"

layout(binding = 0) uniform usampler2D receivers;
layout(binding = 2) uniform sampler2DArray depth_map;  // PACKED: both
#if BIAS_MODE == 6
layout(binding = 3) uniform sampler2DArray second_map;
#endif
#if SOFT && !PACKED
layout(binding = 4) uniform sampler2DArray penumbra_map;
#endif

#include "lib/hard_lookup.glsl"

#if SIDES_BOTH
#include "lib/map_space.glsl"
#include "lib/edge_space.glsl"
#include "lib/inner_edges.glsl"
#include "techniques/penumbra_maps/light_base.glsl"
#include "techniques/penumbra_maps/ramp.glsl"

// V past an edge with outer normal n, x > 0 outside it; lengths over the gap in w.
float seen_past(vec2 n, float x, float half_width) {
#if CONE_BASE == 1
    return light_fraction(n, x);
#endif
    x /= half_width;
#if FALLOFF == 2
    return disc_fraction(x);
#else
    float t = clamp(0.5 + 0.5 * x, 0.0, 1.0);
    return FALLOFF == 0 ? t * t * (3.0 - 2.0 * t) : t;
#endif
}

uniform int one;

float inside_shadow(HardLookup look) {
    InnerEdge edge = read_inner_edge(look);
    float gap = edge.w - w_from_depth(look.at.z_ls);
    bool found = edge.found && !too_close(edge.w, w_from_depth(look.at.z_ls));
    gap = found ? gap : 1.0;
#if CONE_BASE == 2
    float half_width =
        length(stretch(edge.normal, vec3(ip_from_texel(look.layer, look.at.texel), edge.w), false));
#else
    float half_width = CONE_BASE == 0 ? 1.0 : light_reach;
#endif
    float reach = gap * half_width;
    float open = open_beyond(edge, look, reach);
    float v = seen_past(edge.normal, -edge.distance / gap, half_width);
    if (open < reach) {
        v -= seen_past(edge.normal, -(edge.distance + open) / gap, half_width);
    }
    return found ? clamp(v, 0.0, 1.0) : 0.0;
}
#endif

layout(location = 0) out float visibility;

float penumbra_at(ivec2 texel, int layer) {
#if !SOFT
    return 1.0;
#elif PACKED
    return texelFetch(depth_map, ivec3(texel, layer), 0).g;
#else
    return texelFetch(penumbra_map, ivec3(texel, layer), 0).r;
#endif
}

void main() {
    Receiver receiver = read_receiver(receivers, ivec2(gl_FragCoord.xy));
    HardLookup look = look_up_hard(receiver.position_cr, receiver.normal_ws);
#if SIDES_BOTH
    // A loop of no or one turn (`one` is 1, but no compiler knows): where no pixel of a block is dark, a rasteriser on
    // the CPU leaves it at once, while it goes through both sides of an if.
    float dark_value = 0.0;
    int turns = receiver.seen && look.dark ? one : 0;
    for (int i = 0; i < turns; ++i) {
        dark_value = inside_shadow(look);
    }
#else
    const float dark_value = 0.0;
#endif
#if GATHER
    float z_ls = look.at.z_ls - depth_bias(look.at, 1.0);
    ivec2 base = clamp(ivec2(floor(look.at.texel - 0.5)), ivec2(0), ivec2(map.counts.y - 2));
    vec2 f = clamp(look.at.texel - 0.5 - vec2(base), 0.0, 1.0);
    vec4 v;
    for (int i = 0; i < 4; ++i) {
        ivec2 texel = base + ivec2(i & 1, i >> 1);
        float stored = texelFetch(depth_map, ivec3(texel, look.layer), 0).r;
        float z = z_ls + plane_offset(look.at, vec2(texel) + 0.5 - look.at.texel);
        v[i] = window_depth(look.layer, z) >= stored ? penumbra_at(texel, look.layer) : dark_value;
    }
    vec2 rows = v.xz + (v.yw - v.xz) * f.x;
    float lit = rows.x + (rows.y - rows.x) * f.y;
#if FACING_TEST
    lit = look.at.towards_m <= 0.0 ? dark_value : lit;
#endif
    float value = look.outside ? 1.0 : lit;
#else
    float value = look.outside ? 1.0 : (look.dark ? dark_value : penumbra_at(look.texel, look.layer));
#endif
    visibility = receiver.seen ? clamp(value, 0.0, 1.0) : 1.0;
}
