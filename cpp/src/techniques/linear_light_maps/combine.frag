// V of one linear light from its maps [linear-light-soft-shadow-maps 2.7, 2.8]: per segment between neighbouring samples
// the sum of what either end says, weighted by the segment's share of the light.
#include "lib/map_lookup.glsl"
#include "lib/bias.glsl"
#include "lib/receiver.glsl"
#if !ONE_WINDOW
#include "techniques/linear_light_maps/linear_windows.glsl"
#endif

layout(binding = 0) uniform usampler2D receivers;
layout(binding = 2) uniform sampler2DArray depth_map;
layout(binding = 3) uniform sampler2DArray channel_map;
#if SURFACE_MAP
layout(binding = 4) uniform sampler2DArray surface_map;  // what the channels are of, where some of it casts no shadow
#endif

uniform int first_layer;
#if !ONE_WINDOW
uniform int first_window;
#endif
uniform vec4 views[SAMPLES * MAP_FACES];  // per window and sample: texel minus the central view's: x * d + y
uniform vec4 places[SAMPLES];             // x along the rod, y share of the segment to the next sample
uniform float rim;                        // perspective: share of the depth; orthographic: metres
uniform float weight;                     // of this light among those that stand for the whole

#if LOCAL
// Local illumination, for the share of the light that arrives: 1 as a line (Lambert per length), 2 to one side, 3 alike
// all around, 4 from afar.
uniform vec3 shine_ws;  // unit, 1 along the line, 2 direction in which it shines
#endif

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

// What moves a point between the views: 1 / z, of a sun the depth in front of the far plane.
float inverse_distance(MapPoint at) {
#if MAP_ORTHOGRAPHIC
    return MAP_FACE(at.face).range_m.y - at.z_ls;
#else
    return 1.0 / max(at.z_ls, 1e-30);
#endif
}

#if LOCAL
vec3 map_u() {
    return MAP_FACE(0).x_ls_from_rel.xyz;
}

float local_illumination(vec3 p_rel, float towards_m) {
    float distance = length(p_rel);
    float cosine = max(0.0, towards_m) / distance;
#if LOCAL == 4
    return max(0.0, towards_m);
#elif LOCAL == 3
    return cosine / (distance * distance);
#elif LOCAL == 2
    return cosine * max(0.0, dot(p_rel, shine_ws)) / (distance * distance * distance);
#else
    return cosine * length(cross(p_rel, shine_ws)) / (distance * distance * distance);
#endif
}
#endif

End look_up(MapPoint at, vec3 p_rel, float d, float n_u, float per_texel_m, vec2 n_step, int i) {
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
#if LOCAL
    end.local = local_illumination(p_rel - places[i].x * map_u(), end.towards_m);
#endif
    return end;
}

// x what arrives from the segment between two samples, y what would arrive without casters.
vec2 segment(End before, End after) {
    float a = before.seen.y;
    float b = after.seen.x;
    float facing = 1.0;
#if CLAMP
    float excess = a + b > 1.0 ? 1.0 / (a + b) : 1.0;
    a *= excess;
    b *= excess;
#endif
#if FACING_TEST
    // The surface's own plane hides the rest of a segment that crosses it.
    if ((before.towards_m > 0.0) != (after.towards_m > 0.0)) {
        facing = max(before.towards_m, after.towards_m) / max(abs(before.towards_m - after.towards_m), 1e-30);
        float only = max(before.seen.y, after.seen.x);
        only = min(only == 0.5 ? 1.0 : only, facing);
        a = before.towards_m > 0.0 ? only : 0.0;
        b = before.towards_m > 0.0 ? 0.0 : only;
    }
#endif
#if LOCAL
    // What lies behind the surface's plane lights it neither with nor without casters.
    float share = facing < 1.0 ? 0.5 / facing : 1.0;
    return vec2(share * (a * before.local + b * after.local), 0.5 * (before.local + after.local));
#else
    return vec2(a + b, 1.0);
#endif
}

void main() {
    Receiver receiver = read_receiver(receivers, ivec2(gl_FragCoord.xy));
    vec3 p_rel = receiver.position_cr - map.origin_cr.xyz;
#if ONE_WINDOW
    const int window = 0;
    const bool outside = false;
#else
    int found = find_window(p_rel) - first_window;
    bool outside = found < 0 || found >= MAP_FACES;
    int window = clamp(found, 0, MAP_FACES - 1);
#endif
    MapPoint at = find_in_face(window, p_rel, receiver.normal_ws);
    at.face = window;
    float d = inverse_distance(at);
    MapFaceBlock face = MAP_FACE(window);
    float n_u = dot(face.x_ls_from_rel.xyz, receiver.normal_ws);
    vec2 n_step = vec2(n_u, dot(face.y_ls_from_rel.xyz, receiver.normal_ws)) * face.step_ls.xy;
    float per_texel_m = MAP_ORTHOGRAPHIC == 1 ? 1.0 : at.z_ls * at.z_ls;
    vec2 total = vec2(0.0);  // seen, whole
    End before = look_up(at, p_rel, d, n_u, per_texel_m, n_step, 0);
#if SAMPLES == 1
    total = vec2(2.0 * before.seen.x, 1.0);
#else
    for (int i = 1; i < SAMPLES; ++i) {
        End after = look_up(at, p_rel, d, n_u, per_texel_m, n_step, i);
        total += places[i - 1].y * segment(before, after);
        before = after;
    }
#endif
    bool lit = !receiver.seen || total.x >= total.y;
#if SUM && LOCAL
    sums = !receiver.seen ? vec2(weight) : outside ? vec2(0.0) : weight * vec2(min(total.x, total.y), total.y);
#elif SUM
    sums = outside && receiver.seen ? vec2(0.0) : weight * vec2(lit ? 1.0 : total.x / total.y, 1.0);
#else
    // All lit is exactly 1, also where a driver divides by way of a rounded reciprocal.
    visibility = lit || outside ? 1.0 : clamp(total.x / total.y, 0.0, 1.0);
#endif
}
