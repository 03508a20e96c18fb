// Depth of the casters as one face of a map sees them. Reversed depth: 1 near, 0 far.
#include "lib/instance.glsl"
#include "shared/map_block.h"

layout(location = 0) in vec3 position_local;
layout(location = 1) in uint instance_index;

layout(std430, binding = 0) readonly buffer Instances { InstanceBlock instances[]; };
layout(std140, binding = 1) uniform Map { MapBlock map; };
uniform int face_index;

out float z_ls;

void main() {
    vec3 p_rel = rel_from_local(instances[instance_index], position_local);
    MapFaceBlock face = map.faces[face_index];
    vec3 p_ls = vec3(dot(face.x_ls_from_rel.xyz, p_rel), dot(face.y_ls_from_rel.xyz, p_rel),
                     dot(face.z_ls_from_rel.xyz, p_rel));
    z_ls = p_ls.z;
    vec2 centre = 0.5 * (face.low_high.xy + face.low_high.zw);
    vec2 half_size = 0.5 * (face.low_high.zw - face.low_high.xy);
    if (face.range_m.z > 0.5) {
        gl_Position = vec4((p_ls.xy - centre) / half_size, (face.range_m.y - p_ls.z) / (face.range_m.y - face.range_m.x), 1.0);
    } else {
        // Infinite reversed projection: window depth = near / z.
        gl_Position = vec4((p_ls.xy - centre * p_ls.z) / half_size, face.range_m.x, p_ls.z);
    }
}
