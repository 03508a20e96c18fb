// The flat top of the plateau.
#if STORE_DEPTH
uniform vec2 hither_yon;
void main() {
    gl_FragDepth = hither_yon.x;
}
#else
layout(location = 0) out float slope;
#if UMBRA_COPY
layout(location = 1) out float umbra;
#endif
void main() {
    slope = 0.0;
#if UMBRA_COPY
    umbra = 0.0;
#endif
}
#endif
