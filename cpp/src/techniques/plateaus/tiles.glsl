// What one edge's slope coordinate is at least and at most over a tile of the plane's texture, so that sheets of wide
// penumbrae are drawn only where they can be the darkest.
//
// Seen from p, a vertex has homogeneous coordinates in the light's plane that are affine in p. So over a tile the edge
// stays within the hull of what its ends are at the tile's corners: where a line parts that hull from the light's shape
// grown by t, lambda is above t all over the tile. And for one fixed point of the edge lambda is quasi-convex in p, so
// that it is largest at a corner. A ball's axes turn with p: there they are held as the tile's middle has them, and t
// allows for the angle.
#include "techniques/plateaus/bounds.glsl"

struct Tile {
    vec2 p[5];       // its middle, then its corners, plane coordinates
    vec3 u, v, m;    // FRAME 2: the light's axes from its middle
    float widen;     // lambda <= t  =>  lambda in these axes <= widen * t, t <= 1
    float narrow;    // lambda <= lambda in these axes / narrow
};

Tile tile_at(ivec2 index, float tile_px) {
    Tile tile;
    vec2 low = PLANE.window.xy + PLANE.window.z * tile_px * vec2(index);
    float side = PLANE.window.z * tile_px;
    tile.p[0] = low + 0.5 * side;
    tile.p[1] = low;
    tile.p[2] = low + vec2(side, 0.0);
    tile.p[3] = low + vec2(side, side);
    tile.p[4] = low + vec2(0.0, side);
    tile.widen = 1.0;
    tile.narrow = 1.0;
#if FRAME == 2
    vec3 q = to_light(tile.p[0]);
    light_axes(q, tile.u, tile.v);
    float distance = length(q);
    tile.m = q / distance;
    float away = 0.7072 * side;
    float nearest = max(distance - away, 1e-6 * distance);
    float farthest = distance + away;
    float ball = PLANE.dual_v.w;
    float radius = length(tile.u);
    float largest = ball * inversesqrt(1.0 - min(ball * ball / (nearest * nearest), 0.99));
    float least = ball * inversesqrt(1.0 - min(ball * ball / (farthest * farthest), 0.99));
    float alpha = asin(min(ball / nearest, 0.995));
    float turn = asin(min(away / distance, 1.0));
    float leaning = cos(min(alpha + turn, 1.57));
    tile.widen = cos(alpha) / max(leaning, 1e-3) * largest / radius;
    tile.narrow = cos(alpha) * least / radius;
#endif
    return tile;
}

// back_project() in axes that are the same all over the tile.
vec3 seen_from(Tile tile, vec2 p, vec2 s, float sigma) {
    vec3 q = to_light(p);
#if FRAME == 2
    float mq = dot(tile.m, q);
    float ms = dot(tile.m.xy, s - p);
    vec3 x = mq * vec3(s - p, 0.0) - ms * q;
    float r2 = dot(tile.u, tile.u);
    return vec3(dot(tile.u, x) / r2, dot(tile.v, x) / r2, ms + sigma * mq);
#else
    return back_project(s - p, sigma, q);
#endif
}

// False where coordinates are not affine after all: the tile reaches through the light's own plane.
bool one_side(Tile tile) {
#if FRAME == 1
    bool positive = true;
    bool negative = true;
    for (int i = 1; i < 5; ++i) {
        float mq = dot(PLANE.normal.xyz, to_light(tile.p[i]));
        positive = positive && mq > 0.0;
        negative = negative && mq < 0.0;
    }
    return positive || negative;
#else
    return true;
#endif
}

// True if lambda of the edge is above t, 0 < t <= 1, all over the tile.
bool above(Tile tile, vec4 ends, vec4 scales, float t) {
    vec3 a = seen_from(tile, tile.p[0], ends.xy, scales.x);
    vec3 b = seen_from(tile, tile.p[0], ends.zw, scales.y);
    Nearest middle = nearest_on_edge(a, b);
    if (!one_side(tile)) {
        return false;
    }
#if GAUGE == 1
    const int tries = 3;  // the edge's own line, and the box's sides
#else
    const int tries = 1;
#endif
    vec2 at = mix(a, b, middle.t).xy;
    bool found = false;
    for (int k = 0; k < tries; ++k) {
        vec2 n = k == 0 ? middle.normal : (k == 1 ? vec2(at.x, 0.0) : vec2(0.0, at.y));
        float length_n = length(n);
        n /= max(length_n, 1e-30);
        float grown = t * tile.widen * dot(support(n), n);
        bool parted = length_n > 0.0;
        for (int i = 1; i < 5; ++i) {
            vec3 from = seen_from(tile, tile.p[i], ends.xy, scales.x);
            vec3 to = seen_from(tile, tile.p[i], ends.zw, scales.y);
            parted = parted && dot(n, from.xy) - grown * from.z > 1e-4 * (length(from.xy) + abs(grown * from.z)) &&
                     dot(n, to.xy) - grown * to.z > 1e-4 * (length(to.xy) + abs(grown * to.z));
        }
        found = found || parted;
    }
    return found;
}

// No less than lambda of the edge anywhere on the tile; 1 if nothing better is known.
float at_most(Tile tile, vec4 ends, vec4 scales) {
    float t = nearest_on_edge(seen_from(tile, tile.p[0], ends.xy, scales.x),
                              seen_from(tile, tile.p[0], ends.zw, scales.y))
                  .t;
    float largest = 0.0;
    for (int i = 1; i < 5; ++i) {
        vec3 x = mix(seen_from(tile, tile.p[i], ends.xy, scales.x), seen_from(tile, tile.p[i], ends.zw, scales.y), t);
        largest = max(largest, x.z > 0.0 ? gauge(x.xy / x.z) : kFar);
    }
    return one_side(tile) ? min(largest / tile.narrow * 1.001 + 1e-5, 1.0) : 1.0;
}
