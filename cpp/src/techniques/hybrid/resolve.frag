// The hybrid's last step [Chan2004]: the map's word where its texels agree, the volumes' where they do not.
#include "techniques/hybrid/classes.glsl"

layout(binding = 1) uniform usampler2D classes;
#ifdef COUNT_IN_IMAGE
layout(binding = 2) uniform isampler2D counts;
#else
layout(binding = 2) uniform usampler2D counts;
#endif
layout(location = 0) out float visibility;

void main() {
    ivec2 pixel = ivec2(gl_FragCoord.xy);
    uint found = texelFetch(classes, pixel, 0).r;
    int count = int(texelFetch(counts, pixel, 0).r) & COUNT_BITS;
    bool dark = found == kTagged ? count != 0 : found == kMapShadow || found == kBack;
    visibility = dark ? 0.0 : 1.0;
}
