// Placing a vertex.
#include "shared/instance_block.h"

vec3 rel_from_local(InstanceBlock instance, vec3 p_local) {
    vec4 p = vec4(p_local, 1.0);
    return vec3(dot(instance.rows[0], p), dot(instance.rows[1], p), dot(instance.rows[2], p));
}
