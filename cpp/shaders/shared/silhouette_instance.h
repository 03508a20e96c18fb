// One instance as the silhouette shaders see it. Included by C++ and GLSL; std430.
#ifndef PENUMBRA_SILHOUETTE_INSTANCE_H
#define PENUMBRA_SILHOUETTE_INSTANCE_H

// Draws of up to this many vertices per silhouette edge have a command.
#define PENUMBRA_MAX_VERTICES_PER_EDGE 256

struct SilhouetteInstance {
    vec4 rows[3];        // relative to the pass's origin from recentred local
    vec4 light;          // FacingFrame::light(), for the planes
    vec4 light_high;     // recentred local times the frame's scale, rounded; w = 1; a sun: unit direction, w = 0
    vec4 light_low;      // xyz what rounding took from light_high; w the frame's scale
    uint first_vertex;   // of the mesh in `positions`, in vertices
    uint first_index;    // in `indices`
    uint first_plane;    // in `planes`
    uint first_corner;   // in `triangle_edges`
    uint first_edge;     // in `edges`
    uint first_more;     // of the sides of edges with more than two triangles, in `triangle_edges`
    uint element_count;  // edges or triangles of the mesh, whichever the shader goes through
    uint id;             // of the instance; the highest bit: it mirrors
};

#endif
