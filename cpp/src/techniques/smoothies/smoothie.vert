// One point per silhouette record; smoothie.geom does the rest.
flat out int record_index;

void main() {
    record_index = gl_VertexID;
    gl_Position = vec4(0.0);
}
