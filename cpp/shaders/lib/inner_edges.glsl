// The nearest silhouette edge around a texel inside a hard shadow (passes/inner_edges.h), and how much of what lies
// beyond it is open. Needs lib/map_lookup.glsl, lib/bias.glsl, lib/hard_lookup.glsl, lib/map_space.glsl and
// lib/edge_space.glsl; INNER_BINDING is the texture unit.

layout(binding = INNER_BINDING) uniform sampler2DArray inner_edges;

struct InnerEdge {
    bool found;
    vec2 normal;     // unit, outwards, unit lengths
    float distance;  // of the receiver from the edge, unit lengths; positive inside the shadow
    float w;         // of the edge's nearest point
};

// Of the texel that the hard comparison read; the distance is the receiver's own, not the texel's.
InnerEdge read_inner_edge(HardLookup look) {
    vec4 stored = texelFetch(inner_edges, ivec3(look.texel, look.layer), 0);
    vec2 step_ip = MAP_FACE(look.layer).step_ls.xy;
    vec2 moved = to_unit((look.at.texel - vec2(look.texel) - 0.5) * step_ip);
    InnerEdge edge;
    edge.found = stored.z >= 0.0;
    edge.normal = stored.xy;
    edge.distance = stored.z - dot(stored.xy, moved);
    edge.w = stored.w;
    return edge;
}

// How far beyond the edge, along its outer normal, nothing in front of the receiver blocks: 0 where something does
// right behind the edge (casters that touch, a caster under a caster), `reach` where none of the taps is blocked.
// The taps lie 1 1/2 texels beyond the edge and at quarters of the way to `reach` (unit lengths); what blocks is what
// lies in front of the receiver's plane.
float open_beyond(InnerEdge edge, HardLookup look, float reach) {
    MapFaceBlock face = MAP_FACE(look.layer);
    vec2 normal_texels = from_unit(edge.normal) * face.texel_from_ls.xy;
    float texel = 1.0 / max(length(normal_texels), 1e-30);
    float z_ls = look.at.z_ls - depth_bias(look.at, 0.5);
    float w = w_from_depth(z_ls);
#if MAP_ORTHOGRAPHIC
    vec2 w_per_texel = -look.at.slope;
#else
    vec2 w_per_texel = -look.at.slope * w * w;
#endif
    float open = 0.0;
    bool blocked = false;
    for (int k = 0; k < 5; ++k) {
        float beyond = k == 0 ? 1.5 * texel : max(1.5 * texel, 0.25 * float(k) * reach);
        vec2 offset = normal_texels * (edge.distance + beyond);
        ivec2 at = ivec2(floor(look.at.texel + offset));
        bool inside = all(greaterThanEqual(at, ivec2(0))) && all(lessThan(at, ivec2(map.counts.y)));
        float stored = texelFetch(depth_map, ivec3(clamp(at, ivec2(0), ivec2(map.counts.y - 1)), look.layer), 0).r;
        float w_plane = w + dot(w_per_texel, vec2(at) + 0.5 - look.at.texel);
        blocked = blocked || (inside && stored > 0.0 && w_from_stored(look.layer, stored) > w_plane);
        open = blocked ? open : beyond;
    }
    return blocked ? min(open, reach) : reach;
}
