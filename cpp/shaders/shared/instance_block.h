// Placed meshes as the shaders see them. Included by C++ and GLSL; std430.
#ifndef PENUMBRA_INSTANCE_BLOCK_H
#define PENUMBRA_INSTANCE_BLOCK_H

// Relative to the pass's origin from recentred local: row-major 3 x 4, world axes, metres.
struct InstanceBlock {
    vec4 rows[3];
};

#endif
