// Depth 0 at texels that no pixel looks up, so that no slope is computed there.
layout(binding = 6) uniform sampler2DArray wanted;
uniform int plane_index;
void main() {
    if (texelFetch(wanted, ivec3(gl_FragCoord.xy, plane_index), 0).r > 0.5) {
        discard;
    }
    gl_FragDepth = 0.0;
}
