// The weighted mean over the light's samples.
layout(binding = 0) uniform sampler2D sums_texture;
#if MASK
#include "lib/mask_class.glsl"
layout(binding = 4) uniform sampler2D classes;
#endif

layout(location = 0) out float visibility;

void main() {
    vec2 sums = texelFetch(sums_texture, ivec2(gl_FragCoord.xy), 0).rg;
    // All lit is exactly 1, also where a driver divides by way of a rounded reciprocal.
    visibility = sums.x >= sums.y ? 1.0 : clamp(sums.x / sums.y, 0.0, 1.0);
#if MASK
    float found = texelFetch(classes, ivec2(gl_FragCoord.xy), 0).r;
    visibility = found == PENUMBRA_MASK_MAYBE ? visibility : (found > 1.5 / 255.0 ? 0.0 : 1.0);
#endif
}
