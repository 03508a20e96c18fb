// Lists the silhouettes whose slopes can change a plane's texture: at least one texel of their bounds lies in the
// window, outside the umbra, and is looked up by a pixel. One vertex for each record; nothing is rasterised.
//
// HULL as in bounds.glsl. CONES: 0 none, 1 sectors, 2 whole discs. KEEP_ALL lists everything.
#include "techniques/plateaus/bounds.glsl"

layout(std430, binding = 0) readonly buffer Records { SilhouetteRecord records[]; };
layout(std430, binding = 5) writeonly buffer Listed { uint listed[]; };

struct DrawCommand {
    uint count, instance_count, first, base_instance;
};
struct PlaneDraws {
    uint kept;        // records listed
    uint in_window;   // records with bounds in the window
    uint hidden;      // records of those that are not listed
    uint unused;
    DrawCommand draws[3];
};
layout(std430, binding = 6) buffer Draws { PlaneDraws planes[]; };
layout(binding = 4) uniform sampler2D covered;
uniform ivec3 vertices_per_edge;

const float kNearby = SIDES == 2 ? 2.0 : 0.5;  // texels around: those that slopes.frag asks whether an edge is free

struct Box {
    vec2 low, high;  // texels
};

void widen(inout Box box, Slope slope, vec2 at) {
    vec2 texel = (plane_from_circle(slope, at) - PLANE.window.xy) * PLANE.window.w;
    box.low = min(box.low, texel);
    box.high = max(box.high, texel);
}

bool in_window(Box box) {
    return all(greaterThan(box.high, vec2(-kNearby))) && all(lessThan(box.low, vec2(PLANE.size.xy) + kNearby));
}

// Every texel of the box is covered: read at the level where the box has no more than 4 x 4 cells, if there is one.
bool hidden(Box box) {
#if KEEP_ALL
    return false;
#else
    vec2 last = vec2(PLANE.size.xy - 1);
    ivec2 low = ivec2(clamp(floor(box.low - kNearby), vec2(0.0), last));
    ivec2 high = ivec2(clamp(floor(box.high + kNearby), vec2(0.0), last));
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
    return any(greaterThan(all_of, vec2(0.5)));
#endif
}

void main() {
    gl_Position = vec4(2.0, 2.0, 2.0, 1.0);
    SilhouetteRecord record = records[gl_VertexID];
    Slope slope = measure(record);
    Box none = Box(vec2(1e30), vec2(-1e30));

    Strip strip = strip_of(slope);
    Box sheet = none;
    widen(sheet, slope, strip.foot0);
    widen(sheet, slope, strip.foot1);
    widen(sheet, slope, strip.far0);
    widen(sheet, slope, strip.far1);
    bool has_sheet = slope.drawn && in_window(sheet);
    bool draws_sheet = has_sheet && !hidden(sheet);

    bool has_cone = false;
    bool draws_cone = false;
#if CONES > 0
    Box cone = none;
#if CONES == 1
    Sector sector = sector_of(record, slope);
    has_cone = sector.drawn;
    widen(cone, slope, vec2(0.0));
    for (int ray = 0; ray < 4; ++ray) {
        widen(cone, slope, on_border(slope, sector, ray));
    }
#else
    has_cone = slope.drawn && slope.a_casts && slope.r0 > 0.0;
    vec2 half_size = slope.r0 * vec2(length(vec2(slope.plane_from_circle[0].x, slope.plane_from_circle[1].x)),
                                     length(vec2(slope.plane_from_circle[0].y, slope.plane_from_circle[1].y)));
    vec2 middle = slope.s0 - PLANE.window.xy;
    cone = Box((middle - half_size) * PLANE.window.w, (middle + half_size) * PLANE.window.w);
#endif
    has_cone = has_cone && in_window(cone);
    draws_cone = has_cone && !hidden(cone);
#endif

    if (has_sheet || has_cone) {
        atomicAdd(planes[plane_index].in_window, 1u);
        if (!draws_sheet && !draws_cone) {
            atomicAdd(planes[plane_index].hidden, 1u);
        }
    }
    if (draws_sheet || draws_cone) {
        uint at = atomicAdd(planes[plane_index].kept, 1u);
        listed[at] = uint(gl_VertexID) | (draws_sheet ? 0u : kNoSheet) | (draws_cone ? 0u : kNoCone);
        for (int i = 0; i < 3; ++i) {
            atomicAdd(planes[plane_index].draws[i].count, uint(vertices_per_edge[i]));
        }
    }
}
