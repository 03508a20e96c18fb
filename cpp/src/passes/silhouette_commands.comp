// Turns the count of records into indirect draws, one command for each number of vertices per record.
#include "shared/silhouette.h"
#include "shared/silhouette_instance.h"

layout(local_size_x = PENUMBRA_MAX_VERTICES_PER_EDGE) in;

struct DrawCommand {
    uint count, instance_count, first, base_instance;
};

layout(std430, binding = 6) writeonly buffer Commands { DrawCommand commands[]; };
layout(std430, binding = 7) readonly buffer Records { uint found; };
uniform uint capacity;

void main() {
    uint per_edge = gl_LocalInvocationIndex + 1u;
    // gl_VertexID is signed.
    uint records = min(min(found, capacity), 0x7fffffffu / per_edge);
    commands[gl_LocalInvocationIndex] = DrawCommand(records * per_edge, 1u, 0u, 0u);
}
