// Finding a receiver in a depth map: which face, where, how deep, and how fast the depth changes.
//
// MAP_FACES (1 .. 6) and MAP_ORTHOGRAPHIC (0, 1) are compiled in: most lights need one face, and a loop over faces or a
// branch on the projection would cost more than the comparison itself.
#include "shared/map_block.h"

layout(std140, binding = 1) uniform Map { MapBlock map; };

// A constant index where there is one face: an index that varies would be gathered pixel by pixel.
#if MAP_FACES == 1
#define MAP_FACE(i) map.faces[0]
#else
#define MAP_FACE(i) map.faces[i]
#endif

struct MapPoint {
    int face;         // layer of the map, -1: in none of the faces
    vec2 texel;       // continuous texel coordinates, centres at integer + 0.5
    float z_ls;       // linear depth, metres
    vec2 slope;       // change of z_ls of the receiver's plane per texel in x and y, metres
    float texel_m;    // width of a texel at the receiver, metres
    float towards_m;  // distance of the light point from the receiver's plane: > 0 if the surface faces it;
                      // orthographic: the cosine; both times the length of the normal that was given
};

MapPoint find_in_face(int face_index, vec3 p_rel, vec3 n_ws) {
    MapFaceBlock face = MAP_FACE(face_index);
    vec3 p = vec3(dot(face.x_ls_from_rel.xyz, p_rel), dot(face.y_ls_from_rel.xyz, p_rel),
                  dot(face.z_ls_from_rel.xyz, p_rel));
    vec2 n = vec2(dot(face.x_ls_from_rel.xyz, n_ws), dot(face.y_ls_from_rel.xyz, n_ws));
    MapPoint found;
    found.z_ls = p.z;
#if MAP_ORTHOGRAPHIC
    float nz = dot(face.z_ls_from_rel.xyz, n_ws);
    found.texel = p.xy * face.texel_from_ls.xy + face.texel_from_ls.zw;
    found.towards_m = -nz;
    float per_texel = 1.0 / (abs(nz) > 1e-8 ? nz : 1e-8);
    found.slope = -n * per_texel * face.step_ls.xy;
    found.texel_m = face.step_ls.z;
    bool inside = true;
#else
    float d = dot(n_ws, p_rel);  // of the plane from the light point
    found.texel = p.xy / p.z * face.texel_from_ls.xy + face.texel_from_ls.zw;
    found.towards_m = -d;
    float per_texel = p.z * p.z / (abs(d) > 1e-8 * p.z ? d : 1e-8 * p.z);
    found.slope = -n * per_texel * face.step_ls.xy;
    found.texel_m = face.step_ls.z * p.z;
    bool inside = p.z > 0.0;
#endif
    float size = float(map.counts.y);
    inside = inside && all(greaterThanEqual(found.texel, vec2(0.0))) && all(lessThanEqual(found.texel, vec2(size)));
    found.face = inside ? face_index : -1;
    return found;
}

MapPoint find_in_map(vec3 p_cr, vec3 n_ws) {
    vec3 p_rel = p_cr - map.origin_cr.xyz;
    MapPoint found = find_in_face(0, p_rel, n_ws);
#if MAP_FACES > 1
    for (int i = 1; i < MAP_FACES && found.face < 0; ++i) {
        found = find_in_face(i, p_rel, n_ws);
    }
#endif
    return found;
}

// Vector to the light from a receiver, not normalised; sun: unit direction.
vec3 to_light(vec3 p_cr) {
    return map.light_cr.w > 0.5 ? map.light_cr.xyz - p_cr : map.light_cr.xyz;
}

// Window depth (reversed: 1 near, 0 far) of a linear depth; greater is nearer to the light.
float window_depth(int face_index, float z_ls) {
#if MAP_ORTHOGRAPHIC
    vec4 range_m = MAP_FACE(face_index).range_m;
    return (range_m.y - z_ls) / (range_m.y - range_m.x);
#else
    return MAP_FACE(face_index).range_m.x / max(z_ls, 1e-30);
#endif
}

float linear_depth(int face_index, float depth) {
    vec4 range_m = MAP_FACE(face_index).range_m;
#if MAP_ORTHOGRAPHIC
    return range_m.y - depth * (range_m.y - range_m.x);
#else
    return range_m.x / max(depth, 1e-30);
#endif
}
