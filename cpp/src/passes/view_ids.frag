flat in uint seen_instance;
layout(location = 0) out uvec2 ids;  // instance + 1 (0: nothing seen), triangle of its mesh

void main() {
    ids = uvec2(seen_instance + 1u, uint(gl_PrimitiveID));
}
