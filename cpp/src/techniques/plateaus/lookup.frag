// V at every pixel: on a plane from its texture; elsewhere the hard comparison of the depth map, softened by the
// texture of the plane that the light's ray meets next.
//
// REST: pixels on no plane exist, so the depth map is there. HARD: a light without extent, the depth map alone.
#if REST
#include "lib/map_lookup.glsl"
#include "lib/bias.glsl"
#endif
#include "lib/receiver.glsl"
#include "techniques/plateaus/plateau.glsl"

layout(binding = 0) uniform usampler2D receivers;
layout(binding = 4) uniform usampler2D plane_of_pixel;
layout(binding = 5) uniform sampler2DArray slopes;
#if REST
layout(binding = 2) uniform sampler2DArray depth_map;
#if HEIGHTS
layout(binding = 6) uniform sampler2DArray darkest;
#endif
#if BIAS_MODE == 6
layout(binding = 3) uniform sampler2DArray second_map;
#endif
#include "lib/hard_lookup.glsl"
#endif

uniform float dark;        // V in the umbra
uniform vec2 hither_yon;

layout(location = 0) out float visibility;

const float kPi = 3.14159265358979;

float falloff(float x) {
#if SIDES == 2
    return x;  // the texture holds V
#elif FALLOFF == 1
    return 0.5 - 0.5 * cos(kPi * x);
#elif FALLOFF == 2
    return x * x * (3.0 - 2.0 * x);
#elif FALLOFF == 3
    return x > 0.0 ? 0.5 + (x * sqrt(1.0 - x * x) + asin(x)) / kPi : 0.0;
#elif FALLOFF == 4
    float y = 2.0 * x - 1.0;
    return 0.5 + (y * sqrt(max(0.0, 1.0 - y * y)) + asin(y)) / kPi;
#else
    return x;
#endif
}

float stored(ivec2 texel, int plane) {
    float x = texelFetch(slopes, ivec3(clamp(texel, ivec2(0), plateaus.planes[plane].size.xy - 1), plane), 0).r;
#if STORE_DEPTH
    x = (x - hither_yon.x) / (hither_yon.y - hither_yon.x);
#endif
    return abs(x);
}

// Between four texels, by hand: the sign inside the umbra (SIDES 2) and the plane's own size rule the sampler out.
float on_plane(vec2 p, int plane) {
    vec4 window = plateaus.planes[plane].window;
    vec2 at = (p - window.xy) * window.w - 0.5;
    ivec2 low = ivec2(floor(at));
    vec2 part = at - vec2(low);
    float x = mix(mix(stored(low, plane), stored(low + ivec2(1, 0), plane), part.x),
                  mix(stored(low + ivec2(0, 1), plane), stored(low + ivec2(1, 1), plane), part.x), part.y);
    return falloff(clamp(x, 0.0, 1.0));
}

#if REST && HEIGHTS
float decoded(ivec2 texel, int plane, float height, float ratio_light) {
    float bits = texelFetch(darkest, ivec3(clamp(texel, ivec2(0), plateaus.planes[plane].size.xy - 1), plane), 0).r;
    float lambda = floor(bits / 4096.0);
    float caster = (1.0 - (bits - 4096.0 * lambda) / 4095.0) * plateaus.planes[plane].heights.y;
    // The penumbra of a caster at height h is narrower at height z by (1 - z/h) / (1 - z/H): nothing above the caster.
#if NARROW
    float ratio = (1.0 - height / max(caster, 1e-30)) / ratio_light;
#else
    float ratio = height < caster ? 1.0 : 0.0;
#endif
    return ratio > 1e-4 ? min(lambda / 4095.0 / ratio, 1.0) : 1.0;
}

// The light's ray beyond the receiver: the first plane that it meets within a texture.
float off_planes(vec3 p_rel) {
    float nearest = 1e30;
    float v = 1.0;
    for (int i = 0; i < plateaus.counts.x; ++i) {
        vec4 x_from_rel = plateaus.planes[i].x_from_rel;
        vec4 y_from_rel = plateaus.planes[i].y_from_rel;
        vec4 h_from_rel = plateaus.planes[i].h_from_rel;
        vec4 light = plateaus.planes[i].light;
        vec4 window = plateaus.planes[i].window;
        vec3 p = vec3(dot(x_from_rel.xyz, p_rel) + x_from_rel.w, dot(y_from_rel.xyz, p_rel) + y_from_rel.w,
                      dot(h_from_rel.xyz, p_rel) + h_from_rel.w);
        float left = 1.0 - light.w * p.z / light.z;
        vec2 s = p.xy + (light.w * p.xy - light.xy) * (p.z / light.z) / max(left, 1e-6);
        vec2 at = (s - window.xy) * window.w;
        bool meets = left > 1e-3 && p.z > -plateaus.planes[i].heights.x && all(greaterThanEqual(at, vec2(0.0))) &&
                     all(lessThanEqual(at, vec2(plateaus.planes[i].size.xy)));
        float distance = length(vec3(s - p.xy, p.z));
        if (meets && distance < nearest) {
            nearest = distance;
            at -= 0.5;
            ivec2 low = ivec2(floor(at));
            vec2 part = at - vec2(low);
            float x = mix(mix(decoded(low, i, p.z, left), decoded(low + ivec2(1, 0), i, p.z, left), part.x),
                          mix(decoded(low + ivec2(0, 1), i, p.z, left), decoded(low + ivec2(1, 1), i, p.z, left), part.x),
                          part.y);
            v = falloff(x);
        }
    }
    return v;
}
#endif

void main() {
    ivec2 pixel = ivec2(gl_FragCoord.xy);
    Receiver receiver = read_receiver(receivers, pixel);
#if HARD
    bool shadowed = look_up_hard(receiver.position_cr, receiver.normal_ws).dark;
    visibility = receiver.seen && shadowed ? dark : 1.0;
#else
    vec3 p_rel = receiver.position_cr - plateaus.origin_cr.xyz;
    uint plane = texelFetch(plane_of_pixel, pixel, 0).r;
    float v = 1.0;
    if (plane < uint(plateaus.counts.x)) {
        int i = int(plane);
        vec4 x_from_rel = plateaus.planes[i].x_from_rel;
        vec4 y_from_rel = plateaus.planes[i].y_from_rel;
        v = on_plane(vec2(dot(x_from_rel.xyz, p_rel) + x_from_rel.w, dot(y_from_rel.xyz, p_rel) + y_from_rel.w), i);
    }
#if REST
    else {
#if HEIGHTS
        v = off_planes(p_rel);
#endif
        v = look_up_hard(receiver.position_cr, receiver.normal_ws).dark ? 0.0 : v;
    }
#endif
    visibility = receiver.seen ? mix(dark, 1.0, v) : 1.0;
#endif
}
