// A skin as a quad one row high. Vertices come six to a span.
#include "techniques/linear_light_maps/skin.glsl"

layout(binding = 2) uniform sampler2DArray depth_map;
layout(std430, binding = 6) readonly buffer Spans { uint vertices, rest[3]; uint spans[]; };

uniform int capacity;
uniform int from_layer;
uniform bool caster_left;
uniform vec2 shift;  // texel in the neighbour's view minus texel here: x * stored depth + y

flat out Skin skin;

void main() {
    int index = gl_VertexID / 6;
    int corner = gl_VertexID - 6 * index;
    if (index >= capacity) {
        gl_Position = vec4(0.0, 0.0, 0.0, 1.0);
        return;
    }
    uint span = spans[index];
    ivec2 left = ivec2(span & 0xffffu, span >> 16);
    ivec2 last = textureSize(depth_map, 0).xy;
    ivec2 right = ivec2(left.x + 1, left.y);
    ivec2 caster = caster_left ? left : right;
    ivec2 receiver = caster_left ? right : left;
    skin.caster_depth = texelFetch(depth_map, ivec3(caster, from_layer), 0).r;
    skin.receiver_depth = texelFetch(depth_map, ivec3(receiver, from_layer), 0).r;
    skin.caster_texel = float(caster.x) + 0.5 + shift.x * skin.caster_depth + shift.y;
    skin.receiver_texel = float(receiver.x) + 0.5 + shift.x * skin.receiver_depth + shift.y;
    // The receiver's end goes on for half a texel, so that no texel centre falls between it and the lit side.
    bool at_caster = corner == 0 || corner == 1 || corner == 3;
    bool at_bottom = corner == 0 || corner == 2 || corner == 5;
    float outwards = skin.receiver_texel >= skin.caster_texel ? 0.5 : -0.5;
    float x = at_caster ? skin.caster_texel : skin.receiver_texel + outwards;
    float y = float(left.y) + (at_bottom ? 0.0 : 1.0);
    float t = at_caster ? 0.0 : 1.0 + 0.5 / max(abs(skin.receiver_texel - skin.caster_texel), 1e-6);
    float depth = mix(skin.caster_depth, skin.receiver_depth, t);
    gl_Position = vec4(2.0 * vec2(x, y) / vec2(last) - 1.0, depth, 1.0);
}
