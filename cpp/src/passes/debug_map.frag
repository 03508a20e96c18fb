// A depth map in grey, the nearest surface brightest: a background for overlays.
#include "lib/map_lookup.glsl"

layout(binding = 2) uniform sampler2DArray depth_map;
uniform int layer;
uniform vec2 dark_bright;  // stored depths
layout(location = 0) out vec4 colour;

void main() {
    float stored = texelFetch(depth_map, ivec3(gl_FragCoord.xy, layer), 0).r;
    float share = clamp((stored - dark_bright.x) / (dark_bright.y - dark_bright.x), 0.0, 1.0);
    colour = vec4(vec3(stored > 0.0 ? 0.1 + 0.55 * share : 0.03), 1.0);
}
