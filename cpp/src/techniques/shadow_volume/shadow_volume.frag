// Shadow volumes [Crow1977]: dark where anything is counted between the light's centre and the surface.
#include "lib/receiver.glsl"

layout(binding = 0) uniform usampler2D receivers;
#ifdef COUNT_IN_IMAGE
layout(binding = 2) uniform isampler2D counts;
#else
layout(binding = 2) uniform usampler2D counts;
#endif
layout(location = 0) out float visibility;

void main() {
    ivec2 pixel = ivec2(gl_FragCoord.xy);
    // The background lies at the far caps' depth, so its counts mean nothing.
    bool seen = texelFetch(receivers, pixel, 0).w != 0u;
    visibility = seen && int(texelFetch(counts, pixel, 0).r) != 0 ? 0.0 : 1.0;
}
