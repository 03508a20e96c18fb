// Percentage-closer filtering [Reeves1987]: compare first, then average with the filter's weights.
#include "lib/map_lookup.glsl"
#include "lib/bias.glsl"
#include "lib/receiver.glsl"

layout(binding = 0) uniform usampler2D receivers;
layout(binding = 2) uniform sampler2DArray depth_map;
#if FILTER == 2
layout(binding = 3) uniform sampler2DArrayShadow depth_map_compare;
#endif
#if FILTER == 3
uniform int kernel;
#endif
#if MASK
layout(binding = 4) uniform sampler2DArray window_range;
#endif

layout(location = 0) out float visibility;

// One comparison. `reference` is the receiver's window depth, made once where it is the same for all texels.
float lit(MapPoint at, ivec2 texel, float z_ls, float reference) {
    float stored = texelFetch(depth_map, ivec3(texel, at.face), 0).r;
#if BIAS_MODE == 3
    reference = window_depth(at.face, z_ls + plane_offset(at, vec2(texel) + 0.5 - at.texel));
#endif
    return reference >= stored ? 1.0 : 0.0;
}

// The filter's first texel, such that all of its texels lie in the map; the frustum's margin makes this a formality.
ivec2 first_texel(vec2 wanted, int width) {
    return clamp(ivec2(floor(wanted)), ivec2(0), ivec2(map.counts.y - width));
}

// Cubic B-spline weights of the four texels around the fraction f.
vec4 bspline(float f) {
    float g = 1.0 - f;
    return vec4(g * g * g, 3.0 * f * f * f - 6.0 * f * f + 4.0, -3.0 * f * f * f + 3.0 * f * f + 3.0 * f + 1.0,
                f * f * f) / 6.0;
}

// A driver may divide by way of a rounded reciprocal; all lit is exactly 1 all the same.
float mean(float sum, float whole) {
    return sum >= whole ? 1.0 : sum / whole;
}

float filtered(MapPoint at) {
#if FILTER == 0  // 2 x 2, bilinear weights
    ivec2 base = first_texel(at.texel - 0.5, 2);
    vec2 f = at.texel - 0.5 - vec2(base);
    float z_ls = at.z_ls - depth_bias(at, 1.0);
    float reference = window_depth(at.face, z_ls);
    // a + (b - a) f rather than mix(): exactly 1 where all four are lit.
    vec2 left = vec2(lit(at, base, z_ls, reference), lit(at, base + ivec2(0, 1), z_ls, reference));
    vec2 right = vec2(lit(at, base + ivec2(1, 0), z_ls, reference), lit(at, base + ivec2(1, 1), z_ls, reference));
    vec2 rows = left + (right - left) * f.x;
    return rows.x + (rows.y - rows.x) * f.y;
#elif FILTER == 1  // bicubic, 16 comparisons
    ivec2 first = first_texel(at.texel - 1.5, 4);
    vec2 f = at.texel - 1.5 - vec2(first);
    float z_ls = at.z_ls - depth_bias(at, 2.0);
    float reference = window_depth(at.face, z_ls);
    vec4 wx = bspline(f.x), wy = bspline(f.y);
    precise float sum = 0.0, whole = 0.0;
    for (int j = 0; j < 4; ++j) {
        for (int i = 0; i < 4; ++i) {
            precise float weight = wx[i] * wy[j];
            sum += lit(at, first + ivec2(i, j), z_ls, reference) > 0.5 ? weight : 0.0;
            whole += weight;
        }
    }
    return mean(sum, whole);
#elif FILTER == 2  // bicubic by four bilinear comparisons of the hardware: the same sum, regrouped
    vec2 s = at.texel - 0.5;
    vec2 base = floor(s), f = s - base;
    float reference = window_depth(at.face, at.z_ls - depth_bias(at, 2.0));
    vec4 wx = bspline(f.x), wy = bspline(f.y);
    vec2 gx = vec2(wx.x + wx.y, wx.z + wx.w), gy = vec2(wy.x + wy.y, wy.z + wy.w);
    vec2 hx = vec2(-1.0 + wx.y / gx.x, 1.0 + wx.w / gx.y), hy = vec2(-1.0 + wy.y / gy.x, 1.0 + wy.w / gy.y);
    float size = float(map.counts.y);
    precise float sum = 0.0, whole = 0.0;
    for (int j = 0; j < 2; ++j) {
        for (int i = 0; i < 2; ++i) {
            vec2 uv = (base + 0.5 + vec2(hx[i], hy[j])) / size;
            sum += gx[i] * gy[j] * texture(depth_map_compare, vec4(uv, float(at.face), reference));
            whole += gx[i] * gy[j];
        }
    }
    return mean(sum, whole);
#else  // kernel x kernel box, its two outermost texels weighted so that the box slides smoothly
    float z_ls = at.z_ls - depth_bias(at, 0.5 * float(kernel) + 0.5);
    float reference = window_depth(at.face, z_ls);
    // The box [texel - kernel/2, texel + kernel/2] covers kernel + 1 texels, the first and last of them partly.
    vec2 low = at.texel - 0.5 * float(kernel);
    ivec2 first = first_texel(low, kernel + 1);
    vec2 cut = clamp(low - vec2(first), 0.0, 1.0);
    precise float sum = 0.0, whole = 0.0;  // summed alike, no fused steps, so that all lit is exactly 1
    int last = kernel;
#if MASK
    // Nothing under the kernel is nearer than the receiver, or all of it is: the sum is known. A loop that ends at once,
    // rather than a return, spares a rasteriser on the CPU the work where a whole block of pixels is sure.
    vec2 range = texelFetch(window_range, ivec3(first, at.face), 0).rg;
    bool all_lit = reference >= range.x, all_dark = reference < range.y;
    last = all_lit || all_dark ? -1 : last;
    sum = all_lit ? 1.0 : 0.0;
    whole = all_lit || all_dark ? 1.0 : 0.0;
#endif
    for (int j = 0; j <= last; ++j) {
        float wy = j == 0 ? 1.0 - cut.y : (j == kernel ? cut.y : 1.0);
        for (int i = 0; i <= kernel; ++i) {
            float wx = i == 0 ? 1.0 - cut.x : (i == kernel ? cut.x : 1.0);
            precise float weight = wx * wy;
            sum += lit(at, first + ivec2(i, j), z_ls, reference) > 0.5 ? weight : 0.0;
            whole += weight;
        }
    }
    return mean(sum, whole);
#endif
}

void main() {
    Receiver receiver = read_receiver(receivers, ivec2(gl_FragCoord.xy));
    MapPoint at = find_biased(receiver.position_cr, receiver.normal_ws);
    bool outside = at.face < 0;
    at.face = max(at.face, 0);
    float v = outside ? 1.0 : clamp(filtered(at), 0.0, 1.0);
#if FACING_TEST
    v = at.towards_m > 0.0 ? v : 0.0;
#endif
    visibility = receiver.seen ? v : 1.0;
}
