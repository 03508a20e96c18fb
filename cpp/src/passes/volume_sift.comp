// Which triangles of shadow volumes may have a fragment that matters in a wanted tile: one lane per triangle, all tiles
// in turn until one says yes. What no tile needs is not drawn, and nobody on the processor need know.
//
// In homogeneous coordinates, so that nothing is clipped: M holds the corners' x, y and w, and M^-1 (x, y, 1) are the
// shares of the corners at the point (x, y) of the picture, up to positive factors; a fragment is there if none is
// negative. Shares and depth are affine in x and y. All bounds are widened by what float32 may lose.
#include "lib/instance.glsl"
#include "lib/wanted_tiles.glsl"
#include "shared/volume_slot.h"

layout(local_size_x = GROUP_SIZE) in;

layout(std430, binding = 1) readonly buffer Instances { InstanceBlock instances[]; };
layout(std430, binding = 2) readonly buffer Vertices { vec4 positions_local[]; };  // w: 1 in place, 0 cast
layout(std430, binding = 3) readonly buffer Jobs { VolumeSiftJob jobs[]; };
layout(std430, binding = 4) readonly buffer Found { uint found[]; };
layout(std430, binding = 5) readonly buffer Commands { VolumeCommand commands[]; };
layout(std430, binding = 6) writeonly buffer Kept { uint kept[]; };
layout(std430, binding = 7) buffer KeptCommands { VolumeCommand kept_commands[]; };

uniform uint job_count;
uniform mat4 clip_from_rel;
uniform vec4 light_cr;
uniform float far_share;
uniform vec2 size_px;

const float kMargin_px = 0.5;     // rasterisers snap vertices
const float kDepthSlack = 1e-4;   // as TileWalker has it
const float kShareSlack = 4e-6;   // of products of corners that are scaled to 1
const float kHuge = 3e38;

// As volume.vert places it, scaled so that no coordinate of x, y, w exceeds 1.
vec4 corner_at(InstanceBlock instance, uint vertex) {
    vec4 position = positions_local[vertex];
    vec3 p_rel = rel_from_local(instance, position.xyz);
    vec3 along = light_cr.w * p_rel - light_cr.xyz;
    vec3 start = light_cr.w > 0.5 ? light_cr.xyz : p_rel;
    vec4 clip = clip_from_rel *
                (position.w > 0.5 ? vec4(p_rel, 1.0) : vec4(along + far_share * start, far_share));
    return clip / max(max(abs(clip.x), abs(clip.y)), max(abs(clip.w), 1e-30));
}

bool matters(vec4 a, vec4 b, vec4 c, bool z_pass) {
    // Rows of M^-1 times its determinant.
    vec3 ea = cross(b.xyw, c.xyw), eb = cross(c.xyw, a.xyw), ec = cross(a.xyw, b.xyw);
    float determinant = dot(a.xyw, ea);
    float turn = determinant < 0.0 ? -1.0 : 1.0;
    ea *= turn;
    eb *= turn;
    ec *= turn;
    determinant = abs(determinant);
    bool flat_one = determinant < 1e-12;  // seen edge-on: its sides tell nothing of depth
    vec3 depth = (a.z * ea + b.z * eb + c.z * ec) / max(determinant, 1e-30);
    float depth_slack = kShareSlack * (abs(a.z) + abs(b.z) + abs(c.z)) / max(determinant, 1e-30);
    // Where all of it is before the eye, its corners bound it.
    vec2 low = vec2(-kHuge), high = vec2(kHuge);
    float nearest = kHuge, farthest = -kHuge;
    if (min(a.w, min(b.w, c.w)) > 1e-6) {
        vec3 pa = a.xyz / a.w, pb = b.xyz / b.w, pc = c.xyz / c.w;
        low = min(pa.xy, min(pb.xy, pc.xy));
        high = max(pa.xy, max(pb.xy, pc.xy));
        nearest = max(pa.z, max(pb.z, pc.z));
        farthest = min(pa.z, min(pb.z, pc.z));
    }
    vec2 half_size = (0.5 * float(TILE_PX) + kMargin_px) * 2.0 / size_px;
    for (uint i = 0u; i < tile_count; ++i) {
        WantedTile tile = wanted_tiles[i];
        vec2 centre = (vec2(tile.column, tile.row) + 0.5) * (2.0 * float(TILE_PX)) / size_px - 1.0;
        if (any(greaterThan(low, centre + half_size)) || any(lessThan(high, centre - half_size))) {
            continue;
        }
        vec3 at = vec3(centre, 1.0);
        vec3 most = vec3(dot(ea, at) + dot(abs(ea.xy), half_size), dot(eb, at) + dot(abs(eb.xy), half_size),
                         dot(ec, at) + dot(abs(ec.xy), half_size));
        if (any(lessThan(most, vec3(-kShareSlack)))) {
            continue;
        }
        float z = dot(depth, at);
        float reach = dot(abs(depth.xy), half_size) + depth_slack;
        float near_z = flat_one ? nearest : min(nearest, z + reach);
        float far_z = flat_one ? farthest : max(farthest, z - reach);
        // Comparisons that are false of what is not a number keep the triangle.
        bool beyond = z_pass ? near_z * (1.0 + kDepthSlack) + 1e-6 < tile.farthest
                             : min(far_z, 1.0) * (1.0 - kDepthSlack) - 1e-6 > tile.nearest;
        if (!beyond) {
            return true;
        }
    }
    return false;
}

void main() {
    uint group = gl_WorkGroupID.y * gl_NumWorkGroups.x + gl_WorkGroupID.x;
    if (group >= job_count) {
        return;
    }
    VolumeSiftJob job = jobs[group];
    VolumeCommand command = commands[job.command];
    InstanceBlock instance = instances[command.base_instance];
    uint end = min(job.first + job.count, command.count / 3u);
    for (uint t = job.first + gl_LocalInvocationIndex; t < end; t += GROUP_SIZE) {
        uint at = command.first_index + 3u * t;
        uvec3 v = uvec3(found[at], found[at + 1u], found[at + 2u]);
        if (matters(corner_at(instance, v.x), corner_at(instance, v.y), corner_at(instance, v.z), job.z_pass != 0u)) {
            uint to = command.first_index + atomicAdd(kept_commands[job.command].count, 3u);
            kept[to] = v.x;
            kept[to + 1u] = v.y;
            kept[to + 2u] = v.z;
        }
    }
}
