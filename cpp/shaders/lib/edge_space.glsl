// Silhouette edges in a map's space: points (p, w), p in the image plane (lib/map_space.glsl), w falling with depth:
// 1 / z_ls, orthographic -z_ls. The lines through an edge point from all points of a light (half size r, in the plane
// z_ls = 0) fill, at depth w, an image of half size r (w_edge - w): a cone in (p, w), whatever the projection.
// Orthographic: r is the tangent of half the sun's angle.
//
// "Unit" lengths: the image plane after the affine map `unit_from_ip`, which makes what one measures with round.
// Needs lib/map_lookup.glsl and lib/map_space.glsl.
#include "shared/silhouette.h"

uniform int face_index;
uniform vec3 edge_range;    // depth z_ls below which edges are cut off, above which they do not matter, w of the latter
uniform vec4 unit_from_ip;  // columns of a matrix of positive determinant
uniform vec4 ip_from_unit;

vec2 to_unit(vec2 p_ip) {
    return unit_from_ip.xy * p_ip.x + unit_from_ip.zw * p_ip.y;
}
vec2 from_unit(vec2 p_unit) {
    return ip_from_unit.xy * p_unit.x + ip_from_unit.zw * p_unit.y;
}

float w_from_depth(float z_ls) {
#if MAP_ORTHOGRAPHIC
    return -z_ls;
#else
    return 1.0 / z_ls;
#endif
}

float w_from_stored(int face, float stored) {
#if MAP_ORTHOGRAPHIC
    vec4 range_m = MAP_FACE(face).range_m;
    return stored * (range_m.y - range_m.x) - range_m.y;
#else
    return stored / MAP_FACE(face).range_m.x;
#endif
}

// Unit position and w of a point; z_ls > 0 if perspective.
vec3 pw_from_ls(vec3 p_ls) {
#if MAP_ORTHOGRAPHIC
    return vec3(to_unit(p_ls.xy), -p_ls.z);
#else
    float w = 1.0 / p_ls.z;
    return vec3(to_unit(p_ls.xy * w), w);
#endif
}

bool in_edge_range(float z_ls) {
    return z_ls >= edge_range.x && z_ls < edge_range.y;
}

// Cuts a segment to the range of depths; false if nothing is left. Nothing is divided by z_ls before.
bool clip_edge(inout vec3 a_ls, inout vec3 b_ls) {
    vec2 z = vec2(a_ls.z, b_ls.z);
    if (max(z.x, z.y) <= edge_range.x || min(z.x, z.y) >= edge_range.y) {
        return false;
    }
    vec3 d = b_ls - a_ls;
    float per_z = abs(d.z) > 0.0 ? 1.0 / d.z : 0.0;
    vec2 t = (clamp(z, edge_range.x, edge_range.y) - z.x) * per_z;
    bool cut_a = z.x != clamp(z.x, edge_range.x, edge_range.y);
    bool cut_b = z.y != clamp(z.y, edge_range.x, edge_range.y);
    vec3 a = a_ls;
    a_ls = cut_a ? a + d * t.x : a;
    b_ls = cut_b ? a + d * t.y : b_ls;
    return true;
}

// Corner k of 0 .. 8: three triangles from the apex that cover the sector of radius 1 between the unit vectors `from`
// and `to`, at most half a turn apart; clockwise or not. Offsets from the apex.
vec2 sector_corner(int k, vec2 from, vec2 to, bool clockwise) {
    vec2 across = clockwise ? vec2(from.y, -from.x) : vec2(-from.y, from.x);
    vec2 sum = from + to;
    // Around half a turn the sum says nothing.
    vec2 middle = normalize(dot(sum, sum) > 1e-6 ? sum : across);
    vec2 first = normalize(from + middle);
    vec2 last = normalize(middle + to);
    float longer = 1.0 / max(dot(from, first), 0.5);
    int triangle = k / 3;
    int corner = k - 3 * triangle;
    if (corner == 0) {
        return vec2(0.0);
    }
    int rim = triangle + corner - 1;
    return rim == 0 ? from : (rim == 1 ? first * longer : (rim == 2 ? last * longer : to));
}

// Whether going on from direction `before` to `after` opens a gap between the edges' normals on the given side
// (clockwise: on the outer side, which lies to the left in a map).
float turn_of(vec2 before, vec2 after) {
    return before.x * after.y - before.y * after.x;
}
