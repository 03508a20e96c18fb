// Instances and jobs as the silhouette shaders see them. Included by C++ and GLSL, which reads them as texels.
#ifndef PENUMBRA_SILHOUETTE_INSTANCE_H
#define PENUMBRA_SILHOUETTE_INSTANCE_H

// Draws of up to this many vertices per silhouette edge have a command.
#define PENUMBRA_MAX_VERTICES_PER_EDGE 256

struct SilhouetteInstance {
    vec4 rows[3];         // texels 0 .. 2: relative to the pass's origin from recentred local
    vec4 light;           // 3: FacingFrame::light(), for the planes
    vec4 light_high;      // 4: recentred local times the frame's scale, rounded; w = 1; a sun: unit direction, w = 0
    vec4 light_low;       // 5: xyz what rounding took from light_high; w the frame's scale
    uint first_vertex;    // 6: of the mesh in `positions`
    uint first_triangle;  // in `indices`
    uint first_plane;     // in `planes` and `triangle_edges`
    uint first_edge;      // in `edges`
    uint first_more;      // 7: in `more_sides`
    uint id;              // of the instance
    uint mirrored;        // 1 if its transform mirrors
    uint padding0;
};
#define PENUMBRA_INSTANCE_TEXELS 8u

// What one work group sifts.
struct SilhouetteJob {
    uint slot;         // in `instances`
    uint first;        // in `edges` or in `planes`
    uint count;        // of edges or triangles
    uint first_plane;  // of the mesh
};

#endif
