// First step to silhouettes: drops the edges that surely are none, by far the most. Two triangles that surely lie on
// different sides of their edge is all there is to know; everything else goes to silhouette_records.comp. Nothing else
// is decided here, so that lanes do not wait for each other.
#include "lib/silhouette_search.glsl"

layout(local_size_x = GROUP_SIZE) in;

uniform uint job_count;
uniform float sure_facing;

void keep(uint slot, uint index) {
    uint at = atomicAdd(candidate_count, 1u);
    candidates[at] = uvec2(slot, index);
    if (at % GROUP_SIZE == 0u && at < GROUP_SIZE * MAX_GROUPS) {
        atomicAdd(groups_x, 1u);
    }
}

void main() {
    uint group = gl_WorkGroupID.y * gl_NumWorkGroups.x + gl_WorkGroupID.x;
    if (group >= job_count) {
        return;
    }
    uvec4 job = texelFetch(jobs, int(group));
    vec4 light = instance_floats(job.x, 3u);
    for (uint i = gl_LocalInvocationIndex; i < job.z; i += GROUP_SIZE) {
        uint index = job.y + i;
#if defined(CHOOSE_ALL)
        bool kept = true;
#elif defined(CHOOSE_LIGHT_FACING)
        bool kept = plane_side(index, light) > -sure_facing;
#else
        uvec4 edge = texelFetch(edges, int(index));
        bool two = (edge.w & kMany) == 0u;
        uint side1 = two ? edge.w : edge.z;
        float s0 = plane_side(job.w + (edge.z >> 1u), light);
        float s1 = plane_side(job.w + (side1 >> 1u), light);
        s0 = (edge.z & 1u) != 0u ? -s0 : s0;
        s1 = (side1 & 1u) != 0u ? -s1 : s1;
        bool kept = !(two && max(s0, s1) > sure_facing && min(s0, s1) < -sure_facing);
#endif
        if (kept) {
            keep(job.x, index);
        }
    }
}
