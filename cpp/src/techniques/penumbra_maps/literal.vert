// The published construction: cones as fans of FACETS triangles and sheets as PARTS quads, from the silhouette down to
// the far plane (here just behind the deepest receiver), in perspective, with depths as varyings [P 2.3, 2.4].
// LITERAL_CONES: the cones (3 FACETS vertices per record), else the sheets (6 PARTS).
#include "lib/map_lookup.glsl"
#include "lib/map_space.glsl"
#include "lib/edge_space.glsl"
#include "techniques/penumbra_maps/light_base.glsl"
#include "techniques/penumbra_maps/tangent.glsl"

layout(std430, binding = 2) readonly buffer Records { SilhouetteRecord records[]; };

uniform float texels_per_w;  // longest displacement of the light's shape, in texels
const float least_texels = 0.5;  // what reaches less far than that is left out, as in exact.vert

out vec2 z_edge_here;  // depths of the silhouette point and of the fragment, metres

float depth_of(float w) {
#if MAP_ORTHOGRAPHIC
    return -w;
#else
    return 1.0 / w;
#endif
}

void emit(vec2 p_unit, float w_edge, float w_here) {
    float z_here = depth_of(w_here);
    z_edge_here = vec2(depth_of(w_edge), z_here);
#if MAP_ORTHOGRAPHIC
    gl_Position = clip_from_ip(face_index, from_unit(p_unit));
#else
    gl_Position = clip_from_ip(face_index, from_unit(p_unit)) * z_here;
#endif
}

void main() {
    gl_Position = vec4(2.0, 2.0, 0.5, 1.0);
    z_edge_here = vec2(0.0);
#if LITERAL_CONES
    SilhouetteRecord record = records[gl_VertexID / (3 * FACETS)];
    int k = gl_VertexID % (3 * FACETS);
    vec3 apex_ls = ls_from_rel(face_index, record.a_rel.xyz);
    vec3 apex = pw_from_ls(apex_ls);
    if (in_edge_range(apex_ls.z) && (apex.z - edge_range.z) * texels_per_w >= least_texels) {
        int facet = k / 3;
        int corner = k - 3 * facet;
        int rim = (facet + max(corner - 1, 0)) % FACETS;
#if CONE_BASE == 1
        vec2 d = -light_corner[rim].xy;
#else
        float angle = 6.28318530718 * float(rim) / float(FACETS);
        vec2 d = vec2(cos(angle), sin(angle));
#endif
#if CONE_BASE == 2
        d *= light_reach;
#endif
        float w_here = corner == 0 ? apex.z : edge_range.z;
        emit(apex.xy + d * (apex.z - w_here), apex.z, w_here);
    }
#else
    SilhouetteRecord record = records[gl_VertexID / (6 * PARTS)];
    int k = gl_VertexID % (6 * PARTS);
    vec3 a_ls = ls_from_rel(face_index, record.a_rel.xyz);
    vec3 b_ls = ls_from_rel(face_index, record.b_rel.xyz);
    bool seen = clip_edge(a_ls, b_ls);
    vec3 a = pw_from_ls(a_ls);
    vec3 b = pw_from_ls(b_ls);
    Tangent sheet = tangent_of(a, b);
    float ratio = max(a_ls.z, b_ls.z) / max(min(a_ls.z, b_ls.z), 1e-30);
#if MAP_ORTHOGRAPHIC
    ratio = 1.0;
#endif
    int parts = ratio > 1.05 ? clamp(int(ceil((ratio - 1.0) / 0.02)), 1, PARTS) : 1;
    int part = k / 6;
    int corner = k - 6 * part;
    float longest = texels_per_w * (max(a.z, b.z) - edge_range.z);
    if (seen && sheet.exists && part < parts && longest >= least_texels) {
        bool at_end = corner == 1 || corner == 2 || corner == 4;
        bool rim = corner == 2 || corner == 4 || corner == 5;
        float along = float(part + (at_end ? 1 : 0)) / float(parts);
        vec3 at = mix(a, b, along);
        float w_here = rim ? edge_range.z : at.z;
        emit(at.xy + mix(sheet.at_a, sheet.at_b, along) * (at.z - w_here), at.z, w_here);
    }
#endif
}
