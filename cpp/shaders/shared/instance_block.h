// Placed meshes as the shaders see them. Included by C++ and GLSL; std430.
#ifndef PENUMBRA_INSTANCE_BLOCK_H
#define PENUMBRA_INSTANCE_BLOCK_H

// Relative to the pass's origin from recentred local: row-major 3 x 4, world axes, metres.
struct InstanceBlock {
    vec4 rows[3];
};

// The same relative to the eye in float64, and where the instance's data begin.
struct InstanceExact {
    dvec4 rows[3];
    uint first_index;     // of the mesh in `indices`, in uints
    uint first_vertex;    // of the mesh in `positions`, in vertices
    uint first_normal;    // of the mesh in `corner_normals`, in floats; 0xffffffff if flat
    uint first_material;  // of the mesh in `materials`; 0xffffffff if there is one only
    uint first_albedo;    // in `albedos`
    uint albedo_count;
    uint padding0;
    uint padding1;
};

#endif
