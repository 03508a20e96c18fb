// Silhouettes as lines in the camera's view; two vertices for each record.
#include "shared/silhouette.h"

layout(std430, binding = 0) readonly buffer Records { SilhouetteRecord records[]; };
uniform mat4 clip_from_rel;
uniform vec3 origin_cr;

out vec3 position_cr;

void main() {
    SilhouetteRecord record = records[gl_VertexID / 2];
    position_cr = origin_cr + ((gl_VertexID & 1) == 0 ? record.a_rel.xyz : record.b_rel.xyz);
    gl_Position = clip_from_rel * vec4(position_cr, 1.0);
}
