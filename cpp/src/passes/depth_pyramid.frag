// One level of a depth pyramid from the one below: 2 x 2 texels, and at the last column and row of an odd size 3.
layout(binding = 2) uniform sampler2DArray below;  // its base level is the one to read
uniform int layer;

layout(location = 0) out vec2 range;  // largest, smallest

vec2 read(ivec2 at) {
    vec4 texel = texelFetch(below, ivec3(at, layer), 0);
#if FIRST
    return texel.rr;
#else
    return texel.rg;
#endif
}

void main() {
    ivec2 texel = ivec2(gl_FragCoord.xy);
    ivec2 size = textureSize(below, 0).xy;
    ivec2 first = min(2 * texel, size - 1);
    ivec2 last = mix(min(first + 1, size - 1), size - 1, equal(texel, max(size / 2, 1) - 1));
    range = read(first);
    for (int y = first.y; y <= last.y; ++y) {
        for (int x = first.x; x <= last.x; ++x) {
            vec2 found = read(ivec2(x, y));
            range = vec2(max(range.x, found.x), min(range.y, found.y));
        }
    }
}
