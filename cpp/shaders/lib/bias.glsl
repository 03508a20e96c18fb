// Shadow-map bias: how far a receiver may lie behind the stored depth and still count as lit.
// Closed forms on a plane: baselines.md section 1; slopes are exact for planes, the cap is for grazing light.
#define BIAS_NONE 0
#define BIAS_CONSTANT 1
#define BIAS_SLOPE 2
#define BIAS_RECEIVER_PLANE 3
#define BIAS_NORMAL_OFFSET 4
#define BIAS_SECOND_DEPTH 5
#define BIAS_MIDPOINT 6

uniform int bias_mode;
uniform float bias_scale;     // 1: the closed form
uniform float bias_constant;  // texel widths at the receiver
uniform float slope_cap;      // texel widths

// Rounding of float32 depths, relative to the depth.
const float kDepthRounding = 4.8e-7;

vec3 offset_receiver(vec3 p_cr, vec3 n_ws, float texel_m) {
    if (bias_mode != BIAS_NORMAL_OFFSET) {
        return p_cr;
    }
    vec3 l = normalize(to_light(p_cr));
    float sine = length(cross(n_ws, l));
    return p_cr + n_ws * (bias_scale * texel_m * sine);
}

// Metres to take from the receiver's depth before the comparison. `reach` is the distance in texels from the
// receiver to the farthest sample centre along each axis: 1/2 nearest, 1 for 2 x 2, K/2 for K x K.
float depth_bias(MapPoint at, float reach) {
    float bias = at.z_ls * kDepthRounding;
    if (bias_mode == BIAS_NONE) {
        return 0.0;
    }
    bias += bias_constant * at.texel_m;
    if (bias_mode == BIAS_SLOPE) {
        bias += min(bias_scale * reach * (abs(at.slope.x) + abs(at.slope.y)), slope_cap * at.texel_m);
    }
    return bias;
}

// Change of the receiver's depth from the receiver to a sample `offset` texels away; 0 unless its plane is used.
float plane_offset(MapPoint at, vec2 offset) {
    if (bias_mode != BIAS_RECEIVER_PLANE) {
        return 0.0;
    }
    float limit = slope_cap * at.texel_m;
    return clamp(dot(at.slope, offset), -limit, limit);
}
