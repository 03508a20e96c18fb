// The hybrid's second step [Chan2004]: a pixel whose four nearest texels agree takes their word; where they differ, a
// shadow's edge may pass, and the pixel is tagged for the volumes.
#include "lib/map_lookup.glsl"
#include "lib/bias.glsl"
#include "lib/receiver.glsl"
#include "techniques/hybrid/classes.glsl"

layout(binding = 0) uniform usampler2D receivers;
#ifdef PCF_FORM
layout(binding = 2) uniform sampler2DArrayShadow depth_map;
#else
layout(binding = 2) uniform sampler2DArray depth_map;
#endif
uniform float bias_texels;  // widths of a texel at the receiver

#if RATIO_CULLING
uniform vec3 pixel_right;  // change of the ray per pixel; the ray itself is position (perspective) or forward
uniform vec3 pixel_up;
uniform vec3 forward;
uniform bool orthographic;
#endif

layout(location = 0) out uint pixel_class;

#if RATIO_CULLING
// Movement on the receiver's plane while the pixel moves by one.
vec3 step_on_plane(vec3 p_cr, vec3 n, vec3 change) {
    if (orthographic) {
        return change - forward * (dot(n, change) / dot(n, forward));
    }
    vec3 moved = dot(p_cr, forward) * change;
    return moved - p_cr * (dot(n, moved) / dot(n, p_cr));
}

// And the movement in the map, in texels.
vec2 step_in_map(int face_index, vec3 p_rel, vec3 step_rel) {
    MapFaceBlock face = MAP_FACE(face_index);
    vec3 p = vec3(dot(face.x_ls_from_rel.xyz, p_rel), dot(face.y_ls_from_rel.xyz, p_rel),
                  dot(face.z_ls_from_rel.xyz, p_rel));
    vec3 d = vec3(dot(face.x_ls_from_rel.xyz, step_rel), dot(face.y_ls_from_rel.xyz, step_rel),
                  dot(face.z_ls_from_rel.xyz, step_rel));
#if MAP_ORTHOGRAPHIC
    return d.xy * face.texel_from_ls.xy;
#else
    return (d.xy * p.z - p.xy * d.z) / (p.z * p.z) * face.texel_from_ls.xy;
#endif
}

// Pixels that a texel spans on the receiver. 1: the scalar estimate, the root of the extents' product along and across
// the slope in the map; 2: the larger extent, so that no pixel is dropped whose edge could be seen in steps.
float texel_extent_px(int face_index, vec3 p_cr, vec3 n) {
    // A plane seen so nearly edge-on that the receiver's packed normal does not tell how nearly.
    if (abs(orthographic ? dot(n, forward) : dot(n, normalize(p_cr))) < 2e-4) {
        return 1e30;
    }
    vec3 p_rel = p_cr - map.origin_cr.xyz;
    vec2 x = step_in_map(face_index, p_rel, step_on_plane(p_cr, n, pixel_right));
    vec2 y = step_in_map(face_index, p_rel, step_on_plane(p_cr, n, pixel_up));
#if RATIO_CULLING == 1
    // dS/dI R_L/R_E cos(beta)/cos(alpha), by the extents' product g r of the thesis' formula with g from the distances.
    vec3 l = to_light(p_cr);
    float light_m = map.light_cr.w > 0.5 ? length(l) : 1.0;
    float eye_m = orthographic ? 1.0 : length(p_cr);
    vec3 ray = orthographic ? forward : p_cr / eye_m;
    float g = (MAP_FACE(face_index).step_ls.z * light_m) / (length(pixel_right) * eye_m);
    return g * abs(dot(n, ray)) / max(abs(dot(n, l)) / length(l), 1e-6);
#else
    float a = dot(x, x), c = dot(y, y), b = dot(x, y);
    // One over the smaller singular value of (x y), by the larger one and their product: the difference of squares
    // would lose all digits where a plane is seen nearly edge-on.
    float area = abs(x.x * y.y - x.y * y.x);
    float longest = sqrt(0.5 * (a + c) + sqrt(0.25 * (a - c) * (a - c) + b * b));
    return area > 0.0 ? longest / area : 1e30;
#endif
}
#endif

void main() {
    Receiver receiver = read_receiver(receivers, ivec2(gl_FragCoord.xy));
    MapPoint at = find_in_map(receiver.position_cr, receiver.normal_ws);
    int layer = max(at.face, 0);
    float size = float(map.counts.y);
    float bias_m = bias_texels * at.texel_m + kDepthRounding * at.z_ls;
#ifdef RECEIVER_PLANE
    bias_m += plane_noise(at);
#endif
    float reference = window_depth(layer, at.z_ls - bias_m);
    vec2 corner = at.texel - 0.5;
    vec2 f = fract(corner);
#ifdef PCF_FORM
    float v = texture(depth_map, vec4(at.texel / size, float(layer), reference));
    bool all_lit = v >= 1.0;
    bool all_dark = v <= 0.0;
    bool nearest_lit = v >= 0.5;
#else
    // w (0, 0), z (1, 0), x (0, 1), y (1, 1)
    vec4 stored = textureGather(depth_map, vec3((floor(corner) + 1.0) / size, float(layer)), 0);
    vec4 depth = vec4(reference);
#ifdef RECEIVER_PLANE
    // Window depth is affine on a plane, in the map's picture as in any.
#if MAP_ORTHOGRAPHIC
    vec4 range_m = MAP_FACE(layer).range_m;
    vec2 gradient = -at.slope / (range_m.y - range_m.x);
#else
    vec2 gradient = -at.slope * MAP_FACE(layer).range_m.x / (at.z_ls * at.z_ls);
#endif
    depth += vec4(dot(gradient, vec2(0.0, 1.0) - f), dot(gradient, vec2(1.0, 1.0) - f),
                  dot(gradient, vec2(1.0, 0.0) - f), dot(gradient, -f));
#endif
    bvec4 lit = greaterThanEqual(depth, stored);
    bool all_lit = all(lit);
    bool all_dark = !any(lit);
    bool nearest_lit = f.y < 0.5 ? (f.x < 0.5 ? lit.w : lit.z) : (f.x < 0.5 ? lit.x : lit.y);
#endif
    uint found = all_lit ? kMapLit : all_dark ? kMapShadow : kTagged;
    // Texels beyond the map's border are unknown.
    if (any(lessThan(at.texel, vec2(0.5))) || any(greaterThan(at.texel, vec2(size - 0.5)))) {
        found = kTagged;
    }
#if RATIO_CULLING
    if (found == kTagged && texel_extent_px(layer, receiver.position_cr, normalize(receiver.normal_ws)) < 1.0) {
        found = nearest_lit ? kMapLit : kMapShadow;
    }
#endif
    found = at.face < 0 ? kOutside : found;
#if FACING_TEST
    found = at.towards_m <= 0.0 ? kBack : found;
#endif
    pixel_class = receiver.seen ? found : kNothing;
}
