// Alpha of a smoothie's fragment, remapped by the depth of what receives it [Chan2004, Eq. 1], and the smoothie's depth.
// 0 at the silhouette .. 1 at the rim. Combined by minimum, so 1 says nothing.
#include "lib/map_lookup.glsl"
#include "lib/map_space.glsl"
#include "techniques/smoothies/ramp.glsl"

layout(binding = 4) uniform sampler2DArray receiver_map;
uniform float u_far;

flat in vec4 line;
flat in vec3 along;
#if RESIZE_PER_VERTEX
flat in vec2 widths;
#endif

#if TARGET == 0  // alpha alone
layout(location = 0) out float alpha_out;
#elif TARGET == 1  // alpha, and less depth, both kept by GL_MIN
layout(location = 0) out vec2 alpha_out;
#endif
// TARGET 2: depth alone, kept by the depth test; 3: as 0

void main() {
    vec2 p = ip_from_texel(face_index, gl_FragCoord.xy) - line.xy;
    float foot = clamp(dot(p, line.zw), 0.0, along.x);
    vec2 away = p - foot * line.zw;
    float distance = length(away);
    float u_b = along.y + foot * along.z;
    float u_r = max(texelFetch(receiver_map, ivec3(gl_FragCoord.xy, face_index), 0).r, u_far);
#if WIDTH_SHAPE == 0
    float half_width = axes.x;
#else
    float half_width = half_width(distance > 0.0 ? away / distance : vec2(-line.w, line.z));
#endif
#if RESIZE_PER_VERTEX
    float width = u_b > u_r ? mix(widths.x, widths.y, along.x > 0.0 ? foot / along.x : 0.0) : 0.0;
#else
    float width = ramp_width(half_width, u_b, u_r);
#endif
    // Hidden smoothies have no width: 0 < 0 is false, so 0/0 counts as lit.
    float alpha = distance < width ? distance / width : 1.0;
#if TARGET == 0 || TARGET == 3
    alpha_out = alpha;
#elif TARGET == 1
    alpha_out = vec2(alpha, alpha < 1.0 ? -u_b : 0.0);
#else
    if (alpha >= 1.0) {
        discard;
    }
    gl_FragDepth = u_b;
#endif
}
