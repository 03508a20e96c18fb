// One edge in the penumbra mask's map. Included by C++ and GLSL; std430.
#ifndef PENUMBRA_MASK_EDGE_H
#define PENUMBRA_MASK_EDGE_H

struct MaskEdge {
    vec4 a;  // xy texels, z w (see lib/mask_space.glsl), w 1 if the edge is looked up in the depth map: drop it where hidden
    vec4 b;
};

#endif
