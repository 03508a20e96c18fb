// V of one linear light from its maps [linear-light-soft-shadow-maps 2.7, 2.8]: per segment between neighbouring samples
// the sum of what either end says, weighted by the segment's share of the light.
#include "lib/map_lookup.glsl"
#include "lib/bias.glsl"
#include "lib/receiver.glsl"

layout(binding = 0) uniform usampler2D receivers;
layout(binding = 2) uniform sampler2DArray depth_map;
layout(binding = 3) uniform sampler2DArray channel_map;
#if SURFACE_MAP
layout(binding = 4) uniform sampler2DArray surface_map;  // what the channels are of, where some of it casts no shadow
#endif

uniform int first_layer;
uniform vec4 views[SAMPLES * MAP_FACES];  // per window and sample: texel minus the central view's: x * d + y
uniform vec4 places[SAMPLES];             // x along the rod, y share of the segment to the next sample
uniform vec4 windows[MAP_FACES];          // x most |v|, y most distance along u, both per depth
uniform float rim;                        // perspective: share of the depth; orthographic: metres
uniform float weight;                     // of this light among those that stand for the whole

#if SUM
layout(location = 0) out vec2 sums;  // x weighted visibility, y weight
#else
layout(location = 0) out float visibility;
#endif

struct End {
    vec2 seen;        // of the segments before and after this sample, what it says
    float towards_m;  // > 0: the surface faces this sample
    float local;      // weight of this sample's light at the surface
};

MapPoint find_window(vec3 p_rel, vec3 n_ws) {
    MapPoint found = find_in_face(0, p_rel, n_ws);
#if ONE_WINDOW
    found.face = 0;
#else
    for (int i = 0; i < MAP_FACES; ++i) {
        MapFaceBlock face = map.faces[i];
        vec3 p = vec3(dot(face.x_ls_from_rel.xyz, p_rel), dot(face.y_ls_from_rel.xyz, p_rel),
                      dot(face.z_ls_from_rel.xyz, p_rel));
        bool inside = p.z > 0.0 && abs(p.y) <= windows[i].x * p.z &&
                      p.x - places[0].x <= windows[i].y * p.z && places[SAMPLES - 1].x - p.x <= windows[i].y * p.z;
        if (inside) {
            found = find_in_face(i, p_rel, n_ws);
            found.face = i;
            break;
        }
        found.face = -1;
    }
#endif
    return found;
}

// A light's value per texel of depth: d of stored = d * stored_per_d.
float inverse_distance(MapPoint at) {
#if MAP_ORTHOGRAPHIC
    return MAP_FACE(at.face).range_m.y - at.z_ls;
#else
    return 1.0 / max(at.z_ls, 1e-30);
#endif
}

End look_up(MapPoint at, float d, float n_u, float per_texel_m, vec2 n_step, int i) {
    End end;
    int window = max(at.face, 0);
    vec2 shift = views[window * SAMPLES + i].xy;
    at.texel.x += shift.x * d + shift.y;
    end.towards_m = at.towards_m + places[i].x * n_u;
#if BIAS_MODE == 2 || BIAS_MODE == 3
    float least = 1e-8 * (MAP_ORTHOGRAPHIC == 1 ? 1.0 : at.z_ls);
    at.slope = n_step * (per_texel_m / (abs(end.towards_m) > least ? end.towards_m : least));
#endif
    float size = float(map.counts.y);
    bool outside = any(lessThan(at.texel, vec2(0.0))) || any(greaterThan(at.texel, vec2(size)));
    ivec2 texel = clamp(ivec2(at.texel), ivec2(0), ivec2(map.counts.y - 1));
    ivec3 where = ivec3(texel, first_layer + window * SAMPLES + i);
    float stored = texelFetch(depth_map, where, 0).r;
    vec2 v = texelFetch(channel_map, where, 0).rg;
#if CONFLICT_MIN
    v = mix(v, vec2(0.5), greaterThan(v, vec2(1.5)));  // where no skin was drawn
#endif
    float z_ls = at.z_ls - depth_bias(at, 0.5) + plane_offset(at, vec2(texel) + 0.5 - at.texel);
    bool dark = window_depth(window, z_ls) < stored;
#if RIM
    // The entry is of another surface, well behind: on a caster's rim the nearest texel is not the caster's.
#if SURFACE_MAP
    float entry = texelFetch(surface_map, where, 0).r;
#else
    float entry = stored;
#endif
#if MAP_ORTHOGRAPHIC
    bool other = entry < window_depth(window, at.z_ls + rim);
#else
    bool other = entry < window_depth(window, at.z_ls) * (1.0 - rim);
#endif
    v = other ? vec2(0.5) : v;
#endif
    v = outside ? vec2(0.5) : v;
    end.seen = dark && !outside ? vec2(0.0) : v;
#if FACING_TEST
    end.seen = end.towards_m <= 0.0 ? vec2(0.0) : end.seen;
#endif
    return end;
}

float segment(End before, End after) {
    float a = before.seen.y;
    float b = after.seen.x;
#if FACING_TEST
    // The surface's own plane hides the rest of a segment that crosses it.
    bool crosses = (before.towards_m > 0.0) != (after.towards_m > 0.0);
    float facing = max(before.towards_m, after.towards_m) /
                   max(abs(before.towards_m - after.towards_m), 1e-30);
    float only = max(a, b);
    only = min(only == 0.5 ? 1.0 : only, facing);
    a = crosses ? only : a;
    b = crosses ? 0.0 : b;
#endif
    float sum = a + b;
#if CLAMP
    sum = min(sum, 1.0);
#endif
    return sum;
}

void main() {
    Receiver receiver = read_receiver(receivers, ivec2(gl_FragCoord.xy));
    vec3 p_rel = receiver.position_cr - map.origin_cr.xyz;
    MapPoint at = find_window(p_rel, receiver.normal_ws);
    int window = max(at.face, 0);
    float d = inverse_distance(at);
    MapFaceBlock face = MAP_FACE(window);
    float n_u = dot(face.x_ls_from_rel.xyz, receiver.normal_ws);
    vec2 n_step = vec2(n_u, dot(face.y_ls_from_rel.xyz, receiver.normal_ws)) * face.step_ls.xy;
    float per_texel_m = MAP_ORTHOGRAPHIC == 1 ? 1.0 : at.z_ls * at.z_ls;
    float sum = 0.0;
    float whole = 0.0;
    End before = look_up(at, d, n_u, per_texel_m, n_step, 0);
#if SAMPLES == 1
    sum = min(1.0, 2.0 * before.seen.x);
    whole = 1.0;
#else
    for (int i = 1; i < SAMPLES; ++i) {
        End after = look_up(at, d, n_u, per_texel_m, n_step, i);
        sum += places[i - 1].y * segment(before, after);
        whole += places[i - 1].y;
        before = after;
    }
#endif
    bool lit = !receiver.seen || at.face < 0 || sum >= whole;
#if SUM
    sums = weight * vec2(lit ? 1.0 : sum / whole, 1.0);
#else
    // All lit is exactly 1, also where a driver divides by way of a rounded reciprocal.
    visibility = lit ? 1.0 : clamp(sum / whole, 0.0, 1.0);
#endif
}
