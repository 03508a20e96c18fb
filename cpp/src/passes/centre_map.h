#pragma once

#include "passes/depth_map.h"
#include "passes/map_bias.h"
#include "penumbra/plan.h"

namespace penumbra {

class Frame;

/// Depth maps from the light's centre: what every single-map technique shares. One fitted frustum, or the cube faces
/// that hold receivers, or one orthographic map for a sun.
class CentreMap {
public:
    CentreMap(int size_px, const MapBias& bias, bool facing_test, double margin_texels)
        : bias_{bias}, facing_test_{facing_test}, options_{.size_px = size_px, .margin_texels = margin_texels} {}

    /// Adds one step per face (and per peeled face), run or left out.
    /// @return false if the light needs no map at all; the reason is in the plan, under all steps and `lookup`
    bool plan(const LightSummary& summary, std::string_view lookup, Plan& plan) const;

    void allocate(Frame& frame);
    void update(Frame& frame);
    /// The lookup program for the frustum at hand; `fragment` includes lib/map_lookup.glsl and lib/bias.glsl.
    [[nodiscard]] const Program& lookup(Frame& frame, std::string_view fragment, const Defines& more = {}) const;
    /// Map at texture unit 2, peeled map at 3, block at uniform 1, bias uniforms.
    void bind(const Program& program);

    [[nodiscard]] TextureImage& texture() noexcept { return map_.texture(); }
    [[nodiscard]] std::size_t bytes() const noexcept { return map_.bytes() + second_map_.bytes(); }

private:
    [[nodiscard]] bool midpoint() const noexcept { return bias_.mode == MapBias::Mode::Midpoint; }

    MapBias bias_;
    bool facing_test_;
    MapFrustumOptions options_;
    MapFrustum frustum_;
    gpu::MapBlock block_{};
    DepthMap map_, second_map_;
    MapSetup setup_;
};

}  // namespace penumbra
