// Depth alone; with PEEL only what lies behind the first layer, for the midpoint bias.
#ifdef PEEL
layout(binding = 0) uniform sampler2DArray first_layer;
uniform int layer;
#endif

void main() {
#ifdef PEEL
    float first = texelFetch(first_layer, ivec3(gl_FragCoord.xy, layer), 0).r;
    if (gl_FragCoord.z >= first) {
        discard;
    }
#endif
}
