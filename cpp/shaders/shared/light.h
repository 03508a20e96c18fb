// One light as the shaders see it. Included by C++ (geometry/light_block.h) and by GLSL; std140: vec4 only.
#ifndef PENUMBRA_SHARED_LIGHT_H
#define PENUMBRA_SHARED_LIGHT_H

// Values of LightBlock.emission_form.w: how the light radiates once its degenerate cases are told apart. `emission`
// is what the function in lib/irradiance.glsl is multiplied by, see geometry/radiometry.h.
#define PENUMBRA_LIGHT_NONE 0         // gives no light at all
#define PENUMBRA_LIGHT_POINT 1        // emission: intensity, W/sr
#define PENUMBRA_LIGHT_FACING_POINT 2 // area light without extent: intensity along the normal, W/sr, times a cosine
#define PENUMBRA_LIGHT_SPHERE 3       // emission: radiance, W/(m^2 sr)
#define PENUMBRA_LIGHT_DIRECTION 4    // sun of angle 0; emission: irradiance, W/m^2
#define PENUMBRA_LIGHT_SUN 5          // emission: radiance
#define PENUMBRA_LIGHT_LINE 6         // emission: radiance x diameter, W/(m sr)
#define PENUMBRA_LIGHT_FACING_LINE 7  // area light without width: radiance x width, W/(m sr), times a cosine
#define PENUMBRA_LIGHT_ELLIPSE 8      // emission: radiance
#define PENUMBRA_LIGHT_POLYGON 9      // emission: radiance

#define PENUMBRA_MAX_LIGHT_CORNERS 8

struct LightBlock {
    vec4 centre_cr;      // xyz centre relative to the eye, metres (sun: unused); w radius_m (sphere kinds)
    vec4 direction;      // xyz unit, direction in which it shines; w number of corners (polygon)
    vec4 half_u;         // xyz metres: ellipse: longer half axis, line: half the segment; spot: unit x axis; w sun: sin half angle
    vec4 half_v;         // xyz metres: ellipse: shorter half axis, perpendicular; spot: unit y axis; w sun: cos half angle
    vec4 emission_form;  // rgb emission; w one of PENUMBRA_LIGHT_*
    vec4 spot;           // x cosine of half the cone, y blend, zw stretch; x = -2: no cone
    vec4 corner[PENUMBRA_MAX_LIGHT_CORNERS];  // xyz metres from the centre, counter-clockwise seen from the lit side; w unused
};

#endif
