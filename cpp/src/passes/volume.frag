// Fragments of shadow volumes. With stencil counting nothing is left to do here. COUNT_IN_IMAGE adds to 32-bit counts;
// MASK_BY_CLASS leaves out pixels of another class than the wanted one.
#ifdef COUNT_IN_IMAGE
layout(early_fragment_tests) in;
layout(binding = 0, r32i) uniform iimage2D counts;
uniform int front_adds;
#endif
#ifdef MASK_BY_CLASS
layout(binding = 1) uniform usampler2D classes;
uniform uint wanted_class;
#endif
#ifdef COUNT_FRAGMENTS
layout(location = 0) out float fragments;
#endif

void main() {
#ifdef MASK_BY_CLASS
    if (texelFetch(classes, ivec2(gl_FragCoord.xy), 0).r != wanted_class) {
        discard;
    }
#endif
#ifdef COUNT_IN_IMAGE
    imageAtomicAdd(counts, ivec2(gl_FragCoord.xy), gl_FrontFacing ? front_adds : -front_adds);
#endif
#ifdef COUNT_FRAGMENTS
    fragments = 1.0;
#endif
}
