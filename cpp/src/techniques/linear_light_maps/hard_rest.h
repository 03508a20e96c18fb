#pragma once

#include <optional>
#include <vector>

#include "passes/depth_map.h"
#include "passes/map_bias.h"
#include "techniques/linear_light_maps/linear_views.h"

namespace penumbra {

class Frame;

/// Receivers that lie in none of a rod's windows, since they are too close to the line through it: beyond its ends the
/// rod is seen end on and its samples one behind the other, so no rows can be shared. They get the hard shadows of the
/// samples, with the weights that two-channel maps have without skins.
class HardRest {
public:
    struct Rod {
        LightSummary summary;  ///< of these receivers alone
        std::vector<MapFrustum> frusta;
        std::vector<gpu::MapBlock> blocks;
        std::vector<int> first_layers;
        std::vector<double> weights;
        const LinearViews* views = nullptr;
    };
    /// @param views  outlive this; those without receivers outside are passed over
    /// @param weight  of the rod among those that stand for the light
    void add(const LightSummary& summary, const LinearViews& views, double weight, const glm::dvec3& axis_ws,
             int size_px);
    void clear() {
        rods_.clear();
        layers_ = 0;
    }
    [[nodiscard]] bool empty() const noexcept { return rods_.empty(); }

    void render(Frame& frame, int size_px);
    /// Adds to the sums that are bound for blending.
    void accumulate(Frame& frame, RenderTarget& sums, const MapBias& bias, bool facing_test);
    [[nodiscard]] std::size_t bytes() const noexcept { return maps_.bytes(); }

private:
    std::vector<Rod> rods_;
    int layers_ = 0;
    DepthMap maps_;
    MapSetup setup_;
};

/// The uniforms of linear_windows.glsl.
void set_windows(const Program& program, const LinearViews& views);

}  // namespace penumbra
