// A rectangle of a depth map at one depth, as a strip of four vertices.
uniform vec4 low_high;  // in clip coordinates
uniform float depth;

void main() {
    gl_Position = vec4((gl_VertexID & 1) != 0 ? low_high.z : low_high.x, (gl_VertexID & 2) != 0 ? low_high.w : low_high.y,
                       depth, 1.0);
}
