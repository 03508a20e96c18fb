// Lets pixels through that are tagged; with CLEAR_DEPTH, those that are not, and writes depth 0 there.
#include "techniques/hybrid/classes.glsl"

layout(binding = 1) uniform usampler2D classes;

void main() {
    bool tagged = texelFetch(classes, ivec2(gl_FragCoord.xy), 0).r == kTagged;
#ifdef CLEAR_DEPTH
    if (tagged) {
        discard;
    }
    gl_FragDepth = 0.0;
#else
    if (!tagged) {
        discard;
    }
#endif
}
