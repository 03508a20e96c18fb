// Cones and sheets of silhouette records, emitted homogeneously: positions in the image plane with w = 1, so that all
// that is affine in (p, w) interpolates exactly [D: penumbra-maps 7]. 12 vertices per record: 6 of the edge's sheet,
// 6 of the cone at its first vertex (trimmed to the wedge between two sheets, up to a third of a turn: a kite; else a
// square around the whole).
#include "lib/map_lookup.glsl"
#include "lib/map_space.glsl"
#include "lib/edge_space.glsl"
#include "techniques/penumbra_maps/light_base.glsl"
#include "techniques/penumbra_maps/tangent.glsl"

layout(std430, binding = 2) readonly buffer Records { SilhouetteRecord records[]; };
uniform bool trim_cones;
uniform float texels_per_w;  // longest displacement of the light's shape, in texels

const float least_texels = 0.5;  // what reaches less far than that is left out

out vec2 from_point;   // cones: offset from the apex that cone_depth() measures; sheets: 0
out vec2 w_edge_here;  // w of the edge point responsible, and of the sheet here (cones: of the apex)
#if NEEDS_FOOT
out vec2 foot;           // sheets: distance from the edge's line, and w of the foot on it
flat out vec3 edge_line; // outer normal of the edge in xy, change of w along it in z; cones: 0
#endif

// Length in texels of a displacement by `d` (unit lengths).
float texels_of(vec2 d) {
    return length(from_unit(d) * MAP_FACE(face_index).texel_from_ls.xy);
}

void main() {
    int record_index = gl_VertexID / 12;
    int k = gl_VertexID - 12 * record_index;
    SilhouetteRecord record = records[record_index];
    vec3 a_ls = ls_from_rel(face_index, record.a_rel.xyz);
    vec3 b_ls = ls_from_rel(face_index, record.b_rel.xyz);
    vec3 z_ls = ls_from_rel(face_index, record.z_rel.xyz);
    bool corner_in_range = in_edge_range(a_ls.z);
    vec3 apex_ls = a_ls;
    gl_Position = vec4(2.0, 2.0, 0.5, 1.0);
    from_point = vec2(0.0);
    w_edge_here = vec2(0.0);
#if NEEDS_FOOT
    foot = vec2(0.0);
    edge_line = vec3(0.0);
#endif
    bool seen = clip_edge(a_ls, b_ls);
    vec3 a = pw_from_ls(a_ls);
    vec3 b = pw_from_ls(b_ls);
    Tangent sheet = tangent_of(a, b);
    sheet.exists = sheet.exists && seen;
    // The corner at a: the edge that arrives there.
    vec3 z_cut = z_ls, a_cut = apex_ls;
    bool paired = corner_in_range && record.a_rel.w > 0.5 && clip_edge(z_cut, a_cut);
    vec3 apex = pw_from_ls(corner_in_range ? apex_ls : a_ls);
    vec3 z = paired ? pw_from_ls(z_cut) : a + vec3(1.0, 0.0, 0.0);
    Tangent arriving = tangent_of(z, apex);
    bool both = paired && sheet.exists && arriving.exists;
    vec2 before = apex.xy - z.xy;
    vec2 after = b.xy - a.xy;
    float turn = turn_of(before, after);
    vec2 from = arriving.at_b, to = sheet.at_a;
    bool gap = both && turn_of(from, to) < 0.0;
    bool more_than_half = both && !gap && turn <= 0.0 && dot(before, after) < 0.0;
    float apex_depth = apex.z - edge_range.z;
    bool joined = false;
#if CONE_BASE == 0
    // A gap of less than a texel at its widest is closed by this sheet, drawn a little beyond its end.
    joined = trim_cones && gap && dot(from, to) > 0.995 &&
             texels_of((to - from) * apex_depth) < 1.0;
#endif

    vec3 at = a;
    bool draw = false;
    if (k < 6) {
        bool at_b = k == 1 || k == 2 || k == 4;
        bool rim = k == 2 || k == 4 || k == 5;
        at = at_b ? b : a;
        float depth = max(at.z - edge_range.z, 0.0);
        vec2 d = (at_b ? sheet.at_b : sheet.at_a) * (rim ? depth : 0.0);
        float w_edge = at.z;
        float w_here = rim ? at.z - depth : at.z;
        draw = sheet.exists &&
               max(texels_of(sheet.at_a * (a.z - edge_range.z)), texels_of(sheet.at_b * (b.z - edge_range.z))) >=
                   least_texels;
#if CONE_BASE == 0 || NEEDS_FOOT
        float len = max(length(after), 1e-30);
        vec2 e = after / len;
        vec2 outer = vec2(-e.y, e.x);
        float per_length = (b.z - a.z) / len;
#endif
#if CONE_BASE == 0
        if (joined && rim && !at_b) {
            // On the sheet's own plane w = w_a - n d; the point responsible lies on the line along n.
            d = from * (depth / dot(from, to));
            float on_n = dot(d, outer) / max(dot(to, outer), 1e-4);
            float on_e = dot(d, e) - on_n * dot(to, e);
            w_edge = a.z + per_length * on_e;
            w_here = a.z - dot(to, d);
        }
#endif
        at.xy += d;
        w_edge_here = vec2(w_edge, w_here);
#if NEEDS_FOOT
        edge_line = vec3(outer, per_length);
        foot = vec2(dot(at.xy - a.xy, outer), a.z + per_length * dot(at.xy - a.xy, e));
#endif
    } else {
        at = apex;
#if CONE_BASE == 2
        vec2 n_from = normalize(stretch(from, apex, true)), n_to = normalize(stretch(to, apex, true));
#else
        vec2 n_from = from / max(length(from), 1e-30), n_to = to / max(length(to), 1e-30);
#endif
        float cosine = dot(n_from, n_to);
        bool whole = !trim_cones || !both || more_than_half || (gap && cosine < -0.5);
        draw = corner_in_range && (whole || (gap && !joined)) && (paired || seen || record.a_rel.w < 0.5);
#if CONE_BASE == 1 && LIGHT_CORNERS == 2
        draw = false;  // a segment's cones have no width
#endif
#if CONE_BASE == 1
        draw = draw && (whole || length(from - to) > 1e-6 * light_reach);
#endif
        int corner = k - 6;
        vec2 square = vec2(corner == 1 || corner == 2 || corner == 4 ? 1.0 : -1.0,
                           corner == 2 || corner == 4 || corner == 5 ? 1.0 : -1.0);
        // The tip is where the rim's tangents at both ends meet.
        vec2 tip = (n_from + n_to) / max(1.0 + cosine, 0.5);
        vec2 kite = corner == 0 || corner == 3 ? vec2(0.0)
                                               : (corner == 1 ? n_from : (corner == 5 ? n_to : tip));
        vec2 d = whole ? square : kite;
        d *= max(apex_depth, 0.0);
        draw = draw && apex_depth * texels_per_w >= least_texels;
#if CONE_BASE == 0
        from_point = d;
#elif CONE_BASE == 1
        d *= light_reach;
        from_point = d;
#else
        from_point = d;
        d = stretch(d, apex, false);
#endif
        at.xy += d;
        w_edge_here = vec2(apex.z);
    }
    if (draw) {
        gl_Position = clip_from_ip(face_index, from_unit(at.xy));
    }
}
