// Lines behind a surface are faint.
#include "lib/receiver.glsl"

layout(binding = 0) uniform usampler2D receivers;
uniform vec3 colour;
in vec3 position_cr;
layout(location = 0) out vec4 result;

void main() {
    Receiver receiver = read_receiver(receivers, ivec2(gl_FragCoord.xy));
    bool hidden = receiver.seen && length(receiver.position_cr) < 0.995 * length(position_cr);
    result = vec4(colour, hidden ? 0.3 : 1.0);
}
