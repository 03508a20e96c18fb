// The light's shape in the plane z_ls = 0, as the base that every cone rests on (geometry/cone_base.h).
// CONE_BASE: 0 ellipse (the unit disc of lib/edge_space.glsl), 1 polygon of LIGHT_CORNERS corners (2: a segment),
// 2 sphere. "Displacement": offset in the image plane, unit lengths, per difference in w.
#include "lib/light_ramp.glsl"

uniform float light_reach;  // length of the longest displacement; sphere: its radius
#if CONE_BASE == 1
uniform vec4 light_corner[LIGHT_CORNERS];  // xy; counter-clockwise in the map
uniform vec4 light_side[LIGHT_CORNERS];    // xy: normals of the reflected outline over their distance from 0
#endif

// Fraction of the light with dot(n, q) > -x, n of unit length: what is seen past a straight edge.
float light_fraction(vec2 n, float x) {
#if CONE_BASE == 1
    vec2 t = vec2(n.y, -n.x);
    float part = 0.0, whole = 0.0;
    for (int k = 0; k < LIGHT_CORNERS; ++k) {
        vec2 a = light_corner[k].xy;
        vec2 b = light_corner[k + 1 < LIGHT_CORNERS ? k + 1 : 0].xy;
        vec2 s = vec2(dot(n, a), dot(n, b)) + x;
        vec2 above = max(s, 0.0);
        float difference = s.x - s.y;
        bool level = abs(difference) < 1e-5 * light_reach;
#if LIGHT_CORNERS == 2
        part = level ? (s.x + s.y > 0.0 ? 1.0 : 0.0) : (above.x - above.y) / difference;
        whole = 1.0;
#else
        float mean = level ? 0.5 * (above.x + above.y)
                           : 0.5 * (above.x * above.x - above.y * above.y) / difference;
        part -= dot(t, b - a) * mean;
        whole -= dot(t, b - a) * 0.5 * (s.x + s.y);
#endif
    }
    return clamp(part / max(whole, 1e-30), 0.0, 1.0);
#else
    return disc_fraction(x);
#endif
}

// Depth in w below its apex at which a cone has the offset d.
float cone_depth(vec2 d) {
#if CONE_BASE == 1
    float depth = 0.0;
    for (int k = 0; k < LIGHT_CORNERS; ++k) {
        depth = max(depth, dot(light_side[k].xy, d));
    }
    return depth;
#else
    return length(d);
#endif
}

#if CONE_BASE == 2
// A sphere's outline seen from the apex: wider along the radius from the map's axis, and by its nearness.
vec2 stretch(vec2 d, vec3 apex, bool inverse) {
    float squared = dot(apex.xy, apex.xy);
    float along = sqrt(1.0 + squared);
    float sine = light_reach * apex.z / along;
    float scale = light_reach / sqrt(max(1.0 - sine * sine, 1e-4));
    vec2 radial = squared > 0.0 ? apex.xy * inversesqrt(squared) : vec2(0.0);
    return inverse ? (d + radial * dot(radial, d) * (1.0 / along - 1.0)) / scale
                   : (d + radial * dot(radial, d) * (along - 1.0)) * scale;
}
#endif
