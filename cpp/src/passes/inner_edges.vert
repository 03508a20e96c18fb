// The inner side of silhouette edges: a sheet along each edge, as wide as its reach, and a wedge at corners where the
// sheets of two edges leave a gap. 15 vertices per record: 6 sheet, 9 wedge.
#include "lib/map_lookup.glsl"
#include "lib/map_space.glsl"
#include "lib/edge_space.glsl"

layout(std430, binding = 2) readonly buffer Records { SilhouetteRecord records[]; };
uniform vec2 reach;  // x fixed, y per difference in w; unit lengths
const float least_texels = 0.5;  // what reaches less far than that is left out

out vec2 inward;  // offset from the nearest point of the edge, unit lengths
out float w_edge;

float reach_at(float w) {
    return max(0.0, reach.x + reach.y * (w - edge_range.z));
}

void main() {
    SilhouetteRecord record = records[gl_VertexID / 15];
    int k = gl_VertexID % 15;
    vec3 a_ls = ls_from_rel(face_index, record.a_rel.xyz);
    vec3 b_ls = ls_from_rel(face_index, record.b_rel.xyz);
    vec3 z_ls = ls_from_rel(face_index, record.z_rel.xyz);
    bool corner_in_range = in_edge_range(a_ls.z);
    vec3 arriving_a = z_ls, arriving_b = a_ls;
    bool seen = clip_edge(a_ls, b_ls);
    gl_Position = vec4(2.0, 2.0, 0.5, 1.0);
    inward = vec2(0.0);
    w_edge = 0.0;
    if (seen) {
        vec3 a = pw_from_ls(a_ls);
        vec3 b = pw_from_ls(b_ls);
        vec2 along = b.xy - a.xy;
        float len = length(along);
        vec2 e = along / max(len, 1e-30);
        vec2 inner = vec2(e.y, -e.x);
        bool draw = len > 0.0;
        vec3 from = a;
        if (k < 6) {
            bool at_b = k == 1 || k == 2 || k == 4;
            bool deep = k == 2 || k == 4 || k == 5;
            from = at_b ? b : a;
            inward = deep ? inner * reach_at(from.z) : vec2(0.0);
        } else {
            draw = draw && corner_in_range && record.a_rel.w > 0.5 && clip_edge(arriving_a, arriving_b);
            if (draw) {
                vec2 before = a.xy - pw_from_ls(arriving_a).xy;
                float len_before = length(before);
                before /= max(len_before, 1e-30);
                draw = len_before > 0.0 && turn_of(before, e) > 0.0;  // the shadow's side opens
                inward = sector_corner(k - 6, vec2(before.y, -before.x), inner, false) * reach_at(a.z);
            }
        }
        w_edge = from.z;
        float widest = reach_at(max(a.z, b.z));
        vec2 scale = map.faces[face_index].texel_from_ls.xy;
        float texels = max(length(from_unit(vec2(widest, 0.0)) * scale), length(from_unit(vec2(0.0, widest)) * scale));
        if (draw && texels >= least_texels) {
            gl_Position = clip_from_ip(face_index, from_unit(from.xy + inward));
        }
    }
}
