// Smoothies of one silhouette record [Chan2004]: a quad outside the edge a->b, and a wedge outside its first vertex.
//
// Depth is the map's own, reversed ("u": 1 near .. 0 far), affine in the image plane for both projections. The quad is
// as wide as the widest ramp that can show there: receivers are nowhere farther than `u_far`. Fragments compute their
// distance from the edge themselves, so the outline drawn here decides nothing but which texels are asked; it overlaps
// by SLACK texels where two of its parts meet, since neither may miss a texel's centre.
//
// Polygons are drawn tilted: at distance d from the edge they have the depth at which a receiver would just be outside
// the ramp there. A depth test against the receivers then drops what cannot darken before it is shaded.
//
// One point per record comes in; a geometry shader, so that the record's frame is made once and not for each vertex.
// CORNERS 1: a wedge per fan of triangles. 2: the thesis' tips where more than two silhouettes meet.
#include "lib/map_lookup.glsl"
#include "lib/map_space.glsl"
#include "shared/silhouette.h"
#include "techniques/smoothies/ramp.glsl"

#define SLACK 0.03125

layout(points) in;
#if CORNERS == 2
layout(triangle_strip, max_vertices = 14) out;
#else
layout(triangle_strip, max_vertices = 8) out;
#endif
flat in int record_index[];

layout(std430, binding = 2) readonly buffer Silhouettes { SilhouetteRecord records[]; };
uniform float u_far;
#define TILTED (REMAP && !FIXED_WIDTH && !RESIZE_PER_VERTEX)
#if CORNERS == 2
layout(std430, binding = 3) readonly buffer Tips { vec4 tips[]; };
#endif

flat out vec4 line;   // xy start of the edge's visible part, zw its unit direction; image plane
flat out vec3 along;  // x its length, y u at its start, z change of u per length
#if RESIZE_PER_VERTEX
layout(binding = 4) uniform sampler2DArray receiver_map;
flat out vec2 widths;  // of the ramp at the start and at the end
#endif

struct Corner {
    vec2 p_ip;
    float u;
};

Corner project(vec3 p_ls) {
#if MAP_ORTHOGRAPHIC
    vec4 range_m = MAP_FACE(face_index).range_m;
    return Corner(p_ls.xy, (range_m.y - p_ls.z) / (range_m.y - range_m.x));
#else
    return Corner(p_ls.xy / p_ls.z, MAP_FACE(face_index).range_m.x / p_ls.z);
#endif
}

// Direction of a short way from a point, projected. For an edge made of differences of its ends in the world's axes, so
// that small edges far from the light keep their digits.
vec2 projected(vec3 from_rel, vec3 by_rel) {
    precise vec3 from = ls_from_rel(face_index, from_rel);
    precise vec3 by = ls_from_rel(face_index, by_rel);
#if MAP_ORTHOGRAPHIC
    precise vec2 d = by.xy;
#else
    precise vec2 d = by.xy * from.z - from.xy * by.z;
#endif
    float size = length(d);
    return size > 0.0 ? d / size : vec2(0.0);
}

// Keeps what of the edge lies where f >= 0; range: from and to as shares of its length, empty if from > to.
void clip(float f_a, float f_b, inout vec2 range) {
    if (f_a < 0.0 && f_b < 0.0) {
        range = vec2(1.0, 0.0);
    } else if (f_a < 0.0) {
        range.x = max(range.x, f_a / (f_a - f_b));
    } else if (f_b < 0.0) {
        range.y = min(range.y, f_a / (f_a - f_b));
    }
}

float reach(vec2 outer_normal, float u) {
    return ramp_width(half_width(outer_normal), u, min(u_far, u));
}

// Depth to draw a polygon's rim at. Affine in between only where the width follows the light.
float rim_depth(float u) {
#if TILTED
    return min(u_far, u);
#else
    return u;
#endif
}

vec4 frame_line;
vec3 frame_along;
#if RESIZE_PER_VERTEX
vec2 frame_widths;
#endif

void emit(vec2 p_ip, float u) {
    line = frame_line;
    along = frame_along;
#if RESIZE_PER_VERTEX
    widths = frame_widths;
#endif
    gl_Position = vec4(clip_from_ip(face_index, p_ip).xy, u, 1.0);
    EmitVertex();
}

void main() {
    SilhouetteRecord record = records[record_index[0]];
    MapFaceBlock face = MAP_FACE(face_index);
    vec3 a_ls = ls_from_rel(face_index, record.a_rel.xyz);
    vec3 b_ls = ls_from_rel(face_index, record.b_rel.xyz);
    vec2 e = projected(record.a_rel.xyz, record.b_rel.xyz - record.a_rel.xyz);
    vec2 n = vec2(-e.y, e.x);

    // Clipped before it is projected: an end beside or behind the light has no place in the image plane.
    vec2 range = vec2(0.0, 1.0);
#if MAP_ORTHOGRAPHIC
    float w_a = 1.0, w_b = 1.0;
    float nearest = max(project(a_ls).u, project(b_ls).u);
#else
    float w_a = a_ls.z, w_b = b_ls.z;
    float least_z = 1e-3 * face.range_m.x;
    clip(w_a - least_z, w_b - least_z, range);
    float nearest = face.range_m.x / max(min(w_a, w_b), least_z);
#endif
    float margin = ramp_width(largest_half_width(), nearest, min(u_far, nearest));
    vec2 low = face.low_high.xy - margin;
    vec2 high = face.low_high.zw + margin;
    clip(a_ls.x - low.x * w_a, b_ls.x - low.x * w_b, range);
    clip(high.x * w_a - a_ls.x, high.x * w_b - b_ls.x, range);
    clip(a_ls.y - low.y * w_a, b_ls.y - low.y * w_b, range);
    clip(high.y * w_a - a_ls.y, high.y * w_b - b_ls.y, range);

    Corner from = project(range.x > 0.0 ? mix(a_ls, b_ls, range.x) : a_ls);
    Corner to = project(range.y < 1.0 ? mix(a_ls, b_ls, range.y) : b_ls);
    float size = max(0.0, dot(to.p_ip - from.p_ip, e));
    frame_line = vec4(from.p_ip, e);
    frame_along = vec3(size, from.u, size > 0.0 ? (to.u - from.u) / size : 0.0);
    float reach_from = reach(n, from.u);
    float reach_to = reach(n, to.u);
#if FIXED_WIDTH
    reach_from = reach_to = max(reach_from, reach_to);  // not affine in between, but never more than this
#endif
    if (range.x > range.y || !(margin > 0.0)) {
        return;
    }

#if RESIZE_PER_VERTEX
    // The proposed variant: the outer corners read the receiver's depth, fragments interpolate.
    vec2 size_ends[2] = vec2[2](from.p_ip + n * reach_from, to.p_ip + n * reach_to);
    for (int i = 0; i < 2; ++i) {
        ivec2 texel = clamp(ivec2(floor(size_ends[i] * face.texel_from_ls.xy + face.texel_from_ls.zw)), ivec2(0),
                            ivec2(map.counts.y - 1));
        float u_r = max(texelFetch(receiver_map, ivec3(texel, face_index), 0).r, u_far);
        float u = i == 0 ? from.u : to.u;
        frame_widths[i] = ramp_width(half_width(n), u, min(u, u_r));
    }
#endif

    float slack = SLACK * min(face.step_ls.x, face.step_ls.y);
    if (size > 0.0) {
        vec2 start = from.p_ip - slack * e;
        vec2 end = to.p_ip + slack * e;
        emit(start - slack * n, from.u);
        emit(start + reach_from * n, rim_depth(from.u));
        emit(end - slack * n, to.u);
        emit(end + reach_to * n, rim_depth(to.u));
        EndPrimitive();
    }

#if CORNERS
    vec2 e_in = projected(record.z_rel.xyz, record.a_rel.xyz - record.z_rel.xyz);
    vec2 n_in = vec2(-e_in.y, e_in.x);
    float turn = e_in.x * e.y - e_in.y * e.x;
    float cosine = dot(e_in, e);
    // Seen with z away from the light the blocker lies to the right: a convex corner turns right. An edge that comes
    // straight back is a needle's tip.
    bool convex = turn < 0.0 || (cosine < 0.0 && turn < 1e-5);
    float radius = ramp_width(largest_half_width(), from.u, min(u_far, from.u));
    bool wedge = convex && record.a_rel.w > 0.5 && range.x == 0.0 && dot(e_in, e_in) > 0.0 && dot(e, e) > 0.0;
#if CORNERS == 2
    wedge = wedge && tips[2 * record_index[0]].w < 0.5;
#endif
    if (wedge && radius > 0.0) {
        vec2 middle = normalize(n_in + n + e_in - e);
        bool split = cosine < 0.5;
        float half_cosine = dot(middle, n);  // of half the turn
        radius /= split ? sqrt(0.5 + 0.5 * half_cosine) : max(half_cosine, 0.5);
        float rim = rim_depth(from.u);  // of the sector's rim, which lies inside: never too deep
        emit(from.p_ip + radius * n_in, rim);
        emit(from.p_ip - slack * middle, from.u);
        if (split) {
            emit(from.p_ip + radius * middle, rim);
        }
        emit(from.p_ip + radius * n, rim);
        EndPrimitive();
    }
#endif
#if CORNERS == 2
    for (int i = 0; i < 2; ++i) {
        vec4 tip = tips[2 * record_index[0] + i];
        bool whole = i == 0 ? range.x == 0.0 : range.y == 1.0;
        vec2 way = projected(i == 0 ? record.a_rel.xyz : record.b_rel.xyz, tip.xyz);
        if (tip.w > 0.5 && whole && dot(way, way) > 0.0) {
            // As wide as the quads of the thesis, for which no receiver is too far: the chord to the tip shows.
            vec2 p_ip = i == 0 ? from.p_ip : to.p_ip;
            float u = i == 0 ? from.u : to.u;
            float width = ramp_width(half_width(n), u, 0.0);
            emit(p_ip, u);
            emit(p_ip + width * n, u);
            emit(p_ip + width * way, u);
            EndPrimitive();
        }
    }
#endif
}
