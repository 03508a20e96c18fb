#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>

#include "gl/handles.h"

namespace penumbra {

/// Threads of a work group that makes or sifts the triangles of volumes.
inline constexpr std::uint32_t kVolumeGroupSize = 64;

/// One work group per job, in rows that every device allows.
inline void dispatch_groups(std::size_t jobs) {
    constexpr std::uint32_t kMostGroups = 32768;
    const auto groups = static_cast<std::uint32_t>(jobs);
    glDispatchCompute(std::min(groups, kMostGroups), (groups + kMostGroups - 1) / kMostGroups, 1);
}

}  // namespace penumbra
