// One colour.
uniform vec3 colour;
layout(location = 0) out vec4 result;

void main() {
    result = vec4(colour, 1.0);
}
