// The mean over the lines that stand for a light.
layout(binding = 0) uniform sampler2D sums_texture;

layout(location = 0) out float visibility;

void main() {
    vec2 sums = texelFetch(sums_texture, ivec2(gl_FragCoord.xy), 0).rg;
    // All lit is exactly 1, also where a driver divides by way of a rounded reciprocal.
    visibility = sums.x >= sums.y ? 1.0 : clamp(sums.x / sums.y, 0.0, 1.0);
}
