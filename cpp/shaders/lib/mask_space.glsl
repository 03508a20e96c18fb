// Depth in the penumbra mask's maps: w, positive and larger the nearer, affine in the image: 1 / z_ls; orthographic:
// far - z_ls. A light with half axes d_i in light space throws, from a receiver at (p, w_r), the window
// |p' - p| <= (w - w_r) |d_i.xy - p d_i.z| / (1 - d_z w_r) at depth w: what lies in it may block part of the light.
// docs/decisions/0011-penumbra-mask.md. Needs lib/map_lookup.glsl.

float mask_w(int face, float z_ls) {
#if MAP_ORTHOGRAPHIC
    return MAP_FACE(face).range_m.y - z_ls;
#else
    return 1.0 / max(z_ls, 1e-30);
#endif
}

float mask_w_from_stored(int face, float stored) {
    vec4 range_m = MAP_FACE(face).range_m;
#if MAP_ORTHOGRAPHIC
    return stored * (range_m.y - range_m.x);
#else
    return stored / range_m.x;
#endif
}
