// Lets the pixels through that may lie in a penumbra, for a stencil to mark them.
#include "lib/mask_class.glsl"

layout(binding = 0) uniform sampler2D classes;

void main() {
    if (texelFetch(classes, ivec2(gl_FragCoord.xy), 0).r != PENUMBRA_MASK_MAYBE) {
        discard;
    }
}
