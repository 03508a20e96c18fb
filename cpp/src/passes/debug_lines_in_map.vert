// Silhouettes as lines in a map's own space; two vertices for each record.
#include "lib/map_lookup.glsl"
#include "lib/map_space.glsl"
#include "shared/silhouette.h"

layout(std430, binding = 0) readonly buffer Records { SilhouetteRecord records[]; };
uniform int face_index;

void main() {
    SilhouetteRecord record = records[gl_VertexID / 2];
    vec3 p_ls = ls_from_rel(face_index, (gl_VertexID & 1) == 0 ? record.a_rel.xyz : record.b_rel.xyz);
    vec4 extent = map.faces[face_index].low_high;
#if MAP_ORTHOGRAPHIC
    float w = 1.0;
#else
    float w = p_ls.z;  // left to the rasteriser, which clips what lies behind the light
#endif
    gl_Position = vec4((2.0 * p_ls.xy - (extent.xy + extent.zw) * w) / (extent.zw - extent.xy), 0.5 * w, w);
}
