// One depth map's frusta as the shaders see them. Included by C++ and GLSL; std140.
#ifndef PENUMBRA_MAP_BLOCK_H
#define PENUMBRA_MAP_BLOCK_H

#define PENUMBRA_MAX_FACES 6

struct MapFaceBlock {
    vec4 x_ls_from_rel;  // rows of the rotation from light-relative world axes to the map's axes; w unused
    vec4 y_ls_from_rel;
    vec4 z_ls_from_rel;
    vec4 low_high;       // xy low, zw high corner of the extent (x/z, y/z; orthographic: metres)
    vec4 texel_from_ls;  // xy factor, zw offset from the extent's coordinates to texels
    vec4 step_ls;        // xy texel in the extent's coordinates, z the wider of the two, w unused
    vec4 range_m;        // x near, y far (orthographic), z 1 if orthographic, w unused
};

struct MapBlock {
    vec4 origin_cr;      // xyz the map's origin relative to the eye, metres
    vec4 light_cr;       // xyz the light point relative to the eye, w = 1; sun: xyz unit direction towards it, w = 0
    ivec4 counts;        // x faces in use, y size_px; z, w unused
    MapFaceBlock faces[PENUMBRA_MAX_FACES];
};

#endif
