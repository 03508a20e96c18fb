// Receiver planes with their light as the shaders of `plateaus` see them. Included by C++ and GLSL; std140.
#ifndef PENUMBRA_PLATEAU_BLOCK_H
#define PENUMBRA_PLATEAU_BLOCK_H

#define PENUMBRA_MAX_PLANES 15
#define PENUMBRA_MAX_PLATEAU_CORNERS 8

// Plane coordinates: x and y in the plane, z = h above it, metres, from the middle of the seen rectangle.
// Light coordinates: of the light's own plane from its centre, such that its shape has the size of 1.
struct PlateauPlane {
    vec4 x_from_rel;   // rows: plane coordinates from positions relative to the pass's origin; w the offset
    vec4 y_from_rel;
    vec4 h_from_rel;
    vec4 window;       // xy low corner of the texture, z texel width, w 1 over it
    vec4 light;        // light point (w = 1) or unit direction towards the sun (w = 0), plane coordinates
    vec4 half_u;       // the light's half axes as plane vectors; w core.x of its rounded box
    vec4 half_v;       // w core.y
    vec4 dual_u;       // light coordinate = dot(dual, offset in the light's plane); w radius of the rounded box
    vec4 dual_v;       // w radius of a ball, whose light coordinates hang on the receiver; 0: not a ball
    vec4 normal;       // of the light's plane, any length; w least sigma
    vec4 heights;      // x least height that casts, y largest; z: sigma = z h (linear radii), 0: h / (H - h); w unused
    ivec4 size;        // xy texture in use, px; z corners of a polygon; w unused
    vec4 corner[PENUMBRA_MAX_PLATEAU_CORNERS];  // xy polygon in light coordinates, counter-clockwise
};

struct PlateauBlock {
    vec4 origin_cr;    // of the pass, relative to the eye
    ivec4 counts;      // x planes
    PlateauPlane planes[PENUMBRA_MAX_PLANES];
};

#endif
