// What sift.vert of `plateaus` lists for a plane, as indirect draws and counts. Included by C++ and GLSL; std430.
#ifndef PENUMBRA_PLATEAU_DRAWS_H
#define PENUMBRA_PLATEAU_DRAWS_H

#define PENUMBRA_PLATEAU_TILE 32  // texels, side of a tile that wide slopes are cut to

struct PlateauDraw {
    uint count, instance_count, first, base_instance;
};

struct PlaneDraws {
    uint kept;             // records listed as a whole
    uint in_window;        // records with bounds in the window
    uint hidden;           // records of those that are not listed at all
    uint tiles;            // pieces of records listed tile by tile
    PlateauDraw draws[6];  // of whole records, then of pieces
    PlateauDraw wide;      // of records that are to be cut to pieces, one vertex each
};

#endif
