// Depth and penumbra map into one image, so that a lookup fetches once. Drawing the penumbra into it directly would
// read and write one texture at once, which OpenGL leaves undefined.
layout(binding = 2) uniform sampler2DArray depth_map;
layout(binding = 3) uniform sampler2DArray penumbra_map;
uniform int layer;
layout(location = 0) out vec2 both;

void main() {
    ivec3 texel = ivec3(gl_FragCoord.xy, layer);
    both = vec2(texelFetch(depth_map, texel, 0).r, texelFetch(penumbra_map, texel, 0).r);
}
