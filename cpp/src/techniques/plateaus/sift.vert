// Lists the silhouettes whose slopes can change a plane's texture: at least one texel of their bounds lies in the
// window, outside the umbra, and is looked up by a pixel. One vertex for each record; nothing is rasterised.
//
// HULL as in bounds.glsl. CONES: 0 none, 1 sectors, 2 whole discs. KEEP_ALL lists everything.
// TILES: slopes that are wider than two tiles are put aside by PASS 0, so that only they cost more. PASS 1 finds for
// each tile how dark it is at least, from those of them that cover it whole; PASS 2 lists them tile by tile, where they
// can be the darkest.
#include "techniques/plateaus/bounds.glsl"
#if PASS > 0
#include "techniques/plateaus/tiles.glsl"
#endif
#include "shared/plateau_draws.h"

layout(std430, binding = 0) readonly buffer Records { SilhouetteRecord records[]; };
layout(std430, binding = 5) buffer Listed { uvec2 listed[]; };
layout(std430, binding = 6) buffer Draws { PlaneDraws planes[]; };
layout(std430, binding = 7) buffer Darkness { uint darkest_bits[]; };  // by tile: lambda is nowhere above
layout(binding = 4) uniform sampler2D covered;
uniform ivec3 vertices_per_edge;
uniform uint first_wide_entry;
uniform uint first_tile_entry;
uniform uint most_tile_entries;

const float kNearby = SIDES == 2 ? 2.0 : 0.5;  // texels around: those that slopes.frag asks whether an edge is free
const int kTile = PENUMBRA_PLATEAU_TILE;

struct Box {
    vec2 low, high;  // texels
};

vec2 texel_of(Slope slope, vec2 at) {
    return (plane_from_circle(slope, at) - PLANE.window.xy) * PLANE.window.w;
}

void widen(inout Box box, vec2 texel) {
    box.low = min(box.low, texel);
    box.high = max(box.high, texel);
}

bool in_window(Box box) {
    return all(greaterThan(box.high, vec2(-kNearby))) && all(lessThan(box.low, vec2(PLANE.size.xy) + kNearby));
}

ivec2 clamped(vec2 texel) {
    return ivec2(clamp(floor(texel), vec2(0.0), vec2(PLANE.size.xy - 1)));
}

// No texel of the box matters: all are looked up by nobody, or `dark_ones_too` all lie under the umbra. Read at the level where the box has no more than 4 x 4 cells, if there is one.
bool hidden(Box box, bool dark_ones_too) {
#if KEEP_ALL
    return false;
#else
    ivec2 low = clamped(box.low - kNearby);
    ivec2 high = clamped(box.high + kNearby);
    int level = 0;
    while (level < 4 && any(greaterThan((high >> (level + 2)) - (low >> (level + 2)), ivec2(3)))) {
        level += 2;
    }
    low >>= level + 2;
    high >>= level + 2;
    vec2 all_of = vec2(1.0);
    for (int y = low.y; y <= high.y && any(greaterThan(all_of, vec2(0.5))); ++y) {
        for (int x = low.x; x <= high.x; ++x) {
            all_of = min(all_of, texelFetch(covered, ivec2(x, y), level).rg);
        }
    }
    return (dark_ones_too && all_of.r > 0.5) || all_of.g > 0.5;
#endif
}

uint parts_of(uint record, bool sheet, bool cone) {
    return record | (sheet ? 0u : kNoSheet) | (cone ? 0u : kNoCone);
}

void list_whole(uint parts) {
    uint at = atomicAdd(planes[plane_index].kept, 1u);
    listed[at] = uvec2(parts, 0u);
    for (int i = 0; i < 3; ++i) {
        atomicAdd(planes[plane_index].draws[i].count, uint(vertices_per_edge[i]));
    }
}

#if PASS > 0
int tile_index(ivec2 tile) {
    return tile.y * ((PLANE.size.x + kTile - 1) / kTile) + tile.x;
}

// Texels of the umbra decide which way a tile is darkest where both sides are drawn.
bool any_umbra(ivec2 tile) {
#if SIDES == 2 && !KEEP_ALL
    float any_of = 0.0;
    for (int y = 0; y < kTile / 16; ++y) {
        for (int x = 0; x < kTile / 16; ++x) {
            any_of = max(any_of, texelFetch(covered, tile * (kTile / 16) + ivec2(x, y), 2).b);
        }
    }
    return any_of > 0.5;
#else
    return false;
#endif
}

// Above this lambda nothing changes, if the tile is as dark as `darkest`.
float beaten_from(ivec2 tile, float darkest) {
#if SIDES == 2
    // What is seen of the light rises with lambda, but a box cut across a corner shows more than one cut along a side.
    float t = GAUGE == 0 ? darkest : (GAUGE == 1 ? 1.0 - (1.0 - darkest) * (1.0 - darkest) : 1.0);
    return any_umbra(tile) ? 1.0 : t;
#else
    return darkest;
#endif
}

// Both wound the same way; texels. `margin` > 0: inside by so much.
bool inside(vec2 corners[4], int count, vec2 at, float winding, float margin) {
    bool within = true;
    for (int i = 0; i < count; ++i) {
        vec2 along = corners[i + 1 < count ? i + 1 : 0] - corners[i];
        vec2 off = at - corners[i];
        within = within && winding * (along.x * off.y - along.y * off.x) >= margin * length(along);
    }
    return within;
}

float area(vec2 corners[4], int count) {
    float sum = 0.0;
    for (int i = 0; i < count; ++i) {
        vec2 a = corners[i] - corners[0];
        vec2 b = corners[i + 1 < count ? i + 1 : 0] - corners[0];
        sum += a.x * b.y - a.y * b.x;
    }
    return sum;
}

bool covers(vec2 corners[4], int count, ivec2 tile) {
    float winding = area(corners, count) < 0.0 ? -1.0 : 1.0;
    vec2 low = float(kTile) * vec2(tile);
    vec2 high = low + float(kTile);
    return inside(corners, count, low, winding, 0.5) && inside(corners, count, high, winding, 0.5) &&
           inside(corners, count, vec2(high.x, low.y), winding, 0.5) &&
           inside(corners, count, vec2(low.x, high.y), winding, 0.5);
}

// True if an edge of the polygon has all of the tile on its outer side.
bool misses(vec2 corners[4], int count, ivec2 tile) {
    float winding = area(corners, count) < 0.0 ? -1.0 : 1.0;
    vec2 low = float(kTile) * vec2(tile);
    vec2 high = low + float(kTile);
    bool apart = false;
    for (int i = 0; i < count; ++i) {
        vec2 along = corners[i + 1 < count ? i + 1 : 0] - corners[i];
        vec2 outer = winding * vec2(along.y, -along.x);
        vec2 nearest = vec2(outer.x > 0.0 ? low.x : high.x, outer.y > 0.0 ? low.y : high.y);
        apart = apart || dot(outer, nearest - corners[i]) > length(outer);
    }
    return apart;
}
#endif

void main() {
    gl_Position = vec4(2.0, 2.0, 2.0, 1.0);
#if PASS > 0
    uint wide = listed[first_wide_entry + uint(gl_VertexID)].x;
    uint index = wide & ~(kNoSheet | kNoCone);
#else
    uint index = uint(gl_VertexID);
#endif
    SilhouetteRecord record = records[index];
    Slope slope = measure(record);
    Box none = Box(vec2(1e30), vec2(-1e30));

    Strip strip = strip_of(slope);
    vec2 quad[4] = vec2[](texel_of(slope, strip.foot0), texel_of(slope, strip.foot1), texel_of(slope, strip.far1),
                          texel_of(slope, strip.far0));
    Box sheet = none;
    for (int i = 0; i < 4; ++i) {
        widen(sheet, quad[i]);
    }
    bool has_sheet = slope.drawn && in_window(sheet);
    bool has_cone = false;
    Box cone = none;
#if CONES == 1
    Sector sector = sector_of(record, slope);
    has_cone = sector.drawn;
    vec2 rays[5];
    rays[0] = texel_of(slope, vec2(0.0));
    widen(cone, rays[0]);
    for (int ray = 0; ray < 4; ++ray) {
        rays[ray + 1] = texel_of(slope, on_border(slope, sector, ray));
        widen(cone, rays[ray + 1]);
    }
#elif CONES == 2
    has_cone = slope.drawn && slope.a_casts && slope.r0 > 0.0;
    vec2 half_size = slope.r0 * vec2(length(vec2(slope.plane_from_circle[0].x, slope.plane_from_circle[1].x)),
                                     length(vec2(slope.plane_from_circle[0].y, slope.plane_from_circle[1].y)));
    vec2 middle = slope.s0 - PLANE.window.xy;
    cone = Box((middle - half_size) * PLANE.window.w, (middle + half_size) * PLANE.window.w);
#endif
    has_cone = has_cone && in_window(cone);
#if PASS > 0
    bool draws_sheet = (wide & kNoSheet) == 0u;
    bool draws_cone = (wide & kNoCone) == 0u;
#else
    bool draws_sheet = has_sheet && !hidden(sheet, true);
    bool draws_cone = has_cone && !hidden(cone, true);
#endif
    uint parts = parts_of(index, draws_sheet, draws_cone);

#if TILES
    Box both = none;
    if (draws_sheet) {
        both = sheet;
    }
    if (draws_cone) {
        widen(both, cone.low);
        widen(both, cone.high);
    }
    ivec2 first = clamped(both.low - 0.5) / kTile;
    ivec2 last = clamped(both.high + 0.5) / kTile;
#endif

#if PASS == 0
    bool drawn = draws_sheet || draws_cone;
#if TILES
    if (drawn && any(greaterThan(last - first, ivec2(1)))) {
        listed[first_wide_entry + atomicAdd(planes[plane_index].wide.count, 1u)] = uvec2(parts, 0u);
    } else
#endif
    if (drawn) {
        list_whole(parts);
    }
    if (has_sheet || has_cone) {
        atomicAdd(planes[plane_index].in_window, 1u);
        if (!drawn) {
            atomicAdd(planes[plane_index].hidden, 1u);
        }
    }
#else
    bool drawn = false;
    bool whole = false;
    vec4 ends = vec4(slope.s0, slope.s1);
    for (int y = first.y; y <= last.y; ++y) {
        for (int x = first.x; x <= last.x; ++x) {
            ivec2 at = ivec2(x, y);
            bool sheet_here = draws_sheet && !misses(quad, 4, at);
            bool cone_here = draws_cone;
#if CONES == 1
            if (cone_here) {
                bool all_miss = true;
                for (int i = 1; i < 4; ++i) {
                    vec2 corners[4] = vec2[](rays[0], rays[i], rays[i + 1], rays[0]);
                    all_miss = all_miss && misses(corners, 3, at);
                }
                cone_here = !all_miss;
            }
#endif
            vec2 corner = float(kTile) * vec2(at);
            // Under the umbra an edge brightens where both sides are drawn; there the whole footprint decides.
            Box texels = Box(corner + kNearby + 0.5, corner + float(kTile) - 0.5 - kNearby);
            bool here = (sheet_here || cone_here) && !hidden(texels, SIDES == 1);
            Tile tile = tile_at(at, float(kTile));
#if PASS == 1
            float darkest = 1.0;
            if (here && sheet_here && covers(quad, 4, at)) {
                darkest = at_most(tile, ends, slope.scales);
            }
#if CONES == 1
            if (here && cone_here) {
                for (int i = 1; i < 4; ++i) {
                    vec2 corners[4] = vec2[](rays[0], rays[i], rays[i + 1], rays[0]);
                    if (covers(corners, 3, at)) {
                        darkest = min(darkest, at_most(tile, ends.xyxy, slope.scales.xxzz));
                    }
                }
            }
#endif
            if (darkest < 1.0) {
                atomicMin(darkest_bits[tile_index(at)], floatBitsToUint(darkest));
            }
#else
#if !KEEP_ALL
            if (here) {
                float t = beaten_from(at, uintBitsToFloat(darkest_bits[tile_index(at)]));
                sheet_here = sheet_here && !above(tile, ends, slope.scales, t);
                cone_here = cone_here && !above(tile, ends.xyxy, slope.scales.xxzz, t);
                here = sheet_here || cone_here;
            }
#endif
            if (here) {
                uint entry = atomicAdd(planes[plane_index].tiles, 1u);
                if (entry < most_tile_entries) {
                    drawn = true;
                    listed[first_tile_entry + entry] =
                        uvec2(parts_of(index, sheet_here, cone_here), uint(at.x) | (uint(at.y) << 16));
                    for (int i = 0; i < 3; ++i) {
                        atomicAdd(planes[plane_index].draws[3 + i].count, uint(vertices_per_edge[i]));
                    }
                } else {
                    whole = true;  // no room: once more as a whole, which does no harm
                }
            }
#endif
        }
    }
#if PASS == 2
    if (whole) {
        list_whole(parts);
    } else if (!drawn) {
        atomicAdd(planes[plane_index].hidden, 1u);
    }
#endif
#endif
}
