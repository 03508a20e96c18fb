#pragma once

#include <vector>

#include "geometry/linear_placement.h"
#include "passes/depth_map.h"
#include "techniques/linear_light_maps/linear_views.h"

namespace penumbra {

class Frame;

/// Depth maps of all samples and windows of a rod. @param surfaces  of what skins come from; else of what casts shadows
void render_linear_depths(Frame& frame, DepthMap& maps, MapSetup& setup, const LinearViews& views,
                          const glm::dvec3& axis_ws, int first_layer, int size_px, bool surfaces);

/// Adaptive insertion of samples: where a rod's samples must lie is decided from small maps of each pair of neighbours
/// and a candidate between them, read back and judged in float64.
class SamplePlacement {
public:
    struct Result {
        std::vector<double> places;  ///< along the rod, -1 .. 1
        int candidates = 0;
        double undersampled =
            0.0;  ///< share of the surfaces in sight of a candidate that neither neighbour saw, at the end
    };
    [[nodiscard]] Result find(Frame& frame, const LinearRod& rod, const glm::dvec3& aim_ws, std::vector<double> start,
                              int most, int size_px, const SkinRules& rules);
    [[nodiscard]] std::size_t bytes() const noexcept { return maps_.bytes(); }

private:
    DepthMap maps_;
    MapSetup setup_;
};

}  // namespace penumbra
