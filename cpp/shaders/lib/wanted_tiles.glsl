// Tiles of a picture that hold wanted pixels, found on the device or sent to it (passes/tile_list.h).
#ifndef PENUMBRA_WANTED_TILES_GLSL
#define PENUMBRA_WANTED_TILES_GLSL

struct WantedTile {
    uint column, row;
    float nearest, farthest;  // of its wanted pixels: reversed depth
};

layout(std430, binding = 0) WANTED_TILES_ACCESS buffer WantedTiles {
    uint vertices;  // an indirect draw: a strip of four for each tile
    uint tile_count;
    uint first_vertex;
    uint first_instance;
    WantedTile wanted_tiles[];
};

#endif
