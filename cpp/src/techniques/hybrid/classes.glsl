// What the hybrid's classification says of a pixel.
const uint kMapLit = 0u;
const uint kMapShadow = 1u;
const uint kTagged = 2u;   // the map's texels differ: the volumes decide
const uint kBack = 3u;     // turned away from the light's centre
const uint kOutside = 4u;  // in none of the map's faces
const uint kNothing = 5u;  // background
