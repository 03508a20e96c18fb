flat in uint seen_instance;
#ifdef CUT_RANGE
in vec2 depth_over;
#endif
layout(location = 0) out uvec2 ids;  // instance + 1 (0: nothing seen), triangle of its mesh

void main() {
#ifdef CUT_RANGE
    if (depth_over.x > depth_over.y || depth_over.x < 0.0) {
        discard;  // nearer than the near plane, or beyond the far one
    }
#endif
    ids = uvec2(seen_instance + 1u, uint(gl_PrimitiveID));
}
