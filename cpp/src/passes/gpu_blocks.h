#pragma once

#include "gl/glsl_types.h"

namespace penumbra::gpu {

#include "shared/instance_block.h"
#include "shared/map_block.h"

static_assert(sizeof(InstanceBlock) == 48);
static_assert(sizeof(MapFaceBlock) == 112);
static_assert(sizeof(MapBlock) == 48 + PENUMBRA_MAX_FACES * 112);

}  // namespace penumbra::gpu
