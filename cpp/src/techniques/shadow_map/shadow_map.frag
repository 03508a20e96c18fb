// Hard shadow map [Williams1978]: one comparison with the nearest texel.
#include "lib/map_lookup.glsl"
#include "lib/bias.glsl"
#include "lib/receiver.glsl"

layout(binding = 0) uniform usampler2D receivers;
layout(binding = 2) uniform sampler2DArray depth_map;
#if BIAS_MODE == 6
layout(binding = 3) uniform sampler2DArray second_map;
#endif

#include "lib/hard_lookup.glsl"

layout(location = 0) out float visibility;

void main() {
    Receiver receiver = read_receiver(receivers, ivec2(gl_FragCoord.xy));
    bool dark = look_up_hard(receiver.position_cr, receiver.normal_ws).dark;
    visibility = receiver.seen && dark ? 0.0 : 1.0;
}
