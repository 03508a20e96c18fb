// The view in grey, lit from the eye: a background for overlays.
#include "lib/receiver.glsl"

layout(binding = 0) uniform usampler2D receivers;
layout(location = 0) out vec4 colour;

void main() {
    Receiver receiver = read_receiver(receivers, ivec2(gl_FragCoord.xy));
    float facing = abs(dot(normalize(receiver.normal_ws), normalize(receiver.position_cr)));
    colour = vec4(vec3(receiver.seen ? 0.15 + 0.45 * facing : 0.05), 1.0);
}
