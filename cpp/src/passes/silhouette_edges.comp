// Finds the silhouettes that one light point sees and writes a record of each (shared/silhouette.h). The rules are
// those of geometry/silhouettes.h, decided in float32: the light comes in each mesh's own space.
#include "lib/instance.glsl"
#include "shared/silhouette.h"
#include "shared/silhouette_instance.h"

layout(local_size_x = GROUP_SIZE) in;

layout(std430, binding = 0) readonly buffer Instances { SilhouetteInstance instances[]; };
layout(std430, binding = 1) readonly buffer Positions { float positions[]; };
layout(std430, binding = 2) readonly buffer Indices { uint indices[]; };
layout(std430, binding = 3) readonly buffer Planes { vec4 planes[]; };
layout(std430, binding = 4) readonly buffer Edges { uvec4 edges[]; };
layout(std430, binding = 5) readonly buffer TriangleEdges { uint triangle_edges[]; };
layout(std430, binding = 6) readonly buffer Jobs { uvec2 jobs[]; };  // per work group: instance, first element
layout(std430, binding = 7) buffer Records {
    uint found;
    uint padding[63];
    SilhouetteRecord records[];
};
uniform uint job_count;
uniform uint capacity;
uniform float sure_facing;
uniform float edge_on;
uniform int most_fan_steps;

const uint kNone = 0xffffffffu;
const uint kMany = 0x80000000u;

vec3 position_of(uint slot, uint vertex) {
    uint at = 3u * (instances[slot].first_vertex + vertex);
    return vec3(positions[at], positions[at + 1u], positions[at + 2u]);
}

// From the corners, for what the plane could not decide.
int exact_facing(uint slot, uint triangle) {
    uint at = instances[slot].first_index + 3u * triangle;
    float scale = instances[slot].light_low.w;
    vec3 a = position_of(slot, indices[at]);
    vec3 u = (position_of(slot, indices[at + 1u]) - a) * scale;
    vec3 v = (position_of(slot, indices[at + 2u]) - a) * scale;
    vec4 high = instances[slot].light_high;
    vec3 to_light = high.w == 0.0 ? high.xyz : (high.xyz - a * scale) + instances[slot].light_low.xyz;
    float s = dot(cross(u, v), to_light);
    float band = edge_on * length(u) * length(v) * length(to_light);
    return s > band ? 1 : s < -band ? -1 : 0;
}

int facing_of(uint slot, uint triangle) {
    vec4 plane = planes[instances[slot].first_plane + triangle];
    vec4 light = instances[slot].light;
    float s = dot(plane.xyz, light.xyz) - plane.w * light.w;
    if (abs(s) > sure_facing) {
        return s > 0.0 ? 1 : -1;
    }
    return exact_facing(slot, triangle);
}

int vote_of(uint side, int facing) {
    return (side & 1u) != 0u ? -facing : facing;
}

uint edge_of_triangle(uint slot, uint triangle, uint k) {
    return triangle_edges[instances[slot].first_corner + 3u * triangle + k];
}

uint many_side(uint slot, uvec4 edge, uint i) {
    return triangle_edges[instances[slot].first_more + edge.z + i];
}

bool has_many(uvec4 edge) {
    return edge.w != kNone && (edge.w & kMany) != 0u;
}

// Far end of the next silhouette edge around `a`, from edge `from` over `triangle`; a if there is none.
uint arriving(uint slot, uint from, uint a, uint triangle, int facing) {
    for (int step = 0; step < most_fan_steps; ++step) {
        uint next = kNone;
        uvec4 edge = uvec4(0u);
        for (uint k = 0u; k < 3u; ++k) {
            uint candidate = edge_of_triangle(slot, triangle, k);
            if (candidate != from) {
                uvec4 loaded = edges[instances[slot].first_edge + candidate];
                if (loaded.x == a || loaded.y == a) {
                    next = candidate;
                    edge = loaded;
                }
            }
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
            facing_across = facing_of(slot, side >> 1u);
            if (vote_of(side, facing_across) != -vote_of(first_is_own ? edge.z : edge.w, facing)) {
                return end;
            }
            across = side >> 1u;
        } else {
            uint count = edge.w & ~kMany;
            int own = 0;
            for (uint i = 0u; i < count; ++i) {
                uint side = many_side(slot, edge, i);
                own = side >> 1u == triangle ? vote_of(side, facing) : own;
            }
            bool silhouette = true;
            for (uint i = 0u; i < count; ++i) {
                uint side = many_side(slot, edge, i);
                int other = facing_of(slot, side >> 1u);
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

void write_record(uint slot, uint at, uint a, uint b, uint z) {
    if (at >= capacity) {
        return;
    }
    InstanceBlock place = InstanceBlock(instances[slot].rows);
    bool paired = z != a;
    vec3 a_rel = rel_from_local(place, position_of(slot, a));
    records[at].a_rel = vec4(a_rel, paired ? 1.0 : 0.0);
    records[at].b_rel = vec4(rel_from_local(place, position_of(slot, b)), 0.0);
    records[at].z_rel = vec4(paired ? rel_from_local(place, position_of(slot, z)) : a_rel, 0.0);
    records[at].ids = uvec4(instances[slot].id & ~kMany, a, b, z);
}

void both_ways(uint slot, uvec4 edge) {
    uint at = atomicAdd(found, 2u);
    write_record(slot, at, edge.x, edge.y, edge.x);
    write_record(slot, at + 1u, edge.y, edge.x, edge.y);
}

#if defined(CHOOSE_ALL)

void main_element(uint slot, uint index) {
    both_ways(slot, edges[instances[slot].first_edge + index]);
}

#elif defined(CHOOSE_LIGHT_FACING)

void main_element(uint slot, uint triangle) {
    if (facing_of(slot, triangle) <= 0) {
        return;
    }
    uvec4 edge[3];
    for (uint k = 0u; k < 3u; ++k) {
        edge[k] = edges[instances[slot].first_edge + edge_of_triangle(slot, triangle, k)];
    }
    bool mirrored = (instances[slot].id & kMany) != 0u;
    uint at = atomicAdd(found, 3u);
    for (uint k = 0u; k < 3u; ++k) {
        uvec4 own = edge[k];
        uvec4 next = edge[(k + 1u) % 3u];
        uint b = own.x == next.x || own.x == next.y ? own.x : own.y;
        uint a = own.x == b ? own.y : own.x;
        uint z = next.x == b ? next.y : next.x;
        write_record(slot, at + k, mirrored ? b : a, mirrored ? a : b, z);
    }
}

#else

void main_element(uint slot, uint index) {
    uvec4 edge = edges[instances[slot].first_edge + index];
    bool left = false;
    bool right = false;
    uint start = kNone;
    int start_facing = 0;
    bool many = has_many(edge);
    uint count = edge.w == kNone ? 1u : many ? edge.w & ~kMany : 2u;
    for (uint i = 0u; i < count; ++i) {
        uint side = many ? many_side(slot, edge, i) : i == 0u ? edge.z : edge.w;
        int facing = facing_of(slot, side >> 1u);
        int vote = vote_of(side, facing);
        left = left || vote > 0;
        right = right || vote < 0;
        if (facing != 0 && (start == kNone || (start_facing < 0 && facing > 0))) {
            start = side >> 1u;
            start_facing = facing;
        }
    }
    if (left && right) {
        return;
    }
    if (!left && !right) {
        both_ways(slot, edge);
        return;
    }
    bool forwards = left != ((instances[slot].id & kMany) != 0u);
    uint a = forwards ? edge.x : edge.y;
    uint b = forwards ? edge.y : edge.x;
    write_record(slot, atomicAdd(found, 1u), a, b, arriving(slot, index, a, start, start_facing));
}

#endif

void main() {
    uint group = gl_WorkGroupID.y * gl_NumWorkGroups.x + gl_WorkGroupID.x;
    if (group >= job_count) {
        return;
    }
    uvec2 job = jobs[group];
    uint element = job.y + gl_LocalInvocationIndex;
    if (element < instances[job.x].element_count) {
        main_element(job.x, element);
    }
}
