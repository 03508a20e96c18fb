// I = (Zf - Zv) / (Zp - Zv), then the falloff, under one facet of the published construction.
#include "lib/map_lookup.glsl"
#include "lib/map_space.glsl"
#include "lib/edge_space.glsl"
#include "lib/light_ramp.glsl"
#include "techniques/penumbra_maps/ramp.glsl"

layout(binding = 2) uniform sampler2DArray receiver_map;

in vec2 z_edge_here;
layout(location = 0) out float intensity;

void main() {
    float stored = texelFetch(receiver_map, ivec3(gl_FragCoord.xy, face_index), 0).r;
    float z_surface = linear_depth(face_index, stored);
    float z_edge = z_edge_here.x;
    float z_here = z_edge_here.y;
#if RAMP == 0 || MAP_ORTHOGRAPHIC
    float t = (z_here - z_edge) / (z_surface - z_edge);
#else
    float t = (z_here - z_edge) / (z_surface - z_edge) * (z_surface / z_here);
#endif
    bool behind = z_here > z_surface || too_close(w_from_depth(z_edge), w_from_stored(face_index, stored));
    float value = behind ? 1.0 : fall_off(clamp(t, 0.0, 1.0));
    intensity = value;
#if COMBINE_LESS
    gl_FragDepth = value;
#endif
}
