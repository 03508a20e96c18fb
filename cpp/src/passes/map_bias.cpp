#include "passes/map_bias.h"
#include "scene/setting_forms.h"

#include <algorithm>
#include <array>

namespace penumbra {

namespace {

constexpr std::array kModes{"none", "constant", "slope", "receiver_plane", "normal_offset", "second_depth", "midpoint"};

}  // namespace

std::vector<SettingInfo> map_settings(const char* default_bias, bool with_midpoint) {
    std::vector<std::string> modes(kModes.begin(), kModes.end());
    if (!with_midpoint) {
        modes.pop_back();
    }
    SettingInfo bias = choice_setting("bias", "Bias", "How a surface is kept from shadowing itself.", modes);
    bias.default_value = std::string{default_bias};
    return {
        number_setting("map_size", "Map size", "px", "Width and height of each depth map.", 1024, 16, 16384,
                       {256, 512, 1024, 2048, 4096}),
        bias,
        number_setting("bias_scale", "Bias scale", "",
                       "Factor on the bias; 1 is what a plane needs, less gives acne, more detaches shadows.", 1.0, 0.0,
                       100.0),
        number_setting("bias_constant", "Constant bias", "texel",
                       "Added to every bias but none, in widths of a map texel at the receiver.", 0.1, 0.0, 1000.0),
        number_setting("slope_cap", "Slope cap", "texel",
                       "Largest slope-dependent bias, in widths of a map texel; bounds leaks at grazing light.", 64.0,
                       0.0, 100000.0),
        toggle_setting("facing_test", "Facing test",
                       "Surfaces turned away from the light point are dark without a lookup.", true),
    };
}

MapBias map_bias_from(const Settings& settings) {
    MapBias bias;
    const std::string& mode = get_choice(settings, "bias");
    for (std::size_t i = 0; i < kModes.size(); ++i) {
        if (kModes[i] == mode) {
            bias.mode = static_cast<MapBias::Mode>(i);
        }
    }
    bias.scale = static_cast<float>(get_double(settings, "bias_scale"));
    bias.constant = static_cast<float>(get_double(settings, "bias_constant"));
    bias.slope_cap = static_cast<float>(get_double(settings, "slope_cap"));
    return bias;
}

Defines MapBias::defines(const MapFrustum& frustum, bool facing_test) const {
    const bool orthographic = !frustum.faces.empty() && frustum.faces.front().orthographic;
    Defines all{{"BIAS_MODE", std::to_string(static_cast<int>(mode))},
                {"MAP_FACES", std::to_string(std::max<std::size_t>(1, frustum.faces.size()))},
                {"MAP_ORTHOGRAPHIC", orthographic ? "1" : "0"},
                {"FACING_TEST", facing_test ? "1" : "0"}};
    if (metres > 0.0F) {
        all.push_back({"BIAS_METRES"});
    }
    return all;
}

void MapBias::set_uniforms(const Program& program) const {
    program.set("bias_scale", scale);
    program.set("bias_constant", constant);
    program.set("slope_cap", slope_cap);
    if (metres > 0.0F) {
        program.set("bias_metres", metres);
    }
}

}  // namespace penumbra
