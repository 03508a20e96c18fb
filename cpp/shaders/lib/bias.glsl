// Shadow-map bias: how far a receiver may lie behind the stored depth and still count as lit.
// Closed forms on a plane: baselines.md section 1; slopes are exact for planes, the cap is for grazing light.
// BIAS_MODE is compiled in: 0 none, 1 constant, 2 slope, 3 receiver plane, 4 normal offset, 5 second depth, 6 midpoint.

uniform float bias_scale;     // 1: the closed form
uniform float bias_constant;  // texel widths at the receiver
uniform float slope_cap;      // texel widths
#ifdef BIAS_METRES
uniform float bias_metres;  // how far casters stand in front of what is seen (simplified casters)
#else
const float bias_metres = 0.0;
#endif

// Rounding of float32 depths, relative to the depth.
const float kDepthRounding = 4.8e-7;
// Rasterisers snap vertices to 1/256 of a texel, so that a stored plane stands aside by as much.
const float kSnap = 1.0 / 256.0;

// Metres by which the plane that a map holds of a receiver may lie before the receiver's own: its vertices are snapped,
// and positions are rounded across the plane, which the light sees the longer the lower it stands over it. Under grazing
// light that is more than any bias that is given in texels' widths.
float plane_noise(MapPoint at) {
#if MAP_ORTHOGRAPHIC
    vec4 range_m = MAP_FACE(max(at.face, 0)).range_m;
    float from_eye_m = length(map.origin_cr.xyz) + range_m.y - range_m.x;
    float rounded = kDepthRounding * from_eye_m / max(abs(at.towards_m), 1e-8);
#else
    float from_eye_m = length(map.origin_cr.xyz) + at.z_ls;  // at most: positions are rounded relative to the eye
    float rounded = kDepthRounding * from_eye_m * at.z_ls / max(abs(at.towards_m), 1e-8 * at.z_ls);
#endif
    return kSnap * (abs(at.slope.x) + abs(at.slope.y)) + rounded;
}

// Where the receiver lies in the map, moved along its normal first where that is the bias.
MapPoint find_biased(vec3 p_cr, vec3 n_ws) {
    MapPoint at = find_in_map(p_cr, n_ws);
#if BIAS_MODE == 4
    vec3 l = normalize(to_light(p_cr));
    vec3 n = normalize(n_ws);
    float sine = length(cross(n, l));
    MapPoint moved = find_in_map(p_cr + n * (bias_scale * at.texel_m * sine), n_ws);
    if (moved.face >= 0) {
        at = moved;
    }
#endif
    return at;
}

// Metres to take from the receiver's depth before the comparison. `reach` is the distance in texels from the
// receiver to the farthest sample centre along each axis: 1/2 nearest, 1 for 2 x 2, K/2 for K x K.
float depth_bias(MapPoint at, float reach) {
#if BIAS_MODE == 0
    return 0.0;
#elif BIAS_MODE == 2
    float slope = min(bias_scale * reach * (abs(at.slope.x) + abs(at.slope.y)), slope_cap * at.texel_m);
    return bias_metres + at.z_ls * kDepthRounding + bias_constant * at.texel_m + slope;
#elif BIAS_MODE == 3
    return bias_metres + at.z_ls * kDepthRounding + bias_constant * at.texel_m +
           min(plane_noise(at), slope_cap * at.texel_m);
#else
    return bias_metres + at.z_ls * kDepthRounding + bias_constant * at.texel_m;
#endif
}

// Change of the receiver's depth from the receiver to a sample `offset` texels away; 0 unless its plane is used.
float plane_offset(MapPoint at, vec2 offset) {
#if BIAS_MODE == 3
    float limit = slope_cap * at.texel_m;
    return clamp(dot(at.slope, offset), -limit, limit);
#else
    return 0.0;
#endif
}
