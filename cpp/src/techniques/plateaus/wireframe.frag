// The slopes' triangles as lines, for people.
flat in vec4 ends;
flat in vec4 scales;
#if PART >= 2
in float lambda;
#endif
layout(location = 0) out vec4 colour;
void main() {
    bool cone = PART == 3 || ends.xy == ends.zw;
#if HIDDEN
    colour = vec4(0.85, 0.1, 0.1, 1.0);
#else
    colour = cone ? vec4(0.95, 0.55, 0.1, 1.0) : vec4(0.15, 0.45, 0.9, 1.0);
#endif
}
