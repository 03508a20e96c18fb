// A vertex of a shadow volume, in place or cast to infinity. In place it is view_ids.vert's, bit by bit: near caps must
// fall on the surfaces that they are.
#include "lib/instance.glsl"

layout(location = 0) in vec4 position_local;  // w: 1 in place, 0 cast
layout(location = 1) in uint instance_index;

layout(std430, binding = 0) readonly buffer Instances { InstanceBlock instances[]; };
uniform mat4 clip_from_rel;
uniform vec4 light_cr;    // w = 1; sun: direction towards it, w = 0
uniform float far_share;  // 0: cast to infinity; else to the light's distance (a sun: a metre) over this

invariant gl_Position;

void main() {
    vec3 p_rel = rel_from_local(instances[instance_index], position_local.xyz);
    vec4 in_place = clip_from_rel * vec4(p_rel, 1.0);
    vec3 along = light_cr.w * p_rel - light_cr.xyz;
    vec3 start = light_cr.w > 0.5 ? light_cr.xyz : p_rel;
    vec4 far_off = clip_from_rel * vec4(along + far_share * start, far_share);
    gl_Position = position_local.w > 0.5 ? in_place : far_off;
}
