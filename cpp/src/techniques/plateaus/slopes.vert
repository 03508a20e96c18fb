// The plateau's slopes: for each silhouette edge the sheet over it and the cone of its first vertex, drawn tightly.
//
// Bounds are made in "circle space": light coordinates laid onto the plane, so that the light's image there is its shape
// times sigma, a circle for round lights; from the middle of the edge, x along it, y to its outer side.
//
// PART: 0 sheet (vertices 0 .. 5) and cone (6 .. 14): what is nearest to the edge or to the corner, and a little more.
//         FIRST_VERTEX and PER_EDGE choose one of them, or both
//       1 hull, 6 vertices: all that the light's image sweeps along the edge; outer side alone, or both (SIDES 2)
//       2 one row of a tessellated sheet, 6 CELLS vertices; the rule of cells for CELLS_BY_RULE    3 a cone as a fan, 3 SEGMENTS vertices
#include "shared/silhouette.h"
#include "techniques/plateaus/plateau.glsl"

layout(std430, binding = 0) readonly buffer Records { SilhouetteRecord records[]; };
#if MAILBOX
layout(std430, binding = 3) readonly buffer Mailboxes { uint first_record[]; };
layout(std430, binding = 4) readonly buffer FirstBoxes { uint first_box[]; };  // by instance
#endif

flat out vec4 ends;    // where the edge's ends are projected to
flat out vec4 scales;  // sigma of both, height of both
#if PART >= 2
out float lambda;
uniform int row;
#endif

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

// Error of a sheet of n x n pairs of triangles (cell_error() of geometry/plateau.h).
float cell_error(float r0, float r1, int n) {
    float low = min(r0, r1);
    float a = sqrt(low);
    float b = sqrt(low + abs(r0 - r1) / float(n));
    return (b - a) / max(a + b, 1e-30) / float(n);
}

void main() {
    int index = gl_VertexID / PER_EDGE;
    int k = gl_VertexID - index * PER_EDGE + FIRST_VERTEX;
    SilhouetteRecord record = records[index];
    vec3 a = plane_from_rel(record.a_rel.xyz);
    vec3 b = plane_from_rel(record.b_rel.xyz);
    bool a_casts = a.z >= PLANE.heights.x && a.z <= PLANE.heights.y;
    bool drawn = clip(a, b);
    vec2 s0 = project(a);
    vec2 s1 = project(b);
    ends = vec4(s0, s1);
    scales = vec4(image_scale(a.z), image_scale(b.z), a.z, b.z);

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
    drawn = drawn && det > 0.0;
    mat2 circle_from_plane = mat2(v.y, -u.y, -v.x, u.x) / det;
    mat2 plane_from_circle = mat2(u, v);

    // Radii. A tilted light's image is larger on the side of its nearer rim.
#if GAUGE == 0
    float reach = 1.0;
#elif GAUGE == 1
    float reach = length(vec2(PLANE.half_u.w, PLANE.half_v.w)) + PLANE.dual_u.w;
#else
    float reach = 1.0;
#endif
    float circumscribed = reach;
#if FRAME != 0
    float rim = reach * length(vec2(half_u.z, half_v.z));
    float above = PLANE.light.z - PLANE.light.w * max(a.z, b.z);
    reach *= 1.0 / max(1.0 - rim / above, 0.125);
#endif
    float r0 = scales.x * reach;
    float r1 = scales.y * reach;
    vec2 d = circle_from_plane * (s1 - s0);
    float len = length(d);
    vec2 e = len > 0.0 ? d / len : vec2(1.0, 0.0);
    vec2 m = right_of(e);
    float g = len > 0.0 ? (r0 - r1) / len : 2.0;
    float texel = PLANE.window.z * length(vec4(circle_from_plane[0], circle_from_plane[1]));
    float widest = max(r0, r1);

    vec2 at = vec2(0.0);  // circle space, from s0
#if PART == 0 || PART == 1
    if (k < 6) {
        bool lean = abs(g) < 0.8;
#if PART == 0
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
#if GAUGE != 0 && PART == 0
        if (lean) {
            // Touched with its support point for the edge's normal, the shape sweeps a slanted strip; unequal ends lean
            // the normal towards the smaller one.
            float stretch = reach / circumscribed;
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
            top *= stretch * max(scales.x, scales.y) * (1.0 + kMargin);
            foot0 = -margin;
            foot1 = len + margin;
            y0 = top;
            y1 = top;
            x0 = foot0 + slope0 * top;
            x1 = foot1 + slope1 * top;
        }
#endif
        // One texel over the hard edge, so that no pixel falls between sheet and umbra.
        float inner = -texel;
        bool right = k == 1 || k == 2 || k == 4;
        bool far = k == 2 || k == 4 || k == 5;
        float y = right ? y1 : y0;
#if SIDES == 2
        inner = -y;
#endif
#if PART == 0
        at = far ? (right ? x1 : x0) * e + (y + texel) * m : (right ? foot1 : foot0) * e + inner * m;
#else
        at = (right ? x1 : x0) * e + (far ? y + texel : inner) * m;
#endif
#if PART == 0
    } else {
        // Three triangles around the sector that the two edges leave of the cone.
        vec3 z = plane_from_rel(record.z_rel.xyz);
        vec3 corner = a;
        bool paired = record.a_rel.w > 0.5 && a_casts && clip(corner, z);
        vec2 sz = project(z);
        float rz = image_scale(z.z) * reach;
        Corner next = corner_towards(s0, r0, s1, r1, circle_from_plane);
        Corner last = corner_towards(s0, r0, sz, rz, circle_from_plane);
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
        drawn = drawn && a_casts && to > from && r0 > 0.0;
        float third = (to - from) / 3.0;
        int corner_index = (k - 6) % 3;
        float angle = from + third * float((k - 6) / 3 + (corner_index == 2 ? 1 : 0));
        vec2 direction = cos(angle) * zero + sin(angle) * right_of(zero);
#if GAUGE == 0
        vec2 border = r0 * direction;
#else
        vec2 border = r0 / circumscribed * footprint(direction);
#endif
        at = corner_index == 0 ? vec2(0.0) : border * ((1.0 + kMargin) / cos(0.5 * third)) + texel * direction;
        ends.zw = ends.xy;
        scales.yw = scales.xz;
#endif
    }
#elif PART == 2
    // Row `row` of CELLS x CELLS pairs of triangles over the patch; the diagonal is theirs.
    float len2 = dot(d, d);
    drawn = drawn && len2 > (r0 - r1) * (r0 - r1) * (1.0 + 1e-6) && widest > 0.0;
    float side = sqrt(max(0.0, 1.0 - g * g));
    vec2 n = g * e + side * m;
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
        lambda = -min(0.02 * texel / max(mix(r0, r1, along), 1e-30), 1.0);
    }
    at = along * d + lambda * mix(r0, r1, along) * n;
#else
    drawn = drawn && a_casts && r0 > 0.0;
#if MAILBOX
    drawn = drawn && first_record[first_box[record.ids.x] + record.ids.y] == uint(index);
#endif
    int corner_index = k % 3;
    float angle = kTwoPi * float(k / 3 + (corner_index == 2 ? 1 : 0)) / float(SEGMENTS);
    lambda = corner_index == 0 ? 0.0 : 1.0;
    at = lambda * r0 * vec2(cos(angle), sin(angle));
    ends.zw = ends.xy;
    scales.yw = scales.xz;
#endif

    vec2 p = s0 + plane_from_circle * at;
    vec2 clip_xy = 2.0 * (p - PLANE.window.xy) * PLANE.window.w / vec2(PLANE.size.xy) - 1.0;
    // Far outside of the window nothing is lost by holding coordinates within what the rasteriser takes.
    gl_Position = drawn ? vec4(clip_xy, 0.5, 1.0) : vec4(2.0, 2.0, 2.0, 1.0);
}
