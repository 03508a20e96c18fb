// Meshes as the silhouette shaders read them. Read-only data come through buffer textures: Mesa's software rasteriser
// gathers texels for all lanes at once, but walks storage blocks lane by lane.
#include "shared/silhouette.h"
#include "shared/silhouette_instance.h"

layout(binding = 0) uniform samplerBuffer planes;           // per triangle, FacingFrame::plane()
layout(binding = 1) uniform usamplerBuffer edges;           // Adjacency::Edge
layout(binding = 2) uniform usamplerBuffer triangle_edges;  // Adjacency::triangle_edges
layout(binding = 3) uniform usamplerBuffer more_sides;      // Adjacency::more_sides
layout(binding = 4) uniform samplerBuffer positions;        // recentred local
layout(binding = 5) uniform usamplerBuffer indices;         // per triangle
layout(binding = 6) uniform usamplerBuffer instances;       // SilhouetteInstance
layout(binding = 7) uniform usamplerBuffer jobs;            // SilhouetteJob

// What the first shader leaves to the second: edges (triangles) that are silhouettes or that it is not sure of.
layout(std430, binding = 6) buffer Candidates {
    uint candidate_count;
    uint groups_x, groups_y, groups_z;  // the second's work groups
    uvec2 candidates[];                 // slot, index in `edges` (`planes`)
};

const uint kNone = 0xffffffffu;
const uint kMany = 0x80000000u;

uvec4 instance_uints(uint slot, uint texel) {
    return texelFetch(instances, int(PENUMBRA_INSTANCE_TEXELS * slot + texel));
}
vec4 instance_floats(uint slot, uint texel) {
    return uintBitsToFloat(instance_uints(slot, texel));
}

// Its sign is the facing where it is beyond kSureFacing.
float plane_side(uint plane, vec4 light) {
    vec4 p = texelFetch(planes, int(plane));
    return dot(p.xyz, light.xyz) - p.w * light.w;
}
