// One group per tile of the view: any pixel of the wanted class, and how near and far such pixels are. Depth is positive
// and less than 2 in any view, so its bits compare as it does.
#include "lib/receiver.glsl"
#include "lib/wanted_tiles.glsl"

layout(local_size_x = TILE_PX, local_size_y = TILE_PX) in;

layout(binding = 0) uniform usampler2D receivers;
layout(binding = 1) uniform usampler2D classes;
uniform uint wanted_class;
uniform mat4 clip_from_rel;

shared uint nearest_bits;
shared uint farthest_bits;

void main() {
    if (gl_LocalInvocationIndex == 0u) {
        nearest_bits = 0u;
        farthest_bits = 0xffffffffu;
    }
    barrier();
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
    bool wanted = all(lessThan(pixel, textureSize(classes, 0))) && texelFetch(classes, pixel, 0).r == wanted_class;
    if (wanted) {
        vec4 p = clip_from_rel * vec4(read_receiver(receivers, pixel).position_cr, 1.0);
        uint depth_bits = floatBitsToUint(clamp(p.z / p.w, 0.0, 1.0));
        atomicMax(nearest_bits, depth_bits);
        atomicMin(farthest_bits, depth_bits);
    }
    barrier();
    if (gl_LocalInvocationIndex == 0u && farthest_bits != 0xffffffffu) {
        uint at = atomicAdd(tile_count, 1u);
        wanted_tiles[at] = WantedTile(gl_WorkGroupID.x, gl_WorkGroupID.y, uintBitsToFloat(nearest_bits),
                                      uintBitsToFloat(farthest_bits));
    }
}
