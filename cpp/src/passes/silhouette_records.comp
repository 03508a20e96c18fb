// Second step: decides what silhouette_sift.comp kept and writes a record (shared/silhouette.h) of each silhouette. The
// rules are those of geometry/silhouettes.h in float32; the light comes in each mesh's own space.
#include "lib/instance.glsl"
#include "lib/silhouette_search.glsl"

layout(local_size_x = GROUP_SIZE) in;

layout(std430, binding = 7) buffer Records {
    uint found;
    uint padding[63];
    SilhouetteRecord records[];
};
uniform uint capacity;
uniform float sure_facing;
uniform float edge_on;
uniform int most_fan_steps;

// Of the mesh and the instance that this invocation works on.
uint slot;
uint first_vertex, first_triangle, first_plane, first_edge, first_more, id;
bool mirrored;
vec4 light;

vec3 position_of(uint vertex) {
    return texelFetch(positions, int(first_vertex + vertex)).xyz;
}

// From the corners, for what the plane cannot decide.
int exact_facing(uint triangle) {
    uvec3 corners = texelFetch(indices, int(first_triangle + triangle)).xyz;
    vec4 low = instance_floats(slot, 5u);
    vec4 high = instance_floats(slot, 4u);
    vec3 a = position_of(corners.x);
    vec3 u = (position_of(corners.y) - a) * low.w;
    vec3 v = (position_of(corners.z) - a) * low.w;
    vec3 to_light = high.w == 0.0 ? high.xyz : (high.xyz - a * low.w) + low.xyz;
    float s = dot(cross(u, v), to_light);
    float band = edge_on * length(u) * length(v) * length(to_light);
    return s > band ? 1 : s < -band ? -1 : 0;
}

int facing_of(uint triangle) {
    float s = plane_side(first_plane + triangle, light);
    return abs(s) > sure_facing ? (s > 0.0 ? 1 : -1) : exact_facing(triangle);
}

int vote_of(uint side, int facing) {
    return (side & 1u) != 0u ? -facing : facing;
}

uint many_side(uvec4 edge, uint i) {
    return texelFetch(more_sides, int(first_more + edge.z + i)).x;
}

bool has_many(uvec4 edge) {
    return edge.w != kNone && (edge.w & kMany) != 0u;
}

// Far end of the next silhouette edge around `a`, from edge `from` over `triangle`; a if there is none.
uint arriving(uint from, uint a, uint triangle, int facing) {
    for (int step = 0; step < most_fan_steps; ++step) {
        uvec3 around = texelFetch(triangle_edges, int(first_plane + triangle)).xyz;
        // Of the two edges that are not `from`, the one at a.
        uint next = around.x == from ? around.y : around.x;
        uvec4 edge = texelFetch(edges, int(first_edge + next));
        if (edge.x != a && edge.y != a) {
            next = around.z == from ? around.y : around.z;
            edge = texelFetch(edges, int(first_edge + next));
        }
        uint end = edge.x == a ? edge.y : edge.x;
        if (edge.w == kNone) {
            return end;
        }
        uint across = kNone;
        int facing_across = 0;
        if (!has_many(edge)) {
            bool first_is_own = edge.z >> 1u == triangle;
            uint side = first_is_own ? edge.w : edge.z;
            facing_across = facing_of(side >> 1u);
            if (vote_of(side, facing_across) != -vote_of(first_is_own ? edge.z : edge.w, facing)) {
                return end;
            }
            across = side >> 1u;
        } else {
            uint count = edge.w & ~kMany;
            int own = 0;
            for (uint i = 0u; i < count; ++i) {
                uint side = many_side(edge, i);
                own = side >> 1u == triangle ? vote_of(side, facing) : own;
            }
            bool silhouette = true;
            for (uint i = 0u; i < count; ++i) {
                uint side = many_side(edge, i);
                int other = facing_of(side >> 1u);
                if (vote_of(side, other) == -own) {
                    silhouette = false;
                    if (across == kNone && other == facing) {
                        across = side >> 1u;
                        facing_across = other;
                    }
                }
            }
            if (silhouette) {
                return end;
            }
            if (across == kNone) {
                return a;
            }
        }
        from = next;
        triangle = across;
        facing = facing_across;
    }
    return a;
}

void write_record(uint at, uint a, uint b, uint z) {
    if (at >= capacity) {
        return;
    }
    InstanceBlock place =
        InstanceBlock(vec4[3](instance_floats(slot, 0u), instance_floats(slot, 1u), instance_floats(slot, 2u)));
    records[at].a_rel = vec4(rel_from_local(place, position_of(a)), z != a ? 1.0 : 0.0);
    records[at].b_rel = vec4(rel_from_local(place, position_of(b)), 0.0);
    records[at].z_rel = vec4(rel_from_local(place, position_of(z)), 0.0);
    records[at].ids = uvec4(id, a, b, z);
}

void both_ways(uvec4 edge) {
    uint at = atomicAdd(found, 2u);
    write_record(at, edge.x, edge.y, edge.x);
    write_record(at + 1u, edge.y, edge.x, edge.y);
}

#if defined(CHOOSE_ALL)

void decide(uint index) {
    both_ways(texelFetch(edges, int(index)));
}

#elif defined(CHOOSE_LIGHT_FACING)

void decide(uint index) {
    if (facing_of(index - first_plane) <= 0) {
        return;
    }
    uvec3 around = texelFetch(triangle_edges, int(index)).xyz;
    uvec4 edge[3];
    for (int k = 0; k < 3; ++k) {
        edge[k] = texelFetch(edges, int(first_edge + around[k]));
    }
    uint at = atomicAdd(found, 3u);
    for (uint k = 0u; k < 3u; ++k) {
        uvec4 own = edge[k];
        uvec4 next = edge[(k + 1u) % 3u];
        uint b = own.x == next.x || own.x == next.y ? own.x : own.y;
        uint a = own.x == b ? own.y : own.x;
        uint z = next.x == b ? next.y : next.x;
        write_record(at + k, mirrored ? b : a, mirrored ? a : b, z);
    }
}

#else

void decide(uint index) {
    uvec4 edge = texelFetch(edges, int(index));
    bool left = false;
    bool right = false;
    uint start = kNone;
    int start_facing = 0;
    bool many = has_many(edge);
    uint count = edge.w == kNone ? 1u : many ? edge.w & ~kMany : 2u;
    for (uint i = 0u; i < count; ++i) {
        uint side = many ? many_side(edge, i) : i == 0u ? edge.z : edge.w;
        int facing = facing_of(side >> 1u);
        int vote = vote_of(side, facing);
        left = left || vote > 0;
        right = right || vote < 0;
        // Light-facing fans come first: between them they meet every corner of a closed mesh once.
        if (facing != 0 && (start == kNone || (start_facing < 0 && facing > 0))) {
            start = side >> 1u;
            start_facing = facing;
        }
    }
    if (left && right) {
        return;
    }
    if (!left && !right) {
        both_ways(edge);
        return;
    }
    bool forwards = left != mirrored;
    uint a = forwards ? edge.x : edge.y;
    uint b = forwards ? edge.y : edge.x;
    uint z = arriving(index - first_edge, a, start, start_facing);
    write_record(atomicAdd(found, 1u), a, b, z);
}

#endif

void main() {
    uint stride = gl_NumWorkGroups.x * GROUP_SIZE;
    for (uint i = gl_GlobalInvocationID.x; i < candidate_count; i += stride) {
        uvec2 candidate = candidates[i];
        slot = candidate.x;
        uvec4 firsts = instance_uints(slot, 6u);
        uvec4 more = instance_uints(slot, 7u);
        first_vertex = firsts.x;
        first_triangle = firsts.y;
        first_plane = firsts.z;
        first_edge = firsts.w;
        first_more = more.x;
        id = more.y;
        mirrored = more.z != 0u;
        light = instance_floats(slot, 3u);
        decide(candidate.y);
    }
}
