// Intensity of the surface that the light sees at this texel, under one cone or sheet [P 2.5]; kept where it is the
// least, by minimum blending or (COMBINE_LESS) by the depth test.
#include "lib/map_lookup.glsl"
#include "lib/map_space.glsl"
#include "lib/edge_space.glsl"
#include "techniques/penumbra_maps/light_base.glsl"
#include "techniques/penumbra_maps/ramp.glsl"

layout(binding = 2) uniform sampler2DArray receiver_map;

in vec2 from_point;
in vec2 w_edge_here;
#if NEEDS_FOOT
in vec2 foot;
flat in vec3 edge_line;
#endif
layout(location = 0) out float intensity;

void main() {
    float w_surface = w_from_stored(face_index, texelFetch(receiver_map, ivec3(gl_FragCoord.xy, face_index), 0).r);
    float w_edge = w_edge_here.x;
    float w_here = w_edge_here.y - cone_depth(from_point);
    float gap = w_edge - w_surface;
    float t = (w_edge - w_here) / gap;
    bool behind = w_here < w_surface || too_close(w_edge, w_surface);
#if NEEDS_FOOT
    // The line in which the plane of receiver and edge cuts the light: normal m over its length, x from the centre.
    bool cone = edge_line.x == 0.0 && edge_line.y == 0.0;
    vec2 along = vec2(edge_line.y, -edge_line.x);
    vec2 m = cone ? from_point * gap : edge_line.xy * (foot.y - w_surface) - along * (edge_line.z * foot.x);
    float m_length = length(m);
    float x = (cone ? dot(from_point, from_point) : foot.x) / max(m_length, 1e-30);
#endif
#if RAMP == 0 && !MAP_ORTHOGRAPHIC
    t *= w_surface / w_here;
#elif RAMP == 2 && CONE_BASE == 0
    t = x;
#endif
    t = clamp(t, 0.0, 1.0);
#if FALLOFF == 2 && CONE_BASE == 1
    // V at the hard edge is 1/2 for shapes that are their own reflection only.
    float fraction = light_fraction(m / max(m_length, 1e-30), x);
#if SIDES_BOTH
    float value = fraction;
#else
    float at_edge = light_fraction(m / max(m_length, 1e-30), 0.0);
    float value = clamp((fraction - at_edge) / max(1.0 - at_edge, 1e-6), 0.0, 1.0);
#endif
#else
    float value = fall_off(t);
#endif
    if (behind) {
        value = 1.0;
    }
    intensity = value;
#if COMBINE_LESS
    gl_FragDepth = value;
#endif
}
