// Position and geometric normal of a pixel in one texel, so that a lookup reads the view once.
// xyz: bits of the position relative to the eye; w: octahedral normal, 16 bits an axis (within 6.5e-5 rad), 0: nothing.
// Written by passes/receiver_texel.cpp.

// Not of unit length: a plane's slope in a map and the side it faces do not depend on it.
vec3 unpack_normal(uint packed_normal) {
    vec2 o = 2.0 * unpackUnorm2x16(packed_normal) - 1.0;
    vec3 n = vec3(o, 1.0 - abs(o.x) - abs(o.y));
    float fold = max(-n.z, 0.0);
    n.x += n.x >= 0.0 ? -fold : fold;
    n.y += n.y >= 0.0 ? -fold : fold;
    return n;
}

struct Receiver {
    vec3 position_cr;
    vec3 normal_ws;  // not unit
    bool seen;
};

Receiver read_receiver(usampler2D receivers, ivec2 pixel) {
    uvec4 bits = texelFetch(receivers, pixel, 0);
    return Receiver(uintBitsToFloat(bits.xyz), unpack_normal(bits.w), bits.w != 0u);
}
