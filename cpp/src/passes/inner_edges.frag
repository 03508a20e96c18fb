// Keeps the nearest edge of each texel, by distance over reach (which the depth test compares).
#include "lib/map_lookup.glsl"
#include "lib/map_space.glsl"
#include "lib/edge_space.glsl"

layout(binding = 2) uniform sampler2DArray depth_map;
uniform vec2 reach;

in vec2 inward;
in float w_edge;
layout(location = 0) out vec4 edge;

void main() {
    float inside = length(inward);
    vec2 normal = inside > 0.0 ? -inward / inside : vec2(1.0, 0.0);
    float widest = reach.x + reach.y * (w_edge - edge_range.z);
    float share = inside / max(widest, 1e-30);
    // An edge with a caster right behind it in the picture, and no deeper, is no edge of any shadow.
    vec2 scale = MAP_FACE(face_index).texel_from_ls.xy;
    vec2 step_texels = normalize(from_unit(normal) * scale);
    vec2 beyond = gl_FragCoord.xy - from_unit(inward) * scale + 1.5 * step_texels;
    ivec2 at = clamp(ivec2(floor(beyond)), ivec2(0), ivec2(map.counts.y - 1));
    bool in_map = all(equal(at, ivec2(floor(beyond))));
    float stored = texelFetch(depth_map, ivec3(at, face_index), 0).r;
    bool hidden = in_map && stored > 0.0 &&
                  w_from_stored(face_index, stored) >= w_edge - 0.05 * (w_edge - edge_range.z);
    if (hidden || share >= 1.0) {
        discard;
    }
    // Where two edges are equally near, which one is kept must not depend on the order of drawing.
    gl_FragDepth = share * 0.99999 + 1e-5 * (0.5 + 0.3 * normal.x + 0.15 * normal.y);
    edge = vec4(normal, inside, w_edge);
}
