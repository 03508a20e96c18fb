// Class of each pixel under an extended light: PENUMBRA_MASK_MAYBE, _LIT or _UMBRA (lib/mask_class.glsl).
//
// A pixel sees either all of the light or nothing of it unless an edge that may be a silhouette for some point of the
// light lies between the two: within the window that the light throws through the map, nearer than the pixel. No such
// edge: what the light's centre sees decides. docs/decisions/0011-penumbra-mask.md.
#include "lib/map_lookup.glsl"
#include "lib/mask_space.glsl"
#include "lib/mask_class.glsl"
#include "lib/receiver.glsl"

layout(binding = 0) uniform usampler2D receivers;
layout(binding = 2) uniform sampler2DArray depth_map;
#if TEST_DEPTH
#include "lib/depth_pyramid.glsl"
layout(binding = 3) uniform sampler2DArray depth_pyramid;
#else
layout(binding = 3) uniform sampler2DArray nearest_edge;
#endif
uniform vec3 half_ws[3];   // the light's half axes; sun: tangents across its direction
uniform int top_level;     // of the pyramid
uniform float lit_texels;    // a stored depth nearer by up to this share of a texel's depth range is the pixel's own
uniform float umbra_texels;  // from this on it is a caster

layout(location = 0) out float found_class;

const float kRoundedTexels = 0.02;

// The face whose axis is nearest to the direction of the pixel: windows then leave it as late as can be.
int best_face(vec3 p_rel) {
    int best = 0;
#if MAP_FACES > 1
    float most = -1.0;
    for (int i = 0; i < MAP_FACES; ++i) {
        float z = dot(map.faces[i].z_ls_from_rel.xyz, p_rel);
        best = z > most ? i : best;
        most = max(z, most);
    }
#endif
    return best;
}

// Half the window at w = w_r + 1, in texels; and how far the light reaches along the map's axis, in metres.
vec3 window_of(int face_index, vec2 p) {
    MapFaceBlock face = MAP_FACE(face_index);
    vec3 sums = vec3(0.0);
    for (int i = 0; i < 3; ++i) {
        vec3 d = vec3(dot(face.x_ls_from_rel.xyz, half_ws[i]), dot(face.y_ls_from_rel.xyz, half_ws[i]),
                      dot(face.z_ls_from_rel.xyz, half_ws[i]));
#if MAP_ORTHOGRAPHIC
        vec3 reach = vec3(d.xy, 0.0);
#else
        vec3 reach = vec3(d.xy - p * d.z, d.z);
#endif
#if ROUND
        sums += reach * reach;
#else
        sums += abs(reach);
#endif
    }
#if ROUND
    sums = sqrt(sums);
#endif
    return vec3(sums.xy * face.texel_from_ls.xy, sums.z);
}

#if TEST_DEPTH

// Nearest and farthest w of the window that the nearest caster leaves, in front of the pixel's plane: x at most, y at
// least. The issue's test, for comparison: blind for what lies between texels, and for gaps between two surfaces.
vec2 in_front_of_plane(int face, vec2 texel, float w_r, vec2 per_w, vec2 per_texel) {
    float size = float(map.counts.y);
    float w_near = 1e30;
    vec2 range = vec2(0.0), reach = vec2(size);
    for (int i = 0; i < 4; ++i) {
        reach = min(max(w_near - w_r, 0.0) * per_w + 1.0, vec2(size));
        ivec2 low = ivec2(clamp(texel - reach, 0.5, size - 0.5));
        ivec2 high = ivec2(clamp(texel + reach, 0.5, size - 0.5));
        range = depth_range(depth_pyramid, face, low, high);
        w_near = min(w_near, mask_w_from_stored(face, range.x));
    }
    float tilt = dot(abs(per_texel), reach);
    return vec2(w_near - w_r - tilt, mask_w_from_stored(face, range.y) - w_r - tilt);
}
#else

// Whether an edge in the window is nearer than the pixel. Loops that end, rather than returns: a rasteriser on the CPU
// leaves a loop once no pixel of a block is in it.
bool edge_in_window(bool asked, int face, vec2 texel, float w_r, vec2 per_w) {
    float size = float(map.counts.y);
    float w_behind = w_r * (1.0 + 2e-6);
    float w_near = texelFetch(nearest_edge, ivec3(0, 0, face), top_level).r;
    ivec2 low = ivec2(0), high = ivec2(0);
    bool open = asked;
    for (int i = 0; i < 4 && open; ++i) {
        // No edge is nearer than w_near: none beyond this window matters. In it the nearest is deeper again.
        vec2 reach = max(w_near - w_r, 0.0) * per_w + kRoundedTexels;
        low = ivec2(clamp(texel - reach, 0.5, size - 0.5));
        high = ivec2(clamp(texel + reach, 0.5, size - 0.5));
        int span = max(high.x - low.x, high.y - low.y);
        int level = span > 2 ? findMSB(span - 1) : 0;
        ivec2 first = low >> level, last = high >> level;
        float found = 0.0;
        for (int y = 0; y < 3; ++y) {
            for (int x = 0; x < 3; ++x) {
                ivec2 at = min(first + ivec2(x, y), last);
                found = max(found, texelFetch(nearest_edge, ivec3(at, face), level).r);
            }
        }
        w_near = min(w_near, found);
        open = w_near > w_behind;
    }
    // What is left, in finer squares, each with a window of its own.
    int span = max(high.x - low.x, high.y - low.y);
    int level = span > 4 ? findMSB(span - 1) - 1 : 0;
    ivec2 first = low >> level, last = high >> level;
    bool found = false;
    for (int y = 0; y < 5 && open && !found; ++y) {
        for (int x = 0; x < 5; ++x) {
            ivec2 at = min(first + ivec2(x, y), last);
            float w = texelFetch(nearest_edge, ivec3(at, face), level).r;
            vec2 from = vec2(at << level), to = vec2((at + 1) << level);
            vec2 apart = max(max(from - texel, texel - to), 0.0);
            found = found || (w > w_behind && all(lessThanEqual(apart, (w - w_r) * per_w + kRoundedTexels)));
        }
    }
    return found;
}

#endif

float classify(bool seen, vec3 position_cr, vec3 normal_ws) {
    vec3 p_rel = position_cr - map.origin_cr.xyz;
    int face = best_face(p_rel);
    MapPoint at = find_in_face(face, p_rel, normal_ws);
    bool known = at.face >= 0;
    MapFaceBlock block = MAP_FACE(face);
    vec2 p = (at.texel - block.texel_from_ls.zw) / block.texel_from_ls.xy;
    vec3 window = window_of(face, p);
    float w_r = mask_w(face, at.z_ls);
#if MAP_ORTHOGRAPHIC
    vec2 per_w = window.xy;
    float slope_w = 1.0;
#else
    known = known && at.z_ls > 2.0 * window.z;  // else among the points of the light
    vec2 per_w = window.xy / max(1.0 - window.z * w_r, 0.5);
    float slope_w = w_r * w_r;  // w per metre of depth
#endif
    vec2 per_texel = -at.slope * slope_w;  // of the w of the pixel's plane
#if TEST_DEPTH
    vec2 in_window = in_front_of_plane(face, at.texel, w_r, per_w, per_texel);
    float step_w = (at.texel_m + abs(at.slope.x) + abs(at.slope.y)) * slope_w;
    bool maybe = !known || (in_window.x > lit_texels * step_w && in_window.y < umbra_texels * step_w);
#else
    bool maybe = !known || edge_in_window(seen && known, face, at.texel, w_r, per_w);
#endif

    // The four texels around: one surface, in front of the pixel or its own.
    float range = (at.texel_m + abs(at.slope.x) + abs(at.slope.y)) * slope_w;
    ivec2 base = ivec2(floor(at.texel - 0.5));
    float least = 1e30, most = -1e30;
    for (int i = 0; i < 4; ++i) {
        ivec2 texel = clamp(base + ivec2(i & 1, i >> 1), ivec2(0), ivec2(map.counts.y - 1));
        float w = mask_w_from_stored(face, texelFetch(depth_map, ivec3(texel, face), 0).r);
        float in_front = w - (w_r + dot(per_texel, vec2(texel) + 0.5 - at.texel));
        least = min(least, in_front);
        most = max(most, in_front);
    }
    float rounding = 4e-6 * w_r;
    bool lit = most <= lit_texels * range + rounding;
    bool umbra = least >= umbra_texels * range + rounding;
    return maybe || !(lit || umbra) ? PENUMBRA_MASK_MAYBE : (lit ? PENUMBRA_MASK_LIT : PENUMBRA_MASK_UMBRA);
}

void main() {
    Receiver receiver = read_receiver(receivers, ivec2(gl_FragCoord.xy));
    float found = classify(receiver.seen, receiver.position_cr, receiver.normal_ws);
    found_class = receiver.seen ? found : PENUMBRA_MASK_LIT;
}
