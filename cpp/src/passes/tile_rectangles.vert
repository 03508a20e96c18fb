// A strip of four vertices over each wanted tile.
#include "lib/wanted_tiles.glsl"

uniform vec2 tiles_per_view;

void main() {
    WantedTile tile = wanted_tiles[gl_InstanceID];
    vec2 corner = vec2(tile.column, tile.row) + vec2(gl_VertexID & 1, gl_VertexID >> 1);
    gl_Position = vec4(2.0 * corner / tiles_per_view - 1.0, 0.0, 1.0);
}
