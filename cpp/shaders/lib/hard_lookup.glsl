// The hard shadow map's own comparison [Williams1978], for every technique that starts from it: the same test to the
// bit. Needs lib/map_lookup.glsl and lib/bias.glsl, `depth_map` and, for BIAS_MODE 6, `second_map`.

struct HardLookup {
    MapPoint at;
    ivec2 texel;
    int layer;
    bool outside;  // in none of the faces
    bool dark;     // behind the stored depth, or turned away from the light point
};

HardLookup look_up_hard(vec3 position_cr, vec3 normal_ws) {
    HardLookup found;
    found.at = find_biased(position_cr, normal_ws);
    // No early return: where pixels of one block part ways, a rasteriser on the CPU pays for both.
    found.outside = found.at.face < 0;
    found.texel = clamp(ivec2(found.at.texel), ivec2(0), ivec2(map.counts.y - 1));
    found.layer = max(found.at.face, 0);
    float z_ls =
        found.at.z_ls - depth_bias(found.at, 0.5) + plane_offset(found.at, vec2(found.texel) + 0.5 - found.at.texel);
    float stored = texelFetch(depth_map, ivec3(found.texel, found.layer), 0).r;
#if BIAS_MODE == 6
    // Compared half-way between the first two layers; a surface with nothing behind it is the last one and lit.
    float second = texelFetch(second_map, ivec3(found.texel, found.layer), 0).r;
    bool lit = second <= 0.0 ||
               z_ls <= 0.5 * (linear_depth(found.layer, stored) + linear_depth(found.layer, second));
#else
    bool lit = window_depth(found.layer, z_ls) >= stored;
#endif
    found.dark = !found.outside && !lit;
#if FACING_TEST
    found.dark = found.dark || found.at.towards_m <= 0.0;
#endif
    return found;
}
