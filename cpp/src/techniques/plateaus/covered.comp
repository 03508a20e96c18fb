// Where slopes change nothing, as a pyramid of cells that are so throughout: sift.vert asks it about whole footprints.
// Level 0: cells of 4 x 4 texels; level 2: 16 x 16; level 4: 64 x 64. LEVEL: the one that is made, from the one below.
//
// red: all texels lie under the umbra, or are looked up by nobody; green: all are looked up by nobody. Where both sides
// of edges are drawn, a lit texel that nobody looks up still decides whether an edge is free: red is then umbra alone.
// blue: any lies under the umbra. Texels beyond the plane's own size are unseen and under the umbra.
//
// SKIPPED: slopes have one side, so red alone is asked for; it is read, four texels at a time, from the depth that
// keeps slopes from being computed.
#include "shared/plateau_block.h"

layout(local_size_x = 8, local_size_y = 8) in;
layout(std140, binding = 2) uniform Plateaus { PlateauBlock plateaus; };
uniform int plane_index;
uniform ivec2 cells;

#if LEVEL == 0 && SKIPPED
layout(binding = 4) uniform sampler2D skipped;  // depth 0 under the umbra and where nobody looks
#elif LEVEL == 0
layout(binding = 4) uniform sampler2DArray slopes;  // the umbra, as yet
#if WANTED
layout(binding = 6) uniform sampler2DArray wanted;
#endif
#else
layout(binding = 4) uniform sampler2D finer;
#endif
layout(binding = 0, rgba8) uniform writeonly image2D covered;

void main() {
    ivec2 cell = ivec2(gl_GlobalInvocationID.xy);
    if (any(greaterThanEqual(cell, cells))) {
        return;
    }
#if LEVEL == 0 && SKIPPED
    vec2 size_px = vec2(textureSize(skipped, 0));
    vec4 deepest = vec4(0.0);
    for (int y = 1; y < 4; y += 2) {
        for (int x = 1; x < 4; x += 2) {
            ivec2 middle = 4 * cell + ivec2(x, y);  // of four texels, in the order of textureGather
            bvec2 left_low = lessThan(middle - 1, plateaus.planes[plane_index].size.xy);
            bvec2 right_high = lessThan(middle, plateaus.planes[plane_index].size.xy);
            vec4 within = vec4(left_low.x && right_high.y, right_high.x && right_high.y, right_high.x && left_low.y,
                               left_low.x && left_low.y);
            deepest = max(deepest, within * textureGather(skipped, vec2(middle) / size_px));
        }
    }
    bool hidden = max(max(deepest.x, deepest.y), max(deepest.z, deepest.w)) == 0.0;
    imageStore(covered, cell, vec4(hidden ? 1.0 : 0.0, 0.0, 0.0, 0.0));
#else
    vec2 all_of = vec2(1.0);
    float any_umbra = 0.0;
    for (int y = 0; y < 4; ++y) {
        for (int x = 0; x < 4; ++x) {
            ivec2 texel = 4 * cell + ivec2(x, y);
#if LEVEL == 0
            bool within = all(lessThan(texel, plateaus.planes[plane_index].size.xy));
            ivec3 at = ivec3(min(texel, plateaus.planes[plane_index].size.xy - 1), plane_index);
            bool unseen = !within;
#if WANTED
            unseen = unseen || texelFetch(wanted, at, 0).r < 0.5;
#endif
            bool umbra = !within || texelFetch(slopes, at, 0).r < 0.95;
            any_umbra = within && umbra ? 1.0 : any_umbra;
            all_of = min(all_of, vec2(umbra || (SIDES == 1 && unseen) ? 1.0 : 0.0, unseen ? 1.0 : 0.0));
#else
            vec3 found = texelFetch(finer, texel, LEVEL - 2).rgb;
            all_of = min(all_of, found.rg);
            any_umbra = max(any_umbra, found.b);
#endif
        }
    }
    imageStore(covered, cell, vec4(all_of, any_umbra, 0.0));
#endif
}
