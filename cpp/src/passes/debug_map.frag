// A depth map in grey, the nearest surface brightest: a background for overlays.
#include "lib/map_lookup.glsl"

layout(binding = 2) uniform sampler2DArray depth_map;
uniform int layer;
layout(location = 0) out vec4 colour;

void main() {
    float stored = texelFetch(depth_map, ivec3(gl_FragCoord.xy, layer), 0).r;
    colour = vec4(vec3(0.08 + 0.5 * sqrt(clamp(stored, 0.0, 1.0))), 1.0);
}
