#pragma once

#include <cstdint>
#include <span>

#include "base/parallel.h"
#include "penumbra/control.h"
#include "penumbra/view.h"
#include "reference/light_points.h"
#include "reference/ray_scene.h"
#include "reference/receivers.h"
#include "reference/tile_tracer.h"

namespace penumbra {

/// Calls work(tracer, receivers) for every tile that has listed pixels.
template <class Work>
void for_tiles(const RayScene& rays, const View& view, const LightPoints& points, std::span<const std::uint8_t> listed,
               std::uint32_t seed, std::uint32_t stream, Control& control, const Work& work) {
    constexpr int kTilesPerPiece = 4;
    const Tiles tiles{rays, view};
    parallel_for(
        tiles.count(), kTilesPerPiece,
        [&](std::int64_t begin, std::int64_t end) {
            TileTracer tracer{rays, points, seed, stream};
            TileReceivers receivers;
            for (std::int64_t tile = begin; tile < end; ++tile) {
                control.check();
                tiles.collect(listed, tile, receivers);
                if (receivers.count() > 0) {
                    work(tracer, receivers);
                }
            }
        },
        control);
}

}  // namespace penumbra
