// Depth discontinuities of one map, texel pair by texel pair along the rows [linear-light-soft-shadow-maps 2.4]; every
// pair that is one goes to the list of the neighbour in which its skin opens. In the other it folds shut: hidden.
layout(binding = 2) uniform sampler2DArray depth_map;

// Two indirect draws with what they draw: x | y << 16 of the left texel of each pair. First those with the caster on the
// left, whose skins open in the next sample's view, then those for the sample before.
layout(std430, binding = 6) buffer Next { uint next_vertices, next_rest[3]; uint next_spans[]; };
layout(std430, binding = 7) buffer Previous { uint previous_vertices, previous_rest[3]; uint previous_spans[]; };

uniform int layer;
uniform int capacity;
uniform vec2 least_jump;  // stored depth: skins as long as the least, in the view after and before; huge where none is
uniform vec2 least_log;   // LoG difference
uniform float dead_zone;  // share of it that the smaller LoG value must reach

const int kLogWidth = 2 * LOG_RADIUS + 1;
uniform float log_kernel[kLogWidth * kLogWidth];

float kernel_at(int x, int y) {
    return abs(x) <= LOG_RADIUS ? log_kernel[(y + LOG_RADIUS) * kLogWidth + x + LOG_RADIUS] : 0.0;
}

float stored(ivec2 texel) {
    ivec2 last = textureSize(depth_map, 0).xy - 1;
    return texelFetch(depth_map, ivec3(clamp(texel, ivec2(0), last), layer), 0).r;
}

void main() {
    ivec2 a = ivec2(gl_FragCoord.xy);
    float at_a = stored(a);
    float at_b = stored(a + ivec2(1, 0));
    bool to_next = at_a > at_b;
    float jump = abs(at_a - at_b);
    // Nearly all pairs end here; on a software rasteriser whole blocks do.
    if (jump <= (to_next ? least_jump.x : least_jump.y)) {
        discard;
    }
    float log_a = 0.0;
    float log_b = 0.0;
    for (int y = -LOG_RADIUS; y <= LOG_RADIUS; ++y) {
        for (int x = -LOG_RADIUS; x <= LOG_RADIUS + 1; ++x) {
            float value = stored(a + ivec2(x, y)) - at_a;  // the kernel's sum is 0, so this takes off rounding alone
            log_a += kernel_at(x, y) * value;
            log_b += kernel_at(x - 1, y) * value;
        }
    }
    float least = to_next ? least_log.x : least_log.y;
    if (log_a * log_b >= 0.0 || abs(log_a - log_b) <= least || min(abs(log_a), abs(log_b)) <= dead_zone * least) {
        discard;
    }
    uint span = uint(a.x) | uint(a.y) << 16;
    if (to_next) {
        uint index = atomicAdd(next_vertices, 6u) / 6u;
        if (index < uint(capacity)) {
            next_spans[index] = span;
        }
    } else {
        uint index = atomicAdd(previous_vertices, 6u) / 6u;
        if (index < uint(capacity)) {
            previous_spans[index] = span;
        }
    }
}
