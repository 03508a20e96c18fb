// lambda of one edge or vertex at a texel; the darkest stays (GL_MIN, or LESS with the slope as depth).
#include "techniques/plateaus/plateau.glsl"

flat in vec4 ends;
flat in vec4 scales;
#if PART >= 2
in float lambda;
#endif

#if STORE_DEPTH
uniform vec2 hither_yon;
#else
layout(location = 0) out float slope;
#endif
#if HEIGHTS
layout(location = 1) out float darkest;  // lambda in 12 bits, then the height that throws it in 12, the higher first
#endif
#if SIDES == 2
layout(binding = 2) uniform sampler2DArray umbra;

// 1 where a point of the plane is outside the hard shadow.
float lit_at(vec2 p) {
    ivec2 texel = clamp(ivec2(floor((p - PLANE.window.xy) * PLANE.window.w)), ivec2(0), PLANE.size.xy - 1);
    return texelFetch(umbra, ivec3(texel, plane_index), 0).r;
}
#endif

void main() {
    vec2 p = PLANE.window.xy + PLANE.window.z * gl_FragCoord.xy;
    Nearest found;
#if PART >= 2
    found.lambda = max(lambda, 0.0);
    found.t = 0.0;
#else
    vec3 q = to_light(p);
    vec3 a = back_project(ends.xy - p, scales.x, q);
    vec3 b = back_project(ends.zw - p, scales.y, q);
#if SHEET == 1
    bool cone = ends.xy == ends.zw;
    found.t = 0.0;
    found.lambda = cone ? (a.z > 0.0 ? length(a.xy) / a.z : kFar) : bilinear_sheet(a, b);
#else
    found = nearest_on_edge(a, b);
#endif
#endif

#if SIDES == 2
    // Both halves of the penumbra: the visible part of the light cut by a straight edge. Inside the hard shadow an
    // edge counts only where the light comes in: just beyond it, half-way and at the reach nothing else blocks.
    vec2 c = mix(ends.xy, ends.zw, found.t);
    float distance = length(c - p);
    vec2 outwards = distance > 1e-3 * PLANE.window.z ? (c - p) / distance : normalize(right_of(ends.zw - ends.xy));
    float reach = found.lambda > 1e-3 ? distance / found.lambda : 0.0;
    float free = min(lit_at(c + 1.5 * PLANE.window.z * outwards),
                     min(lit_at(c + 0.5 * reach * outwards), lit_at(c + reach * outwards)));
    bool inside = texelFetch(umbra, ivec3(gl_FragCoord.xy, plane_index), 0).r < 0.5;
    float seen = cut(found.lambda, found.normal);
    // Negative inside, so that the smallest value is the brightest there and the darkest outside.
    slope = found.lambda >= 1.0 ? (inside ? 0.0 : 1.0) : (inside ? (free > 0.5 ? seen - 1.0 : 0.0) : seen);
#elif STORE_DEPTH
    gl_FragDepth = mix(hither_yon.x, hither_yon.y, min(found.lambda, 1.0));
#else
    slope = min(found.lambda, 1.0);
#endif
#if HEIGHTS
    float height = clamp(mix(scales.z, scales.w, found.t) / PLANE.heights.y, 0.0, 1.0);
    darkest = floor(min(found.lambda, 1.0) * 4095.0) * 4096.0 + floor((1.0 - height) * 4095.0);
#endif
}
