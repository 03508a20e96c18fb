// Where the slopes of one silhouette record lie on a plane: bounds of its sheet and of the cone of its first vertex,
// for those who draw them (slopes.vert) and for those who ask whether anybody sees them (sift.vert).
//
// Bounds are made in "circle space": light coordinates laid onto the plane, so that the light's image there is its shape
// times sigma, a circle for round lights; from the edge's first end, x along it, y to its outer side.
#include "shared/silhouette.h"
#include "techniques/plateaus/plateau.glsl"

// What sift.vert lists: the record, and which of its two parts need not be drawn.
const uint kNoSheet = 0x80000000u;
const uint kNoCone = 0x40000000u;
const uint kRecordMask = 0x3fffffffu;

const float kTwoPi = 6.28318530718;
const float kMargin = 0.06;  // of the radius and in radians: rulings of neighbours overlap, and so do their pixels

// Cuts a segment to the heights that cast; false if nothing is left.
bool clip(inout vec3 a, inout vec3 b) {
    float low = PLANE.heights.x;
    float high = PLANE.heights.y;
    if (max(a.z, b.z) <= low || min(a.z, b.z) >= high) {
        return false;
    }
    vec3 from = a;
    vec3 d = b - a;
    if (a.z < low || a.z > high) {
        a = from + d * (((a.z < low ? low : high) - from.z) / d.z);
    }
    if (b.z < low || b.z > high) {
        b = from + d * (((b.z < low ? low : high) - from.z) / d.z);
    }
    return true;
}

// Where the light's image (its shape, point-reflected) reaches farthest in a direction, in units of sigma.
vec2 footprint(vec2 n) {
    return -support(-n);
}

vec2 turned(vec2 n, float angle) {
    return vec2(cos(angle) * n.x - sin(angle) * n.y, sin(angle) * n.x + cos(angle) * n.y);
}

struct Corner {
    vec2 away;     // unit, towards the neighbour
    float g;       // (r - r of the neighbour) / distance
    float d;
    bool defined;  // false: the neighbour is projected to the same place
};

Corner corner_towards(vec2 s, float r, vec2 s_next, float r_next, mat2 circle_from_plane) {
    Corner found;
    vec2 d = circle_from_plane * (s_next - s);
    found.d = length(d);
    found.defined = found.d > 1e-6 * (r + r_next);
    found.away = found.defined ? d / found.d : vec2(1.0, 0.0);
    found.g = found.defined ? (r - r_next) / found.d : 2.0;
    return found;
}

float angle_from_edge(float g) {
#if SHEET == 1
    return abs(g) < 1.0 ? acos(abs(g)) : 0.0;  // bilinear and tessellated: a cone may pierce the lower sheet
#else
    return g < 1.0 ? acos(max(g, 0.0)) : 0.0;  // envelope
#endif
}

struct Slope {
    bool drawn;      // something of the edge casts onto the plane
    bool a_casts;    // its first vertex does
    vec3 a;          // ends, plane coordinates, cut to what casts
    vec2 s0, s1;     // where they are projected to
    vec4 scales;     // sigma of both, height of both
    mat2 circle_from_plane, plane_from_circle;
    float circumscribed, reach;  // of the light's shape, in units of sigma; the same with what a tilt adds
    float r0, r1;    // radii of the light's image
    vec2 d, e, m;    // s1 - s0 in circle space; its direction and the outer normal
    float len, g;    // its length; (r0 - r1) / len
    float texel;     // in circle space
};

Slope measure(SilhouetteRecord record) {
    Slope slope;
    vec3 a = plane_from_rel(record.a_rel.xyz);
    vec3 b = plane_from_rel(record.b_rel.xyz);
    slope.a_casts = a.z >= PLANE.heights.x && a.z <= PLANE.heights.y;
    bool drawn = clip(a, b);
    slope.a = a;
    vec2 s0 = project(a);
    vec2 s1 = project(b);
    slope.s0 = s0;
    slope.s1 = s1;
    slope.scales = vec4(image_scale(a.z), image_scale(b.z), a.z, b.z);
    // Plane vectors of the circle space's axes, seen from the middle of the edge.
    vec3 q = to_light(0.5 * (s0 + s1));
    vec3 half_u;
    vec3 half_v;
    light_axes(q, half_u, half_v);
    vec2 u = half_u.xy - half_u.z * q.xy / q.z;
    vec2 v = half_v.xy - half_v.z * q.xy / q.z;
    float det = u.x * v.y - u.y * v.x;
    if (det < 0.0) {
        v = -v;
        det = -det;
    }
    if (det < 0.02 * dot(u, u) || det < 0.02 * dot(v, v)) {  // edge on: its image would be a line
        u = dot(u, u) > dot(v, v) ? u : right_of(v);
        v = 0.02 * vec2(-u.y, u.x);
        det = u.x * v.y - u.y * v.x;
    }
    slope.drawn = drawn && det > 0.0;
    slope.circle_from_plane = mat2(v.y, -u.y, -v.x, u.x) / det;
    slope.plane_from_circle = mat2(u, v);

    // Radii. A tilted light's image is larger on the side of its nearer rim.
#if GAUGE == 0
    float reach = 1.0;
#elif GAUGE == 1
    float reach = length(vec2(PLANE.half_u.w, PLANE.half_v.w)) + PLANE.dual_u.w;
#else
    float reach = 1.0;
#endif
    slope.circumscribed = reach;
#if FRAME != 0
    float rim = reach * length(vec2(half_u.z, half_v.z));
    float above = PLANE.light.z - PLANE.light.w * max(a.z, b.z);
    reach *= 1.0 / max(1.0 - rim / above, 0.125);
#endif
    slope.reach = reach;
    slope.r0 = slope.scales.x * reach;
    slope.r1 = slope.scales.y * reach;
    slope.d = slope.circle_from_plane * (s1 - s0);
    slope.len = length(slope.d);
    slope.e = slope.len > 0.0 ? slope.d / slope.len : vec2(1.0, 0.0);
    slope.m = right_of(slope.e);
    slope.g = slope.len > 0.0 ? (slope.r0 - slope.r1) / slope.len : 2.0;
    slope.texel = PLANE.window.z * length(vec4(slope.circle_from_plane[0], slope.circle_from_plane[1]));
    return slope;
}

// Bounds of the sheet, four corners: all that the light's image sweeps along the edge (HULL, outer side alone or both),
// or what is nearest to the edge rather than to its ends, and a little more.
struct Strip {
    vec2 foot0, foot1;  // over the hard edge
    vec2 far0, far1;
};

Strip strip_of(Slope slope) {
    float r0 = slope.r0;
    float r1 = slope.r1;
    vec2 e = slope.e;
    vec2 m = slope.m;
    float g = slope.g;
    float len = slope.len;
    float texel = slope.texel;
    float widest = max(r0, r1);
    bool lean = abs(g) < 0.8;
#if !HULL
    float x0 = lean ? min(0.0, g * r0) : min(-r0, len - r1);
    float x1 = lean ? max(len, len + g * r1) : max(r0, len + r1);
    float margin = kMargin * widest + 0.5 * texel;
#else
    float x0 = min(-r0, len - r1);
    float x1 = max(r0, len + r1);
    float margin = 1.0 * texel;
#endif
    x0 -= margin;
    x1 += margin;
    float side = sqrt(max(1.0 - g * g, 0.36));
    float y0 = lean ? max(r0 - g * x0, 0.0) / side : widest;
    float y1 = lean ? max(r0 - g * x1, 0.0) / side : widest;
    float foot0 = x0;
    float foot1 = x1;
#if GAUGE != 0 && !HULL
    if (lean) {
        // Touched with its support point for the edge's normal, the shape sweeps a slanted strip; unequal ends lean
        // the normal towards the smaller one.
        float stretch = slope.reach / slope.circumscribed;
        float top = 0.0;
        float slope0 = kFar;
        float slope1 = -kFar;
        for (int i = 0; i < 4; ++i) {
            vec2 n = turned((i & 1) == 0 ? m : g * e + side * m, (i & 2) == 0 ? kMargin : -kMargin);
            vec2 c = footprint(n);
            float up = max(dot(c, m), 1e-6);
            top = max(top, up);
            slope0 = min(slope0, dot(c, e) / up);
            slope1 = max(slope1, dot(c, e) / up);
        }
        top *= stretch * max(slope.scales.x, slope.scales.y) * (1.0 + kMargin);
        foot0 = -margin;
        foot1 = len + margin;
        y0 = top;
        y1 = top;
        x0 = foot0 + slope0 * top;
        x1 = foot1 + slope1 * top;
    }
#endif
    // One texel over the hard edge, so that no pixel falls between sheet and umbra.
    Strip strip;
#if SIDES == 2
    strip.foot0 = foot0 * e - y0 * m;
    strip.foot1 = foot1 * e - y1 * m;
#else
    strip.foot0 = foot0 * e - texel * m;
    strip.foot1 = foot1 * e - texel * m;
#endif
    strip.far0 = x0 * e + (y0 + texel) * m;
    strip.far1 = x1 * e + (y1 + texel) * m;
    return strip;
}

// The sector that the two edges of a corner leave of its cone, in three triangles around the corner.
struct Sector {
    bool drawn;
    float from, third;
    vec2 zero;
};

Sector sector_of(SilhouetteRecord record, Slope slope) {
    Sector found;
    float r0 = slope.r0;
    vec3 z = plane_from_rel(record.z_rel.xyz);
    vec3 corner = slope.a;
    bool paired = record.a_rel.w > 0.5 && slope.a_casts && clip(corner, z);
    vec2 sz = project(z);
    float rz = image_scale(z.z) * slope.reach;
    Corner next = corner_towards(slope.s0, r0, slope.s1, slope.r1, slope.circle_from_plane);
    Corner last = corner_towards(slope.s0, r0, sz, rz, slope.circle_from_plane);
    float from = 0.0;
    float to = kTwoPi;
    vec2 zero = next.away;
    if (paired && next.defined && last.defined) {
        float sector = atan(dot(last.away, right_of(zero)), dot(last.away, zero));
        sector += sector < 0.0 ? kTwoPi : 0.0;
        from = angle_from_edge(next.g) - kMargin;
        to = sector - angle_from_edge(last.g) + kMargin;
#if SHEET == 1
        bool proved = next.g >= 0.0 && last.g >= 0.0 && next.d >= r0 && last.d >= r0;
        if (from + 2.0 * kMargin >= to && !proved) {
            from = 0.0;
            to = sector;
        }
#endif
    }
    found.drawn = slope.drawn && slope.a_casts && to > from && r0 > 0.0;
    found.from = from;
    found.third = (to - from) / 3.0;
    found.zero = zero;
    return found;
}

// Border of the cone at ray 0 .. 3 of the sector, outside of what it holds.
vec2 on_border(Slope slope, Sector sector, int ray) {
    float angle = sector.from + sector.third * float(ray);
    vec2 direction = cos(angle) * sector.zero + sin(angle) * right_of(sector.zero);
#if GAUGE == 0
    vec2 border = slope.r0 * direction;
#else
    vec2 border = slope.r0 / slope.circumscribed * footprint(direction);
#endif
    return border * ((1.0 + kMargin) / cos(0.5 * sector.third)) + slope.texel * direction;
}

vec2 plane_from_circle(Slope slope, vec2 at) {
    return slope.s0 + slope.plane_from_circle * at;
}
