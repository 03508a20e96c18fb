#pragma once

#include <vector>

#include "passes/depth_map.h"
#include "passes/map_bias.h"
#include "penumbra/technique.h"
#include "techniques/linear_light_maps/hard_rest.h"
#include "techniques/linear_light_maps/linear_views.h"
#include "techniques/linear_light_maps/sample_placement.h"
#include "techniques/linear_light_maps/skin_pass.h"
#include "techniques/linear_light_maps/software_engine.h"

namespace penumbra {

/// Soft shadow maps for linear lights [Heidrich2000]: a few samples of a line segment, each with a depth map and a
/// second channel that says how much of the whole light a surface point sees. The channel is made from the neighbouring
/// sample's depth discontinuities: skins between a caster's edge and what lies behind it, seen from here. A lookup
/// costs what as many hard shadows cost.
///
/// Exact (to a texel) where caster and receiver are parallel to the light; `transition = exact` for receivers of any
/// shape. Wrong by construction: what no sample sees is dark though a middle part of the light may see it, and thick
/// casters jump at the border of a sample's shadow. Other lights are stood in for by lines (geometry/linear_rods.h).
/// Figures: docs/techniques/linear_light_maps.md.
class LinearLightMaps final : public Technique {
public:
    explicit LinearLightMaps(const Settings& settings);
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
    /// One linear light at work.
    struct Rod {
        LinearRod segment;
        LinearViews views;
        int first_layer = 0;
        [[nodiscard]] int layers() const noexcept { return views.samples() * static_cast<int>(views.windows.size()); }
    };
    /// @param places  of each rod's samples; evenly where there are none
    [[nodiscard]] std::vector<Rod> fit_rods(const LightSummary& summary,
                                            const std::vector<std::vector<double>>& places = {}) const;
    [[nodiscard]] std::vector<LinearRod> segments_of(const LightSummary& summary, const glm::dvec3& middle_cr) const;
    [[nodiscard]] std::string no_skins(const LightSummary& summary, const std::vector<Rod>& rods) const;
    void allocate(Frame& frame);
    void place_samples(Frame& frame);
    void draw_skins(Frame& frame);
    [[nodiscard]] const DepthMap& surfaces(const Frame& frame) const;
    /// More than one pass has a say in a picture.
    [[nodiscard]] bool sums_needed() const noexcept {
        return rods_.size() > 1 || !rest_.empty() || rods_.front().views.windows.size() > PENUMBRA_MAX_FACES;
    }
    [[nodiscard]] const Program& combination(Frame& frame, const Rod& rod, const LinearViews::Group& group) const;
    void combine(Frame& frame, const Rod& rod, const LinearViews::Group& group);
    void accumulate(Frame& frame);
    void resolve_in_software(Frame& frame);
    [[nodiscard]] LinearLookup software_lookup() const;

    int samples_;
    int most_samples_;  ///< 0: samples are not added
    int strips_;
    RodLayout layout_;
    int size_px_;
    MapBias bias_;
    bool facing_test_, clamp_, rim_rule_, local_, software_;
    SkinRules rules_;

    std::vector<Rod> rods_;
    DepthMap maps_, surface_maps_;
    MapSetup setup_;
    SkinPass skins_;
    SamplePlacement placement_;
    HardRest rest_;
    SoftwareEngine engine_;
    double undersampled_ = 0.0;
    TextureImage sums_;
    RenderTarget sums_target_;
};

}  // namespace penumbra
