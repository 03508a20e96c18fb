// First half of the view: which triangle of which instance is seen.
#include "lib/instance.glsl"

layout(location = 0) in vec3 position_local;
layout(location = 1) in uint instance_index;

layout(std430, binding = 0) readonly buffer Instances { InstanceBlock instances[]; };
uniform mat4 clip_from_rel;

flat out uint seen_instance;
#ifdef CUT_RANGE
out vec2 depth_over;  // clip z and w
#endif
invariant gl_Position;  // volume.vert draws the same vertices

void main() {
    seen_instance = instance_index;
    gl_Position = clip_from_rel * vec4(rel_from_local(instances[instance_index], position_local), 1.0);
#ifdef CUT_RANGE
    depth_over = gl_Position.zw;
#endif
}
