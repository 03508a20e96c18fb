#pragma once

#include <vector>

#include "gl/program.h"
#include "passes/gpu_scene.h"
#include "passes/map_frustum.h"
#include "penumbra/settings.h"

namespace penumbra {

/// How a depth comparison keeps a surface from shadowing itself. Formulas: baselines.md section 1, lib/bias.glsl.
struct MapBias {
    enum class Mode { None, Constant, Slope, ReceiverPlane, NormalOffset, SecondDepth, Midpoint };
    Mode mode = Mode::Slope;
    float scale = 1.0F;       ///< of the mode's closed form
    float constant = 0.1F;    ///< texel widths at the receiver
    float slope_cap = 64.0F;  ///< texel widths
    float metres = 0.0F;      ///< added to every bias but none: how far casters may stand in front of what is seen

    /// Which faces the depth pass leaves out: the lit ones for second depth.
    [[nodiscard]] Cull cull() const noexcept { return mode == Mode::SecondDepth ? Cull::Back : Cull::None; }
    void set_uniforms(const Program& program) const;
    /// BIAS_MODE, MAP_FACES, MAP_ORTHOGRAPHIC and FACING_TEST of the lookup shaders.
    [[nodiscard]] Defines defines(const MapFrustum& frustum, bool facing_test) const;
};

/// The settings that every map technique shares: map_size, bias, bias_scale, bias_constant, slope_cap, facing_test.
/// @param default_bias one of the choices
[[nodiscard]] std::vector<SettingInfo> map_settings(const char* default_bias, bool with_midpoint);
[[nodiscard]] MapBias map_bias_from(const Settings& settings);

}  // namespace penumbra
