// Casters and jobs as the volume shader sees them. Included by C++ and GLSL; std430.
#ifndef PENUMBRA_VOLUME_SLOT_H
#define PENUMBRA_VOLUME_SLOT_H

struct VolumeSlot {
    vec4 light;            // FacingFrame::light(), for the planes
    uint first_vertex;     // of the mesh among all
    uint first_triangle;   // in `indices`
    uint first_plane;      // in `planes`
    uint first_edge;       // in `edges`
    uint first_more;       // in `more_sides`
    uint faces;            // 0 towards the light, 1 averted, 2 all
    uint wound_command;    // that draws what is wound as the mesh is
    uint flipped_command;  // and averted near caps
    uint near_caps;        // 1: drawn
    uint far_caps;
    uint far_edges;
    uint padding0;
};

// What one work group does.
struct VolumeJob {
    uint slot;
    uint first;  // triangle or edge of the mesh
    uint count;
    uint edges;  // 1: edges, 0: triangles
};

// What one work group of the sieve by tiles does.
struct VolumeSiftJob {
    uint command;
    uint first;  // triangle of the command
    uint count;
    uint z_pass;  // 1: fragments that pass count
};

struct VolumeCommand {
    uint count;  // grows as indices are appended
    uint instance_count;
    uint first_index;
    uint base_vertex;
    uint base_instance;
};

#endif
