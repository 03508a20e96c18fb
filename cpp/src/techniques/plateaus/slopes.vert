// The plateau's slopes: for each silhouette edge the sheet over it and the cone of its first vertex, drawn tightly; of
// those edges that sift.vert has listed.
//
// PART: 0 sheet (vertices 0 .. 5) and cone (6 .. 14): what is nearest to the edge or to the corner, and a little more.
//         FIRST_VERTEX and PER_EDGE choose one of them, or both
//       1 hull, 6 vertices: all that the light's image sweeps along the edge; outer side alone, or both (SIDES 2)
//       2 one row of a tessellated sheet, 6 CELLS vertices; the rule of cells for CELLS_BY_RULE    3 a cone as a fan, 3 SEGMENTS vertices
#define HULL (PART == 1)
#include "techniques/plateaus/bounds.glsl"
#include "shared/plateau_draws.h"

layout(std430, binding = 0) readonly buffer Records { SilhouetteRecord records[]; };
layout(std430, binding = 5) readonly buffer Listed { uvec2 listed[]; };  // record, kNoSheet, kNoCone; tile
uniform uint first_entry;
#if MAILBOX
layout(std430, binding = 3) readonly buffer Mailboxes { uint first_record[]; };
layout(std430, binding = 4) readonly buffer FirstBoxes { uint first_box[]; };  // by instance
#endif

#if TILED
out gl_PerVertex {
    vec4 gl_Position;
    float gl_ClipDistance[4];
};
#endif
flat out vec4 ends;    // where the edge's ends are projected to
flat out vec4 scales;  // sigma of both, height of both
#if PART >= 2
out float lambda;
uniform int row;
#endif

// Error of a sheet of n x n pairs of triangles (cell_error() of geometry/plateau.h).
float cell_error(float r0, float r1, int n) {
    float low = min(r0, r1);
    float a = sqrt(low);
    float b = sqrt(low + abs(r0 - r1) / float(n));
    return (b - a) / max(a + b, 1e-30) / float(n);
}

void main() {
    int entry = gl_VertexID / PER_EDGE;
    int k = gl_VertexID - entry * PER_EDGE + FIRST_VERTEX;
    uvec2 of = listed[first_entry + uint(entry)];
    uint index = of.x & kRecordMask;
    bool sheet = (of.x & kNoSheet) == 0u;
    bool cone = (of.x & kNoCone) == 0u;
    SilhouetteRecord record = records[index];
    Slope slope = measure(record);
    bool drawn = slope.drawn;
    ends = vec4(slope.s0, slope.s1);
    scales = slope.scales;
    vec2 at = vec2(0.0);  // circle space, from s0
#if PART == 0 || PART == 1
    if (k < 6) {
        drawn = drawn && sheet;
        Strip strip = strip_of(slope);
        bool right = k == 1 || k == 2 || k == 4;
        bool far = k == 2 || k == 4 || k == 5;
        at = far ? (right ? strip.far1 : strip.far0) : (right ? strip.foot1 : strip.foot0);
#if PART == 0
    } else {
        Sector sector = sector_of(record, slope);
        drawn = sector.drawn && cone;
        int corner_index = (k - 6) % 3;
        at = corner_index == 0 ? vec2(0.0) : on_border(slope, sector, (k - 6) / 3 + (corner_index == 2 ? 1 : 0));
        ends.zw = ends.xy;
        scales.yw = scales.xz;
#endif
    }
#elif PART == 2
    float r0 = slope.r0;
    float r1 = slope.r1;
    float g = slope.g;
    vec2 d = slope.d;
    // Row `row` of CELLS x CELLS pairs of triangles over the patch; the diagonal is theirs.
    float len2 = dot(d, d);
    drawn = drawn && sheet && len2 > (r0 - r1) * (r0 - r1) * (1.0 + 1e-6) && max(r0, r1) > 0.0;
    float side = sqrt(max(0.0, 1.0 - g * g));
    vec2 n = g * slope.e + side * slope.m;
    int cell = k / 6;
    int corner_index = k - 6 * cell;
    bool right = corner_index == 1 || corner_index == 2 || corner_index == 4;
    bool far = corner_index == 2 || corner_index == 4 || corner_index == 5;
    int cells = CELLS;
#if CELLS_BY_RULE
    cells = 1;
    while (cells < CELLS && cell_error(r0, r1, cells) >= 1.0 / 255.0) {
        ++cells;
    }
    drawn = drawn && cell < cells && row < cells;
#endif
    float along = float(cell + (right ? 1 : 0)) / float(cells);
    lambda = float(row + (far ? 1 : 0)) / float(cells);
    if (row == 0 && !far) {  // a little over the hard edge: below 0, which counts as 0
        lambda = -min(0.02 * slope.texel / max(mix(r0, r1, along), 1e-30), 1.0);
    }
    at = along * d + lambda * mix(r0, r1, along) * n;
#else
    drawn = drawn && cone && slope.a_casts && slope.r0 > 0.0;
#if MAILBOX
    drawn = drawn && first_record[first_box[record.ids.x] + record.ids.y] == index;
#endif
    int corner_index = k % 3;
    float angle = kTwoPi * float(k / 3 + (corner_index == 2 ? 1 : 0)) / float(SEGMENTS);
    lambda = corner_index == 0 ? 0.0 : 1.0;
    at = lambda * slope.r0 * vec2(cos(angle), sin(angle));
    ends.zw = ends.xy;
    scales.yw = scales.xz;
#endif

    vec2 p = plane_from_circle(slope, at);
#if TILED
    vec2 texel = (p - PLANE.window.xy) * PLANE.window.w;
    vec2 low = float(PENUMBRA_PLATEAU_TILE) * vec2(of.y & 0xffffu, of.y >> 16);
    vec2 high = low + float(PENUMBRA_PLATEAU_TILE);
    gl_ClipDistance[0] = texel.x - low.x;
    gl_ClipDistance[1] = texel.y - low.y;
    gl_ClipDistance[2] = high.x - texel.x;
    gl_ClipDistance[3] = high.y - texel.y;
#endif
    vec2 clip_xy = 2.0 * (p - PLANE.window.xy) * PLANE.window.w / vec2(PLANE.size.xy) - 1.0;
    // Far outside of the window nothing is lost by holding coordinates within what the rasteriser takes.
    gl_Position = drawn ? vec4(clip_xy, 0.5, 1.0) : vec4(2.0, 2.0, 2.0, 1.0);
}
