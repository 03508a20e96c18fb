// Pictures and counts of the linear light maps' inside.
#include <algorithm>
#include <cmath>

#include "passes/debug_picture.h"
#include "passes/frame.h"
#include "techniques/linear_light_maps/linear_light_maps.h"

namespace penumbra {

std::vector<DebugView> LinearLightMaps::debug_views(const Plan& plan) const {
    if (!plan.runs("lookups")) {
        return {};
    }
    std::vector<DebugView> views{{"depth_maps", "Depth maps of the first line's samples"},
                                 {"log", "Laplacian of Gaussian of those"}};
    if (plan.runs("skins")) {
        views.push_back({"channels", "Visibility channels of the first line's samples"});
        views.push_back({"skins", "Skins over the depth maps"});
    }
    return views;
}

DebugImage LinearLightMaps::debug_image(Frame& frame, std::string_view id) {
    DebugImage image;
    if (rods_.empty() || rods_.front().views.windows.empty()) {
        return image;
    }
    const Rod& rod = rods_.front();
    const std::vector<float> stored = surfaces(frame).texture().read<float>();
    const std::vector<LinearMap> maps = linear_maps(rod.views, 0, stored, rod.first_layer, size_px_);
    const std::vector<glm::vec2> channels =
        frame.plan().runs("skins") ? skins_.channels().read<glm::vec2>() : std::vector<glm::vec2>{};
    const auto texels = static_cast<std::size_t>(size_px_) * static_cast<std::size_t>(size_px_);

    double low = 1e300;
    double high = 0.0;
    for (const LinearMap& map : maps) {
        for (const double d : map.d) {
            low = d > 0.0 ? std::min(low, d) : low;
            high = std::max(high, d);
        }
    }
    const int samples = std::min(rod.views.samples(), 4);
    const int rows = id == "channels" ? 2 : 1;
    image.width_px = samples * size_px_;
    image.height_px = rows * size_px_;
    image.rgb.resize(static_cast<std::size_t>(image.width_px) * static_cast<std::size_t>(image.height_px));
    for (int sample = 0; sample < samples; ++sample) {
        const LinearMap& map = maps[static_cast<std::size_t>(sample)];
        const std::vector<double> log = id == "log" ? filter_log(map, rules_.kernel) : std::vector<double>{};
        for (int row = 0; row < rows; ++row) {
            for (int y = 0; y < size_px_; ++y) {
                for (int x = 0; x < size_px_; ++x) {
                    const std::size_t i = map.index(x, y);
                    const glm::vec2 entry =
                        channels.empty() ? glm::vec2{0.5F}
                                         : channels[static_cast<std::size_t>(rod.first_layer + sample) * texels + i];
                    const double grey =
                        map.d[i] > 0.0 && high > low ? 0.15 + 0.75 * (map.d[i] - low) / (high - low) : 0.0;
                    glm::vec3 colour{static_cast<float>(grey)};
                    if (id == "log") {
                        const float value =
                            static_cast<float>(std::clamp(log[i] / (0.05 * std::max(high - low, 1e-30)), -1.0, 1.0));
                        colour = glm::vec3{std::max(value, 0.0F), std::max(-value, 0.0F), std::abs(value) * 0.3F};
                    } else if (id == "channels") {
                        const float value = row == 1 ? entry.x : entry.y;
                        colour = glm::vec3{value > 1.5F ? 0.5F : value};
                    } else if (id == "skins") {
                        for (const float value : {entry.x, entry.y}) {
                            if (value != 0.5F && value <= 1.0F) {
                                colour = glm::mix(glm::vec3{0.9F, 0.15F, 0.1F}, glm::vec3{0.2F, 0.85F, 0.3F}, value);
                            }
                        }
                    }
                    image.rgb[static_cast<std::size_t>(row * size_px_ + y) * static_cast<std::size_t>(image.width_px) +
                              static_cast<std::size_t>(sample * size_px_ + x)] = colour;
                }
            }
        }
    }
    image.caption =
        id == "depth_maps" ? "what the samples of the first line see, nearest brightest, side by side along the line"
        : id == "log"      ? "red and green: the two signs; an edge is a change of sign between neighbours in a row"
        : id == "channels" ? "what of a segment is seen by a point that the sample lights: top the segment before it, "
                             "bottom the one after; mid grey: no skin, one half"
                           : "skins: red at the caster's edge (0) to green where they meet what lies behind (1)";
    return image;
}

std::vector<Statistic> LinearLightMaps::statistics(Frame& frame) {
    if (!frame.plan().runs("lookups")) {
        return {};
    }
    std::size_t samples = 0;
    std::size_t maps = 0;
    for (const Rod& rod : rods_) {
        samples += rod.views.along.size();
        maps += static_cast<std::size_t>(rod.layers());
    }
    std::vector<Statistic> all{{"lines", "Lines", "lines", static_cast<double>(rods_.size())},
                               {"samples", "Samples", "samples", static_cast<double>(samples)},
                               {"maps", "Depth maps", "maps", static_cast<double>(maps)}};
    if (frame.plan().runs("skins") && maps > 0) {
        skins_.reset_counts();
        skins_.count_spans(true);
        draw_skins(frame);
        skins_.count_spans(false);
        all.push_back({"skins", "Skins drawn", "spans", static_cast<double>(skins_.counts().spans)});
        if (skins_.counts().dropped > 0) {
            all.push_back(
                {"skins_dropped", "Skins without room", "spans", static_cast<double>(skins_.counts().dropped)});
        }
        const std::vector<glm::vec2> channels = skins_.channels().read<glm::vec2>();
        const float none = rules_.darkest ? 2.0F : 0.5F;
        const auto covered =
            std::ranges::count_if(channels, [none](const glm::vec2& v) { return v.x != none || v.y != none; });
        all.push_back({"skin_share", "Texels with skins", "share of the maps",
                       static_cast<double>(covered) / static_cast<double>(channels.size())});
    }
    if (frame.plan().runs("sample placement")) {
        all.push_back(
            {"undersampled", "Surfaces that no sample sees but a candidate does", "share of the maps", undersampled_});
    }
    return all;
}

}  // namespace penumbra
