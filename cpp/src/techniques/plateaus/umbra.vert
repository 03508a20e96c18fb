// Casters projected onto a receiver plane along the light's rays: the hard shadow, lambda = 0. Homogeneous, so that the
// rasteriser clips what lies at the light; what lies below the plane is clipped by distance.
#include "lib/instance.glsl"
#include "techniques/plateaus/plateau.glsl"

layout(location = 0) in vec3 position_local;
layout(location = 1) in uint instance_index;

layout(std430, binding = 0) readonly buffer Instances { InstanceBlock instances[]; };

out gl_PerVertex {
    vec4 gl_Position;
    float gl_ClipDistance[2];
};

void main() {
    vec3 v = plane_from_rel(rel_from_local(instances[instance_index], position_local));
    vec4 light = PLANE.light;
    float q = 1.0 - v.z * light.w / light.z;
    vec2 s = v.xy * q + (light.w * v.xy - light.xy) * (v.z / light.z);
    vec2 texel = (s - PLANE.window.xy * q) * PLANE.window.w;
    gl_Position = vec4(2.0 * texel / vec2(PLANE.size.xy) - q, 0.0, q);
    gl_ClipDistance[0] = v.z - PLANE.heights.x;
    gl_ClipDistance[1] = PLANE.heights.y - v.z;
}
