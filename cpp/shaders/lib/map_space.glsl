// Drawing into a map's own space: cones, sheets, quads. Needs `map` and MAP_ORTHOGRAPHIC of lib/map_lookup.glsl.
//
// Image plane "ip": x_ls / z_ls and y_ls / z_ls (tangents), orthographic: x_ls and y_ls in metres. w_ls: 1 / z_ls.
// z_ls points away from the light, so the picture is mirrored: with the blocker on the left of an observer at the light,
// the outer normal of an edge with unit direction e is (-e.y, e.x) here.

vec3 ls_from_rel(int face_index, vec3 p_rel) {
    MapFaceBlock face = map.faces[face_index];
    return vec3(dot(face.x_ls_from_rel.xyz, p_rel), dot(face.y_ls_from_rel.xyz, p_rel),
                dot(face.z_ls_from_rel.xyz, p_rel));
}

// Clip position of a point of the image plane: w = 1, so that varyings are affine in the window; depth is not used.
vec4 clip_from_ip(int face_index, vec2 p_ip) {
    vec4 extent = map.faces[face_index].low_high;
    return vec4((2.0 * p_ip - extent.xy - extent.zw) / (extent.zw - extent.xy), 0.5, 1.0);
}

// Image-plane position of a fragment's centre (gl_FragCoord.xy).
vec2 ip_from_texel(int face_index, vec2 texel) {
    MapFaceBlock face = map.faces[face_index];
    return (texel - face.texel_from_ls.zw) / face.texel_from_ls.xy;
}

// 1 / z_ls from a stored depth, perspective faces; 0 where nothing is stored.
float inverse_depth(int face_index, float stored) {
    return stored / map.faces[face_index].range_m.x;
}
