// One colour for the triangles of cones and sheets.
layout(location = 0) out vec4 result;

void main() {
    result = vec4(1.0, 0.55, 0.1, 1.0);
}
