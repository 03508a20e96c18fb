// How wide a smoothie is, in units of the image plane. u: reversed window depth, affine in the image plane.
//
// WIDTH_SHAPE: 0 disc (or fixed), 1 parallelogram, 2 ellipse, 3 polygon. FIXED_WIDTH: the plain t, which does not follow
// the light: half widths are then per 1/u. REMAP 0: without Eq. 1, the same width at every receiver.

uniform int face_index;
uniform vec4 axes;  // xy and zw half axes of the light in x_ls, y_ls, per unit of u; disc: x the radius
#if WIDTH_SHAPE == 3
uniform vec4 corners[8];  // xy
uniform int corner_count;
#endif
uniform float largest_axis;

// How far the lit rim lies behind a straight edge, per unit of u between blocker and receiver.
float half_width(vec2 outer_normal) {
#if WIDTH_SHAPE == 0
    return axes.x;
#elif WIDTH_SHAPE == 1
    return abs(dot(axes.xy, outer_normal)) + abs(dot(axes.zw, outer_normal));
#elif WIDTH_SHAPE == 2
    return length(vec2(dot(axes.xy, outer_normal), dot(axes.zw, outer_normal)));
#else
    float widest = 0.0;
    for (int i = 0; i < corner_count; ++i) {
        widest = max(widest, -dot(corners[i].xy, outer_normal));
    }
    return widest;
#endif
}

float largest_half_width() {
    return largest_axis;
}

// Eq. 1: width t becomes t (1 - b/r), which is t (u_b - u_r) / u_b; a light's t is its half width times u_b.
float ramp_width(float half_width, float u_b, float u_r) {
#if FIXED_WIDTH && REMAP
    return u_b > u_r ? half_width * (1.0 - u_r / u_b) : 0.0;
#elif FIXED_WIDTH
    return u_b > u_r ? half_width : 0.0;
#elif REMAP
    return half_width * (u_b - u_r);
#else
    return u_b > u_r ? half_width * u_b : 0.0;
#endif
}
