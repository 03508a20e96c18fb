// Plateaus [Haines2001] on receiver planes: projections, the light's shape, and the slope coordinate lambda of an edge.
// The float32 twin of geometry/plateau.h, which says what is computed.
//
// An edge is measured in the light's own plane: seen from the receiver point p, a vertex covers a point of the light's
// plane, an edge a segment, and lambda is the factor by which the light's shape must shrink or grow about its centre to
// touch that segment. For a disc parallel to the receiver this is the envelope of the paper's cones; for a tilted
// light, a ball, a rectangle or a polygon it is the same with the border where the light's is.
//
// GAUGE: 0 disc, 1 rounded box (rectangle, lozenge), 2 polygon. FRAME: 0 light parallel to the plane, 1 tilted or sun,
// 2 ball. Compiled in, since this runs for each texel of each edge.
#include "shared/plateau_block.h"

layout(std140, binding = 2) uniform Plateaus { PlateauBlock plateaus; };
uniform int plane_index;
#define PLANE plateaus.planes[plane_index]

const float kFar = 1e30;

vec2 right_of(vec2 e) {
    return vec2(e.y, -e.x);
}

// Plane coordinates of a position relative to the pass's origin.
vec3 plane_from_rel(vec3 p_rel) {
    return vec3(dot(PLANE.x_from_rel.xyz, p_rel) + PLANE.x_from_rel.w,
                dot(PLANE.y_from_rel.xyz, p_rel) + PLANE.y_from_rel.w,
                dot(PLANE.h_from_rel.xyz, p_rel) + PLANE.h_from_rel.w);
}

// Where the light throws it; its height is within PLANE.heights.
vec2 project(vec3 v) {
    return v.xy + (PLANE.light.w * v.xy - PLANE.light.xy) * (v.z / (PLANE.light.z - PLANE.light.w * v.z));
}

// Size of the light's image through a vertex of this height, over the light's own.
float image_scale(float h) {
    float linear = PLANE.heights.z * h;
    float exact = h / (PLANE.light.z - PLANE.light.w * h);
    return max(PLANE.heights.z > 0.0 ? linear : exact, PLANE.normal.w);
}

// From a point of the plane to the light; a sun: its direction.
vec3 to_light(vec2 p) {
    return PLANE.light.xyz - PLANE.light.w * vec3(p, 0.0);
}

// Half axes of the light as seen from there.
void light_axes(vec3 q, out vec3 half_u, out vec3 half_v) {
#if FRAME == 2
    // The tangent cone of a ball meets the plane through its centre across the line of sight in a disc.
    float q2 = dot(q, q);
    float sine2 = min(PLANE.dual_v.w * PLANE.dual_v.w / q2, 0.99);
    float radius = PLANE.dual_v.w * inversesqrt(1.0 - sine2);
    vec3 u = normalize(vec3(q.z, 0.0, -q.x));
    half_u = radius * u;
    half_v = radius * normalize(cross(q, u));
#else
    half_u = PLANE.half_u.xyz;
    half_v = PLANE.half_v.xyz;
#endif
}

// Homogeneous light coordinates of a vertex as seen from p; `s` is where it is projected to, less p.
vec3 back_project(vec2 s, float sigma, vec3 q) {
#if FRAME == 0
    return vec3(dot(PLANE.dual_u.xy, s), dot(PLANE.dual_v.xy, s), sigma);
#elif FRAME == 1
    vec3 m = PLANE.normal.xyz;
    float mq = dot(m, q);
    float ms = dot(m.xy, s);
    vec3 x = mq * vec3(s, 0.0) - ms * q;
    vec3 at = vec3(dot(PLANE.dual_u.xyz, x), dot(PLANE.dual_v.xyz, x), ms + sigma * mq);
    return mq < 0.0 ? -at : at;
#else
    vec3 half_u;
    vec3 half_v;
    light_axes(q, half_u, half_v);
    float q2 = dot(q, q);
    float r2 = dot(half_u, half_u);
    return vec3(dot(half_u.xy, s) * q2 / r2, dot(half_v.xy, s) * q2 / r2, dot(q.xy, s) + sigma * q2);
#endif
}

float gauge(vec2 x) {
#if GAUGE == 0
    return length(x);
#elif GAUGE == 1
    vec2 q = abs(x);
    vec2 core = vec2(PLANE.half_u.w, PLANE.half_v.w);
    float radius = PLANE.dual_u.w;
    vec2 side = q / (core + radius);
    float q2 = dot(q, q);
    float along = dot(q, core);
    float root = along + sqrt(max(0.0, along * along - (dot(core, core) - radius * radius) * q2));
    float corner = root > 0.0 ? q2 / root : kFar;
    return q.y <= side.x * core.y ? side.x : (q.x <= side.y * core.x ? side.y : corner);
#else
    float largest = 0.0;
    for (int i = 0; i < PLANE.size.z; ++i) {
        vec2 from = PLANE.corner[i].xy;
        vec2 n = right_of(PLANE.corner[i + 1 < PLANE.size.z ? i + 1 : 0].xy - from);
        largest = max(largest, dot(n, x) / dot(n, from));
    }
    return largest;
#endif
}

vec2 support(vec2 n) {
#if GAUGE == 0
    return normalize(n);
#elif GAUGE == 1
    return vec2(PLANE.half_u.w, PLANE.half_v.w) * sign(n) + PLANE.dual_u.w * normalize(n);
#else
    vec2 best = PLANE.corner[0].xy;
    for (int i = 1; i < PLANE.size.z; ++i) {
        vec2 c = PLANE.corner[i].xy;
        best = dot(c, n) > dot(best, n) ? c : best;
    }
    return best;
#endif
}

struct Nearest {
    float lambda;
    float t;       // where on the edge, 0 a .. 1 b
    vec2 normal;   // of the straight edge that stands for it, light coordinates, away from the centre
};

// Least gauge over the segment between two homogeneous points.
Nearest nearest_on_edge(vec3 a, vec3 b) {
    Nearest found;
#if FRAME != 0
    // What lies behind the receiver's line of sight on a tilted light is cut off before any division.
    float top = max(a.z, b.z);
    float least = 1e-4 * max(top, 0.0);
    vec3 from_a = a;
    float t_a = a.z < least ? (least - a.z) / (b.z - a.z) : 0.0;
    float t_b = b.z < least ? (a.z - least) / (a.z - b.z) : 1.0;
    a = t_a > 0.0 ? mix(from_a, b, t_a) : a;
    b = t_b < 1.0 ? mix(from_a, b, t_b) : b;
#endif
#if GAUGE == 0
    // Least |a + t d| / (w + t e): the derivative is linear in t.
    vec3 d = b - a;
    float numerator = d.z * dot(a.xy, a.xy) - a.z * dot(a.xy, d.xy);
    float denominator = a.z * dot(d.xy, d.xy) - d.z * dot(a.xy, d.xy);
    found.t = denominator > 0.0 ? clamp(numerator / denominator, 0.0, 1.0) : (d.z > 0.0 ? 1.0 : 0.0);
    vec3 at = a + found.t * d;
    float distance = length(at.xy);
    found.lambda = at.z > 0.0 ? distance / at.z : (distance > 0.0 ? kFar : 0.0);
    found.normal = at.xy;
#else
    float least_w = 1e-6 * max(a.z, b.z);
    float lambda_a = a.z > least_w ? gauge(a.xy / a.z) : kFar;
    float lambda_b = b.z > least_w ? gauge(b.xy / b.z) : kFar;
    bool nearer_b = lambda_b < lambda_a;
    found.lambda = nearer_b ? lambda_b : lambda_a;
    found.t = nearer_b ? 1.0 : 0.0;
    vec3 line = cross(a, b);
    vec2 n = line.z > 0.0 ? -line.xy : line.xy;
    // At an end too the edge's own line stands for it: lambda counts in the shape's reach along that.
    found.normal = dot(n, n) > 0.0 ? n : (nearer_b ? b.xy : a.xy);
    vec2 corner = support(n);
    float reach = dot(corner, n);
    if (dot(n, n) > 0.0 && reach > 0.0) {
        float lambda = abs(line.z) / reach;
        vec3 touch = vec3(lambda * corner, 1.0);
        vec3 from = cross(touch, a);
        vec3 to = cross(touch, b);
        if (dot(from, to) <= 0.0 && lambda < found.lambda) {
            found.lambda = lambda;
            found.t = dot(from, from - to) > 0.0 ? clamp(dot(from, from) / dot(from, from - to), 0.0, 1.0) : 0.0;
        }
    }
#endif
#if FRAME != 0
    found.lambda = top > 0.0 ? found.lambda : kFar;
    found.t = mix(t_a, t_b, found.t);
#endif
    return found;
}

// The paper's sheet: the bilinear patch over edge and outer tangent, inverted; kFar outside of it. p is the origin.
float bilinear_sheet(vec3 a, vec3 b) {
    vec2 d = b.xy - a.xy;
    float dr = a.z - b.z;
    float d2 = dot(d, d);
    if (d2 <= dr * dr * (1.0 + 1e-6)) {
        return kFar;
    }
    float len = sqrt(d2);
    vec2 e = d / len;
    float g = dr / len;
    float side = sqrt(max(0.0, (len - dr) * (len + dr))) / len;
    float x = -dot(a.xy, e);
    float y = -dot(a.xy, right_of(e));
    float bottom = (a.z - g * x) * side + g * g * y;
    float lambda = max(y, 0.0) / bottom;
    float u = (x - lambda * g * a.z) / (1.0 - lambda * g * g) / len;
    // A little over the hard edge, so that no texel on it falls between the sheet and the umbra.
    return y >= -0.0005 * max(a.z, b.z) && bottom > 0.0 && u >= 0.0 && u <= 1.0 && lambda <= 1.0 ? lambda : kFar;
}

// Visible part of the light where a straight edge passes at xi of its reach along `normal`, xi in [-1, 1].
float cut(float xi, vec2 normal) {
    xi = clamp(xi, -1.0, 1.0);
#if GAUGE == 1
    vec2 core = vec2(PLANE.half_u.w, PLANE.half_v.w);
    vec2 n = abs(normal) * (core + PLANE.dual_u.w);
    n /= max(n.x + n.y, 1e-30);
    float low = min(n.x, n.y);
    float high = max(n.x, n.y);
    float rest = 1.0 - abs(xi);
    float outside = rest < 2.0 * low ? rest * rest / (8.0 * low * high) : (rest - low) / (2.0 * high);
    // A disc for what the rounding leaves of the box; one that is all corner is none.
    float box_part = xi < 0.0 ? outside : 1.0 - outside;
    float disc_part = 0.5 + (xi * sqrt(1.0 - xi * xi) + asin(xi)) / 3.14159265;
    // A lozenge counts as its line: the length that is seen.
    return core.y > 0.0 ? mix(box_part, disc_part, PLANE.dual_u.w) : 0.5 + 0.5 * xi;
#elif GAUGE == 2
    float reach = dot(support(normal), normal);
    vec2 on = normal * (xi * reach / max(dot(normal, normal), 1e-30));
    float kept = 0.0;
    float whole = 0.0;
    for (int i = 0; i < PLANE.size.z; ++i) {
        vec2 a = PLANE.corner[i].xy;
        vec2 b = PLANE.corner[i + 1 < PLANE.size.z ? i + 1 : 0].xy;
        whole += a.x * b.y - a.y * b.x;
        float da = dot(a - on, normal);
        float db = dot(b - on, normal);
        vec2 middle = a + (b - a) * (da / (da - db));
        vec2 from = da > 0.0 ? middle : a;
        vec2 to = db > 0.0 ? middle : b;
        if (da <= 0.0 || db <= 0.0) {
            kept += (from.x - on.x) * (to.y - on.y) - (from.y - on.y) * (to.x - on.x);
        }
    }
    return clamp(kept / whole, 0.0, 1.0);
#else
    return 0.5 + (xi * sqrt(1.0 - xi * xi) + asin(xi)) / 3.14159265;
#endif
}
