// Nearest and farthest stored depth of a window of a depth map, from at most 9 texels of a pyramid (passes/depth_pyramid).
// The window may come out larger than asked, never smaller.

// @param low, high  first and last texel of the window, inside the map; pyramid level 0 is half as wide as the map
vec2 depth_range(sampler2DArray pyramid, int layer, ivec2 low, ivec2 high) {
    int span = max(high.x - low.x, high.y - low.y);
    int level = min(span > 4 ? findMSB(span - 1) - 1 : 0, textureQueryLevels(pyramid) - 1);
    ivec2 end = textureSize(pyramid, level).xy - 1;
    ivec2 first = min(low >> (level + 1), end), last = min(high >> (level + 1), end);
    vec2 range = vec2(0.0, 1e30);
    for (int y = 0; y < 3; ++y) {
        for (int x = 0; x < 3; ++x) {
            vec2 found = texelFetch(pyramid, ivec3(min(first + ivec2(x, y), last), layer), level).rg;
            range = vec2(max(range.x, found.x), min(range.y, found.y));
        }
    }
    return range;
}
