#pragma once

#include "passes/depth_map.h"
#include "passes/map_bias.h"
#include "passes/penumbra_mask.h"
#include "penumbra/technique.h"
#include "techniques/light_samples/sample_points.h"

namespace penumbra {

class AskedPixels;

/// N hard shadow maps from points of the light, averaged on the GPU [HeckbertHerf1997]. Tends to the truth as N and the
/// maps' size grow, for every arrangement of casters; costs N hard frames. V takes N + 1 values, so penumbrae show
/// steps of width W/N. Weights of sphere samples and failures: docs/techniques/light_samples.md.
class LightSamples final : public Technique {
public:
    explicit LightSamples(const Settings& settings);
    [[nodiscard]] static const TechniqueInfo& description();

    [[nodiscard]] const TechniqueInfo& info() const noexcept override { return description(); }
    [[nodiscard]] Verdict supports(const Light& light) const override;
    [[nodiscard]] Plan plan(const LightSummary& summary) const override;
    [[nodiscard]] FieldOfUse field_of_use() const override;
    void prepare(Frame& frame) override;
    void update(Frame& frame) override;
    void resolve(Frame& frame) override;
    [[nodiscard]] std::size_t memory_bytes() const noexcept override;
    [[nodiscard]] std::vector<Statistic> statistics(Frame& frame) override;
    [[nodiscard]] std::vector<DebugView> debug_views(const Plan& plan) const override;
    [[nodiscard]] DebugImage debug_image(Frame& frame, std::string_view id) override;

private:
    struct Sample {
        LightSamplePoint point;
        MapFrustum frustum;
        gpu::MapBlock block{};
        int first_layer = 0;
    };
    [[nodiscard]] std::vector<Sample> fit_samples(const LightSummary& summary) const;
    void render_maps(Frame& frame, std::size_t index, int first_layer);
    [[nodiscard]] const Program& accumulation(Frame& frame, const Sample& sample) const;
    void accumulate(Frame& frame, const Sample& sample, int first_layer, const AskedPixels& asked);

    int count_;
    int size_px_;
    std::string pattern_;
    std::uint32_t seed_;
    std::size_t memory_cap_bytes_;
    bool facing_test_;
    bool masked_;
    MapBias bias_;
    PenumbraMask mask_;

    bool sphere_ = false;     ///< sampled all over its surface, so samples carry weights
    bool keep_maps_ = false;  ///< all maps stay, so that a static frame is lookups alone
    std::vector<Sample> samples_;
    DepthMap maps_;
    MapSetup setup_;
    TextureImage sums_;
    TextureImage stencil_;  ///< of pixels under the mask
    RenderTarget sums_target_;
};

}  // namespace penumbra
