// The three-way test [Chan2004]: behind a caster 0, behind a smoothie alone its alpha, else 1; filtered, then falloff.
#include "lib/map_lookup.glsl"
#include "lib/bias.glsl"
#include "lib/receiver.glsl"

layout(binding = 0) uniform usampler2D receivers;
layout(binding = 2) uniform sampler2DArray depth_map;
#if SMOOTHIES
layout(binding = 3) uniform sampler2DArray alpha_map;
#if STORED == 2
layout(binding = 4) uniform sampler2DArray smoothie_depth;
#endif
#endif

#include "lib/hard_lookup.glsl"

layout(location = 0) out float visibility;

#if BOTH_SIDES
#include "lib/map_space.glsl"
#include "lib/edge_space.glsl"
#include "lib/inner_edges.glsl"
#include "lib/light_ramp.glsl"

uniform vec4 light_u_ws;  // xyz half axes, metres; WIDTH_SHAPE 0: x the radius (a sun: tangent; FIXED_WIDTH: t)
uniform vec4 light_v_ws;
#if WIDTH_SHAPE == 3
uniform vec4 light_corners_ws[8];  // xyz from the centre
uniform int corner_count;
#endif

// Half width of the penumbra that the edge throws on the receiver, inwards; as ramp_width() in ramp.glsl outwards.
float inner_reach(InnerEdge edge, int layer, float z_ls) {
    MapFaceBlock face = MAP_FACE(layer);
    vec3 n_ws = face.x_ls_from_rel.xyz * edge.normal.x + face.y_ls_from_rel.xyz * edge.normal.y;
#if WIDTH_SHAPE == 0
    float half_width = light_u_ws.x;
#elif WIDTH_SHAPE == 1
    float half_width = abs(dot(light_u_ws.xyz, n_ws)) + abs(dot(light_v_ws.xyz, n_ws));
#elif WIDTH_SHAPE == 2
    float half_width = length(vec2(dot(light_u_ws.xyz, n_ws), dot(light_v_ws.xyz, n_ws)));
#else
    float half_width = 0.0;
    for (int i = 0; i < corner_count; ++i) {
        half_width = max(half_width, dot(light_corners_ws[i].xyz, n_ws));
    }
#endif
    float w = w_from_depth(z_ls);
#if FIXED_WIDTH && REMAP
    return half_width * (1.0 - w / edge.w);
#elif FIXED_WIDTH
    return half_width;
#elif REMAP
    return half_width * (edge.w - w);
#elif MAP_ORTHOGRAPHIC
    return half_width * (edge.w + face.range_m.y);
#else
    return half_width * edge.w;
#endif
}

// Share of the light beyond a straight edge. Parallelograms: as if the edge ran along one of their sides.
float light_fraction(float u) {
#if WIDTH_SHAPE == 1
    return clamp(0.5 + 0.5 * u, 0.0, 1.0);
#else
    return disc_fraction(u);
#endif
}

// V inside the hard shadow: what the nearest edge opens, less what blocks again beyond it.
float inner_visibility(HardLookup hard) {
    InnerEdge edge = read_inner_edge(hard);
    float reach = edge.found ? inner_reach(edge, hard.layer, hard.at.z_ls) : 0.0;
    float width = max(reach, 1e-30);
    float open = open_beyond(edge, hard, width);
    float v = light_fraction(-edge.distance / width) - light_fraction(-(edge.distance + open) / width);
    return reach > 0.0 ? clamp(v, 0.0, 0.5) : 0.0;
}
#endif

#if FILTER == 2
#define TEXELS float
#define FLAGS bool
#else
#define TEXELS vec4
#define FLAGS bvec4
#endif

// The texels of a footprint: one, or four in the order of textureGather (left top, right top, right bottom, left
// bottom), fetched at their common corner, half a texel from where another four would be taken.
TEXELS fetch(sampler2DArray image, ivec2 base, int layer) {
#if FILTER == 2
    return texelFetch(image, ivec3(base, layer), 0).r;
#else
    return textureGather(image, vec3((vec2(base) + 1.0) / float(map.counts.y), float(layer)));
#endif
}

#if FILTER == 2
bool at_least(float a, float b) { return a >= b; }
bool more(float a, float b) { return a > b; }
float choose(float no, float yes, bool which) { return which ? yes : no; }
#else
bvec4 at_least(vec4 a, vec4 b) { return greaterThanEqual(a, b); }
bvec4 more(vec4 a, vec4 b) { return greaterThan(a, b); }
vec4 choose(vec4 no, vec4 yes, bvec4 which) { return mix(no, yes, which); }
#endif

// A receiver's window depth as each texel's comparison sees it.
TEXELS at_texels(MapPoint at, float z_ls, ivec2 base) {
#if BIAS_MODE == 3 && FILTER == 2
    return window_depth(at.face, z_ls + plane_offset(at, vec2(base) + 0.5 - at.texel));
#elif BIAS_MODE == 3
    vec4 depths;
    for (int i = 0; i < 4; ++i) {
        vec2 texel = vec2(base) + vec2(i == 1 || i == 2 ? 1.5 : 0.5, i < 2 ? 1.5 : 0.5);
        depths[i] = window_depth(at.face, z_ls + plane_offset(at, texel - at.texel));
    }
    return depths;
#else
    return TEXELS(window_depth(at.face, z_ls));
#endif
}

// How lit each texel leaves a receiver that is not behind a caster there.
// STORED 0: smoothies belong to the surface that the map holds, and what lies in front of that is lit; 1 and 2: the
// smoothie's own depth decides (stored with alpha, or in a depth buffer); 3: nothing decides.
TEXELS alpha_of(MapPoint at, float bias, TEXELS reference, TEXELS stored, ivec2 base, TEXELS alpha) {
#if !SMOOTHIES
    return TEXELS(1.0);
#elif STORED == 0 && BIAS_MODE != 3 && !MAP_ORTHOGRAPHIC
    // near / z > stored without the quotient
    TEXELS near_m = TEXELS(MAP_FACE(at.face).range_m.x);
    return choose(alpha, TEXELS(1.0), more(near_m, stored * (at.z_ls + bias)));
#elif STORED == 0
    return choose(alpha, TEXELS(1.0), more(at_texels(at, at.z_ls + bias, base), stored));
#elif STORED == 1
#if FILTER == 2
    float depth = -texelFetch(alpha_map, ivec3(base, at.face), 0).g;
#else
    vec4 depth = -textureGather(alpha_map, vec3((vec2(base) + 1.0) / float(map.counts.y), float(at.face)), 1);
#endif
    return choose(alpha, TEXELS(1.0), at_least(reference, depth));
#elif STORED == 2
    return choose(alpha, TEXELS(1.0), at_least(reference, fetch(smoothie_depth, base, at.face)));
#else
    return alpha;
#endif
}

#if FILTER != 2
// Exactly 1 where all four are: a + (b - a) f, no mix().
float bilinear(vec4 v, vec2 f) {
    vec2 rows = v.wx + (v.zy - v.wx) * f.x;
    return rows.x + (rows.y - rows.x) * f.y;
}
#endif

float fall(float v) {
#if FALLOFF == 0
    return v;
#elif FALLOFF == 1  // (1 - cos(pi v)) / 2 = 1/2 + sin(pi (v - 1/2)) / 2, sine by its series, within 1e-7
    float x = v - 0.5;
    float x2 = x * x;
    float s = x * (3.14159265 + x2 * (-5.16771278 + x2 * (2.55016404 + x2 * (-0.59926453 + x2 * (0.08214589 +
              x2 * -0.00737043)))));
    return v >= 1.0 ? 1.0 : max(0.5 + 0.5 * s, 0.0);
#elif FALLOFF == 2
    return v * v * (3.0 - 2.0 * v);
#else
    float x = 2.0 * v - 1.0;
    float area = 0.5 + (x * sqrt(max(0.0, 1.0 - x * x)) + asin(clamp(x, -1.0, 1.0))) / 3.14159265;
    return v >= 1.0 ? 1.0 : (v <= 0.0 ? 0.0 : clamp(area, 0.0, 1.0));
#endif
}

void main() {
    Receiver receiver = read_receiver(receivers, ivec2(gl_FragCoord.xy));
#if FILTER == 2  // nearest: the hard map's own comparison, to the bit
    HardLookup hard = look_up_hard(receiver.position_cr, receiver.normal_ws);
    MapPoint at = hard.at;
    bool outside = hard.outside;
    at.face = hard.layer;
    ivec2 base = hard.texel;
    float bias = depth_bias(at, 0.5);
#else
    MapPoint at = find_biased(receiver.position_cr, receiver.normal_ws);
    bool outside = at.face < 0;
    at.face = max(at.face, 0);
    ivec2 base = clamp(ivec2(floor(at.texel - 0.5)), ivec2(0), ivec2(map.counts.y - 2));
    vec2 f = at.texel - 0.5 - vec2(base);
    float bias = depth_bias(at, 1.0);
#endif
    TEXELS stored = fetch(depth_map, base, at.face);
    TEXELS reference = at_texels(at, at.z_ls - bias, base);
    FLAGS lit = at_least(reference, stored);
#if SMOOTHIES
    TEXELS alpha = fetch(alpha_map, base, at.face);
#else
    TEXELS alpha = TEXELS(1.0);
#endif
    TEXELS soft = alpha_of(at, bias, reference, stored, base, alpha);
#if FILTER == 2
    float v = hard.dark ? 0.0 : soft;
#elif FILTER == 0
    float v = bilinear(mix(vec4(0.0), soft, lit), f);
#else  // as published: three filtered lookups; a footprint that touches the umbra is all dark
    bool before_all = all(greaterThanEqual(soft, vec4(1.0)));
    float v = !all(lit) ? 0.0 : (before_all ? 1.0 : bilinear(alpha, f));
#endif
    v = outside ? 1.0 : clamp(v, 0.0, 1.0);
#if BOTH_SIDES
#if FILTER != 2
    HardLookup hard = look_up_hard(receiver.position_cr, receiver.normal_ws);
#endif
    v = hard.dark ? inner_visibility(hard) : light_fraction(v);
#else
    v = fall(v);
#endif
#if FACING_TEST
    v = at.towards_m > 0.0 ? v : 0.0;
#endif
    visibility = receiver.seen ? v : 1.0;
}
