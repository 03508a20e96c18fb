#pragma once

#include <cstdint>

#include "passes/penumbra_mask.h"
#include "penumbra/technique.h"
#include "reference/masked_tracer.h"

namespace penumbra {

/// Shadow rays only where a penumbra may be: the penumbra mask (passes/penumbra_mask) says of most pixels surely lit or
/// surely in umbra, and the rest are traced with as many rays as a pilot finds use for. Equal to `ray_traced` within
/// its noise, at a fraction of its rays. Ours; after the computation mask of [Chan2004].
/// docs/techniques/masked_rays.md.
class MaskedRays final : public Technique {
public:
    explicit MaskedRays(const Settings& settings);
    [[nodiscard]] static const TechniqueInfo& description();

    [[nodiscard]] const TechniqueInfo& info() const noexcept override { return description(); }
    [[nodiscard]] Verdict supports(const Light& light) const override;
    [[nodiscard]] Plan plan(const LightSummary& summary) const override;
    [[nodiscard]] FieldOfUse field_of_use() const override { return {.needs_float32_rays = true}; }
    void prepare(Frame& frame) override;
    void update(Frame& frame) override;
    void resolve(Frame& frame) override;
    [[nodiscard]] std::size_t memory_bytes() const noexcept override {
        return mask_.bytes() + classes_.capacity() + listed_.capacity();
    }
    [[nodiscard]] std::vector<Statistic> statistics(Frame& frame) override;
    [[nodiscard]] std::vector<DebugView> debug_views(const Plan& plan) const override;
    [[nodiscard]] DebugImage debug_image(Frame& frame, std::string_view id) override;

private:
    /// Sure pixels whose rays say otherwise.
    [[nodiscard]] Statistic wrongly_sure(Frame& frame) const;

    /// V of what the rule pixel-outside-mask leaves out, for nobody: pixels lend each other what they find, so the
    /// others must not see it.
    void trace_unasked(Frame& frame) const;
    /// What the maps leave open, and V of the rest.
    void list_by_mask(Frame& frame);
    /// Classes of what the pilot rays found, for statistics.
    void classify_by_pilot(Frame& frame);

    MaskedTraceOptions options_;
    int check_rays_;
    bool by_rays_;
    PenumbraMask mask_;
    std::vector<std::uint8_t> listed_;   ///< 1 where rays find V
    std::vector<std::uint8_t> classes_;  ///< by the maps
    MaskedTraceCounts counts_;
};

}  // namespace penumbra
