// Which record sends a vertex's cone: the first one that begins at it. For edge choices without corners.
#include "shared/silhouette.h"

layout(std430, binding = 0) readonly buffer Records { SilhouetteRecord records[]; };
layout(std430, binding = 3) buffer Mailboxes { uint first_record[]; };
layout(std430, binding = 4) readonly buffer FirstBoxes { uint first_box[]; };  // by instance

void main() {
    uvec4 ids = records[gl_VertexID].ids;
    atomicMin(first_record[first_box[ids.x] + ids.y], uint(gl_VertexID));
    gl_Position = vec4(2.0, 2.0, 2.0, 1.0);
}
