// Index lists of shadow volumes: caps of the triangles that bound them, and as many sides at each edge as its signed
// multiplicity says. The rules are those of geometry/shadow_volume.h; facing is one function of float32 planes, so that
// caps and edges are told the same of every triangle and volumes are closed.
#include "shared/volume_slot.h"

layout(local_size_x = GROUP_SIZE) in;

layout(binding = 0) uniform samplerBuffer planes;       // per triangle, FacingFrame::plane()
layout(binding = 1) uniform usamplerBuffer edges;       // Adjacency::Edge
layout(binding = 3) uniform usamplerBuffer more_sides;  // Adjacency::more_sides
layout(binding = 5) uniform usamplerBuffer indices;     // per triangle

layout(std430, binding = 0) readonly buffer Slots { VolumeSlot slots[]; };
layout(std430, binding = 1) readonly buffer Jobs { VolumeJob jobs[]; };
layout(std430, binding = 2) buffer Commands { VolumeCommand commands[]; };
layout(std430, binding = 3) writeonly buffer Found { uint found[]; };

uniform uint job_count;

const uint kNone = 0xffffffffu;
const uint kMany = 0x80000000u;

VolumeSlot slot;

/// How far the light is before the triangle's front; 0: it sees it edge-on, so that it bounds no volume.
float height(uint triangle) {
    vec4 p = texelFetch(planes, int(slot.first_plane + triangle));
    precise float s = p.x * slot.light.x + p.y * slot.light.y + p.z * slot.light.z - p.w * slot.light.w;
    return s;
}

bool in_volume(float height) {
    return height != 0.0 && (slot.faces == 2u || (height > 0.0) == (slot.faces == 0u));
}

uint in_place(uint vertex) {
    return 2u * (slot.first_vertex + vertex);
}

void append(uint command, uvec3 triangle) {
    uint at = commands[command].first_index + atomicAdd(commands[command].count, 3u);
    found[at] = triangle.x;
    found[at + 1u] = triangle.y;
    found[at + 2u] = triangle.z;
}

void cap(uint triangle) {
    float seen = height(triangle);
    if (!in_volume(seen)) {
        return;
    }
    bool front = seen > 0.0;
    uvec3 v = texelFetch(indices, int(slot.first_triangle + triangle)).xyz;
    uvec3 near = uvec3(in_place(v.x), in_place(v.y), in_place(v.z));
    if (slot.near_caps != 0u) {
        append(front ? slot.wound_command : slot.flipped_command, near);
    }
    if (slot.far_caps != 0u) {
        append(slot.wound_command, (front ? near.xzy : near) + 1u);
    }
}

int vote(uint side) {
    float seen = height(side >> 1u);
    return !in_volume(seen) ? 0 : ((side & 1u) != 0u) == (seen > 0.0) ? -1 : 1;
}

void sides(uint index) {
    uvec4 edge = texelFetch(edges, int(slot.first_edge + index));
    int m = 0;
    if (edge.w != kNone && (edge.w & kMany) != 0u) {
        for (uint i = 0u; i < (edge.w & ~kMany); ++i) {
            m += vote(texelFetch(more_sides, int(slot.first_more + edge.z + i)).x);
        }
    } else {
        m = vote(edge.z) + (edge.w != kNone ? vote(edge.w) : 0);
    }
    uint a = in_place(m > 0 ? edge.x : edge.y);
    uint b = in_place(m > 0 ? edge.y : edge.x);
    for (int i = 0; i < abs(m); ++i) {
        append(slot.wound_command, uvec3(b, a, a + 1u));
        if (slot.far_edges != 0u) {
            append(slot.wound_command, uvec3(b, a + 1u, b + 1u));
        }
    }
}

void main() {
    uint group = gl_WorkGroupID.y * gl_NumWorkGroups.x + gl_WorkGroupID.x;
    if (group >= job_count) {
        return;
    }
    VolumeJob job = jobs[group];
    slot = slots[job.slot];
    for (uint i = gl_LocalInvocationIndex; i < job.count; i += GROUP_SIZE) {
        if (job.edges != 0u) {
            sides(job.first + i);
        } else {
            cap(job.first + i);
        }
    }
}
