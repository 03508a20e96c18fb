#pragma once

#include "passes/volume_pass.h"
#include "penumbra/technique.h"

namespace penumbra {

/// Stencil shadow volumes of the light's centre [Crow1977], counted z-fail [EverittKilgard2002]: exact hard shadows per
/// pixel, with no map, no bias and no limit of the light's field. Its cost is fill: every pixel that a volume's polygon
/// covers is tested. Knows nothing of the light's size, as shadow_map.
/// Counts, caps, open meshes, overflow: docs/techniques/shadow_volume.md.
class ShadowVolume final : public Technique {
public:
    explicit ShadowVolume(const Settings& settings);
    [[nodiscard]] static const TechniqueInfo& description();

    [[nodiscard]] const TechniqueInfo& info() const noexcept override { return description(); }
    [[nodiscard]] Verdict supports(const Light& light) const override;
    [[nodiscard]] Plan plan(const LightSummary& summary) const override;
    [[nodiscard]] FieldOfUse field_of_use() const override;
    void prepare(Frame& frame) override;
    void update(Frame& frame) override;
    void resolve(Frame& frame) override;
    [[nodiscard]] std::size_t memory_bytes() const noexcept override { return volumes_.bytes(); }
    [[nodiscard]] std::vector<DebugView> debug_views(const Plan& plan) const override;
    [[nodiscard]] DebugImage debug_image(Frame& frame, std::string_view id) override;
    [[nodiscard]] std::vector<Statistic> statistics(Frame& frame) override;

private:
    VolumePass volumes_;
};

}  // namespace penumbra
