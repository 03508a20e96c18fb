#pragma once

#include "passes/centre_map.h"
#include "penumbra/technique.h"

namespace penumbra {

/// Hard shadow map [Williams1978]: nearest depth from the light's centre, one comparison per pixel. Knows nothing of
/// the light's size, so in a penumbra its error is that of a step against a ramp (RMSE 1/sqrt(12) on a straight edge).
/// Formulas, biases and their failures: docs/techniques/shadow_map.md.
class ShadowMap final : public Technique {
public:
    explicit ShadowMap(const Settings& settings);
    [[nodiscard]] static const TechniqueInfo& description();

    [[nodiscard]] const TechniqueInfo& info() const noexcept override { return description(); }
    [[nodiscard]] Verdict supports(const Light& light) const override;
    [[nodiscard]] Plan plan(const LightSummary& summary) const override;
    [[nodiscard]] FieldOfUse field_of_use() const override;
    void prepare(Frame& frame) override;
    void update(Frame& frame) override;
    void resolve(Frame& frame) override;
    [[nodiscard]] std::size_t memory_bytes() const noexcept override { return map_.bytes(); }
    [[nodiscard]] std::vector<DebugView> debug_views(const Plan& plan) const override;
    [[nodiscard]] DebugImage debug_image(Frame& frame, std::string_view id) override;

private:
    CentreMap map_;
};

}  // namespace penumbra
