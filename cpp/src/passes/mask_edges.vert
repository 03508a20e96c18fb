// Edges that may be silhouettes for some point of the light, as strips in the mask's map: every texel that an edge
// touches has its centre in the strip. 6 vertices per record.
#include "shared/mask_edge.h"

layout(std430, binding = 2) readonly buffer Edges { MaskEdge edges[]; };
uniform float size_px;
uniform float half_width;  // texels, at least sqrt(1/2)

out float w_near;      // nearest depth of the edge within half_width
flat out float w_most;  // of the whole edge
flat out float looked_up;

void main() {
    MaskEdge edge = edges[gl_VertexID / 6];
    int k = gl_VertexID % 6;
    bool at_b = k == 1 || k == 2 || k == 4;
    bool left = k == 2 || k == 4 || k == 5;
    vec2 along = edge.b.xy - edge.a.xy;
    float len = length(along);
    vec2 e = len > 1e-3 ? along / len : vec2(1.0, 0.0);
    float per_texel = len > 1e-3 ? (edge.b.z - edge.a.z) / len : 0.0;
    float beyond = at_b ? half_width : -half_width;
    vec2 at = (at_b ? edge.b.xy : edge.a.xy) + beyond * e + (left ? half_width : -half_width) * vec2(-e.y, e.x);
    gl_Position = vec4(2.0 * at / size_px - 1.0, 0.5, 1.0);
    w_most = max(edge.a.z, edge.b.z);
    w_near = (len > 1e-3 ? (at_b ? edge.b.z : edge.a.z) : w_most) + beyond * per_texel + abs(per_texel) * half_width;
    looked_up = edge.a.w;
}
