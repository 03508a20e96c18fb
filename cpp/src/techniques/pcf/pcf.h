#pragma once

#include "passes/centre_map.h"
#include "passes/window_range.h"
#include "penumbra/technique.h"

namespace penumbra {

/// Percentage-closer filtering [Reeves1987]: depths are compared first, then the answers averaged. Softens by a fixed
/// number of texels, the same near the contact and far from it, whatever the size of the light.
/// Filters: 2 x 2 bilinear (1-texel ramp), bicubic B-spline by 16 or by 4 fetches (3-texel ramp), N x N box (N-texel
/// ramp). Formulas and failures: docs/techniques/pcf.md.
class Pcf final : public Technique {
public:
    explicit Pcf(const Settings& settings);
    [[nodiscard]] static const TechniqueInfo& description();

    [[nodiscard]] const TechniqueInfo& info() const noexcept override { return description(); }
    [[nodiscard]] Verdict supports(const Light& light) const override;
    [[nodiscard]] Plan plan(const LightSummary& summary) const override;
    [[nodiscard]] FieldOfUse field_of_use() const override;
    void prepare(Frame& frame) override;
    void update(Frame& frame) override;
    void resolve(Frame& frame) override;
    [[nodiscard]] std::size_t memory_bytes() const noexcept override { return map_.bytes() + range_.bytes(); }
    [[nodiscard]] std::vector<DebugView> debug_views(const Plan& plan) const override;
    [[nodiscard]] DebugImage debug_image(Frame& frame, std::string_view id) override;

private:
    int filter_;  ///< index of the choice; FILTER in pcf.frag
    int kernel_;
    bool mask_;  ///< asked for, and of use to the filter and bias
    CentreMap map_;
    WindowRange range_;
    Sampler compare_sampler_;
    [[nodiscard]] const Program& lookup(Frame& frame) const;
};

}  // namespace penumbra
