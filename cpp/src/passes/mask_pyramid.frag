// One level of the pyramid of nearest edges: the largest of 2 x 2 texels of the level below.
layout(binding = 2) uniform sampler2DArray below;  // its base level is the one to read
uniform int layer;

layout(location = 0) out float nearest;

void main() {
    ivec2 at = 2 * ivec2(gl_FragCoord.xy);
    ivec2 last = textureSize(below, 0).xy - 1;
    float a = texelFetch(below, ivec3(min(at, last), layer), 0).r;
    float b = texelFetch(below, ivec3(min(at + ivec2(1, 0), last), layer), 0).r;
    float c = texelFetch(below, ivec3(min(at + ivec2(0, 1), last), layer), 0).r;
    float d = texelFetch(below, ivec3(min(at + ivec2(1, 1), last), layer), 0).r;
    nearest = max(max(a, b), max(c, d));
}
