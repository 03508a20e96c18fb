// Nearest and farthest depth of two windows, one `further` on, as one.
layout(binding = 2) uniform sampler2DArray windows;
uniform int layer;
uniform ivec2 further;

layout(location = 0) out vec2 range;  // largest, smallest

vec2 read(ivec2 at) {
    vec4 texel = texelFetch(windows, ivec3(min(at, textureSize(windows, 0).xy - 1), layer), 0);
#if FIRST
    return texel.rr;
#else
    return texel.rg;
#endif
}

void main() {
    vec2 a = read(ivec2(gl_FragCoord.xy)), b = read(ivec2(gl_FragCoord.xy) + further);
    range = vec2(max(a.x, b.x), min(a.y, b.y));
}
