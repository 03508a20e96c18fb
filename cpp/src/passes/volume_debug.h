#pragma once

#include <string_view>
#include <vector>

#include "penumbra/technique.h"

namespace penumbra {

class Frame;
class VolumePass;

/// Pictures and numbers of shadow volumes, for every technique that has a VolumePass. Slow and for people.

/// Wireframe, overdraw, counts.
[[nodiscard]] std::vector<DebugView> volume_views();
[[nodiscard]] DebugImage volume_picture(Frame& frame, VolumePass& volumes, std::string_view id);

/// What the thesis reports of full volumes: fragments, overdraw, coverage; triangles, and the layers they may reach.
[[nodiscard]] std::vector<Statistic> volume_statistics(Frame& frame, VolumePass& volumes);

}  // namespace penumbra
