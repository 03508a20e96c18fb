// What of a segment a texel sees past the caster's edge: 0 at the edge, 1 where the skin meets what lies behind
// [linear-light-soft-shadow-maps 2.6, 2.10].
#include "techniques/linear_light_maps/skin.glsl"

layout(binding = 2) uniform sampler2DArray depth_map;

uniform int to_layer;
uniform float texels_per_depth;  // how many texels a unit of stored depth moves between the views; > 0
uniform vec2 slack;              // of stored depths that count as equal: x relative, y absolute

flat in Skin skin;
layout(location = 0) out vec2 channels;

void main() {
    float seen = texelFetch(depth_map, ivec3(ivec2(gl_FragCoord.xy), to_layer), 0).r;
    float length_px = skin.receiver_texel - skin.caster_texel;
    float t = (gl_FragCoord.x - skin.caster_texel) / (abs(length_px) > 1e-6 ? length_px : 1e-6);
    float depth = mix(skin.caster_depth, skin.receiver_depth, t);
    bool on_caster = seen >= skin.caster_depth * (1.0 - slack.x) - slack.y;
    bool hidden = depth < seen * (1.0 - slack.x) - slack.y;
    if (on_caster || hidden) {
        discard;
    }
#if EXACT
    // The place on the light that the edge just hides from the surface in this texel, whatever its shape.
    float v = abs(gl_FragCoord.x - skin.caster_texel) /
              max(texels_per_depth * (skin.caster_depth - seen), 1e-9);
#else
    float v = t;
#if WALL_RULE
    // A wall that falls on few texels is taken for a gap, and the skin lies on the wall itself: that stays lit. Over a
    // parallel receiver the skin's height is 1 - t of its own depth, so that nothing changes there.
    float height = (depth - seen) / max(skin.caster_depth - skin.receiver_depth, 1e-30);
    v = max(v, 1.0 - 10.0 * max(height, 0.0));
#endif
#endif
    channels = vec2(clamp(v, 0.0, 1.0));
}
