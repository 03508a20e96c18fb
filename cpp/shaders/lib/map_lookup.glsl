// Finding a receiver in a depth map: which face, where, how deep, and how fast the depth changes.
#include "shared/map_block.h"

layout(std140, binding = 1) uniform Map { MapBlock map; };

struct MapPoint {
    int face;        // layer of the map, -1: in none of the faces
    vec2 texel;      // continuous texel coordinates, centres at integer + 0.5
    float z_ls;      // linear depth, metres
    vec2 slope;      // change of z_ls of the receiver's plane per texel in x and y, metres
    float texel_m;   // width of a texel at the receiver, metres
};

// Vector to the light from a receiver, not normalised; sun: unit direction.
vec3 to_light(vec3 p_cr) {
    return map.light_cr.w > 0.5 ? map.light_cr.xyz - p_cr : map.light_cr.xyz;
}

MapPoint find_in_map(vec3 p_cr, vec3 n_ws) {
    vec3 p_rel = p_cr - map.origin_cr.xyz;
    MapPoint found;
    found.face = -1;
    float size = float(map.counts.y);
    for (int i = 0; i < map.counts.x; ++i) {
        MapFaceBlock face = map.faces[i];
        vec3 p = vec3(dot(face.x_ls_from_rel.xyz, p_rel), dot(face.y_ls_from_rel.xyz, p_rel),
                      dot(face.z_ls_from_rel.xyz, p_rel));
        bool orthographic = face.range_m.z > 0.5;
        if (!orthographic && p.z <= 0.0) {
            continue;
        }
        vec2 extent = face.low_high.zw - face.low_high.xy;
        vec2 at = orthographic ? p.xy : p.xy / p.z;
        vec2 unit = (at - face.low_high.xy) / extent;
        if (any(lessThan(unit, vec2(0.0))) || any(greaterThan(unit, vec2(1.0)))) {
            continue;
        }
        vec3 n = vec3(dot(face.x_ls_from_rel.xyz, n_ws), dot(face.y_ls_from_rel.xyz, n_ws),
                      dot(face.z_ls_from_rel.xyz, n_ws));
        found.face = i;
        found.texel = unit * size;
        found.z_ls = p.z;
        vec2 step = extent / size;
        if (orthographic) {
            found.slope = -n.xy / (abs(n.z) > 1e-8 ? n.z : 1e-8) * step;
            found.texel_m = max(step.x, step.y);
        } else {
            float d = dot(n, p);
            found.slope = -p.z * p.z * n.xy / (abs(d) > 1e-8 * p.z ? d : 1e-8 * p.z) * step;
            found.texel_m = max(step.x, step.y) * p.z;
        }
        return found;
    }
    return found;
}

// Window depth (reversed: 1 near, 0 far) of a linear depth; greater is nearer to the light.
float window_depth(int face_index, float z_ls) {
    MapFaceBlock face = map.faces[face_index];
    return face.range_m.z > 0.5 ? (face.range_m.y - z_ls) / (face.range_m.y - face.range_m.x)
                                : face.range_m.x / max(z_ls, 1e-30);
}

float linear_depth(int face_index, float depth) {
    MapFaceBlock face = map.faces[face_index];
    return face.range_m.z > 0.5 ? face.range_m.y - depth * (face.range_m.y - face.range_m.x)
                                : face.range_m.x / max(depth, 1e-30);
}
