#include "passes/map_bias.h"

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
    std::vector<SettingInfo> settings;
    settings.push_back({.id = "map_size",
                        .label = "Map size",
                        .unit = "px",
                        .help = "Width and height of each depth map.",
                        .default_value = 1024,
                        .minimum = 16,
                        .maximum = 16384,
                        .choices = {},
                        .sweep = {256, 512, 1024, 2048, 4096}});
    settings.push_back({.id = "bias",
                        .label = "Bias",
                        .unit = "",
                        .help = "How a surface is kept from shadowing itself.",
                        .default_value = std::string{default_bias},
                        .minimum = 0,
                        .maximum = 0,
                        .choices = modes,
                        .sweep = {}});
    settings.push_back({.id = "bias_scale",
                        .label = "Bias scale",
                        .unit = "",
                        .help = "Factor on the bias; 1 is what a plane needs, less gives acne, more detaches shadows.",
                        .default_value = 1.0,
                        .minimum = 0.0,
                        .maximum = 100.0,
                        .choices = {},
                        .sweep = {}});
    settings.push_back({.id = "bias_constant",
                        .label = "Constant bias",
                        .unit = "texel",
                        .help = "Added to every bias but none, in widths of a map texel at the receiver.",
                        .default_value = 0.1,
                        .minimum = 0.0,
                        .maximum = 1000.0,
                        .choices = {},
                        .sweep = {}});
    settings.push_back(
        {.id = "slope_cap",
         .label = "Slope cap",
         .unit = "texel",
         .help = "Largest slope-dependent bias, in widths of a map texel; bounds leaks at grazing light.",
         .default_value = 64.0,
         .minimum = 0.0,
         .maximum = 100000.0,
         .choices = {},
         .sweep = {}});
    settings.push_back({.id = "facing_test",
                        .label = "Facing test",
                        .unit = "",
                        .help = "Surfaces turned away from the light point are dark without a lookup.",
                        .default_value = true,
                        .minimum = 0,
                        .maximum = 0,
                        .choices = {},
                        .sweep = {}});
    return settings;
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
