// One silhouette edge as it leaves the extraction. Included by C++ and GLSL; std430.
#ifndef PENUMBRA_SILHOUETTE_H
#define PENUMBRA_SILHOUETTE_H

// a -> b with the blocker on the left of an observer at the light (geometry/silhouettes.h). In a map's (x_ls, y_ls)
// the outer normal of the edge with unit direction e is (-e.y, e.x).
struct SilhouetteRecord {
    vec4 a_rel;  // xyz start, relative to the pass's origin, world axes, metres; w: 1 if the corner at a is paired
    vec4 b_rel;  // xyz end; w unused
    vec4 z_rel;  // xyz start of the silhouette edge that arrives at a on the same fan; = a if not paired; w unused
    uvec4 ids;   // instance, and the welded vertices a, b, z of its mesh
};

#endif
