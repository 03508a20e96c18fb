#pragma once

#include <functional>
#include <span>
#include <vector>

#include "geometry/linear_light.h"
#include "passes/map_bias.h"
#include "techniques/linear_light_maps/linear_views.h"

namespace penumbra {

class Frame;

/// The software version: the depth maps that OpenGL made are read back, and all after them - edges, skins, both
/// channels, combination - is done in float64 on the processor, pixel by pixel.
class SoftwareEngine {
public:
    void clear() { rods_.clear(); }
    /// @param stored  all layers of the depth array
    void add(const LinearViews& views, double weight, const SkinRules& rules, std::span<const float> stored,
             int first_layer, int size_px);
    /// V at every pixel of the mask.
    /// @param local  local illumination of a sample at a point; empty: V is the share of the light that is seen
    using Local = std::function<double(const glm::dvec3& sample_ws, const glm::dvec3& along_ws, const glm::dvec3& p_ws,
                                       const glm::dvec3& n_ws)>;
    /// @param rest  sums of what other passes know of pixels outside all windows, or empty
    void resolve(Frame& frame, const LinearLookup& lookup, const Local& local, std::span<const glm::vec2> rest,
                 std::vector<float>& visibility) const;

private:
    struct Rod {
        const LinearViews* views;
        double weight;
        std::vector<LinearVisibility> windows;
    };
    std::vector<Rod> rods_;
};

}  // namespace penumbra
