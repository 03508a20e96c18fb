#pragma once

#include <cstdint>

#include "penumbra/technique.h"

namespace penumbra {

/// Distribution ray tracing on the CPU [Cook1984]: N stratified rays per pixel to the light through Embree. Unbiased;
/// its error is noise, about 0.36 N^-3/4 in the penumbra of an area light. docs/techniques/ray_traced.md.
class RayTraced final : public Technique {
public:
    explicit RayTraced(const Settings& settings);
    [[nodiscard]] static const TechniqueInfo& description();

    [[nodiscard]] const TechniqueInfo& info() const noexcept override { return description(); }
    [[nodiscard]] Verdict supports(const Light& light) const override;
    [[nodiscard]] Plan plan(const LightSummary& summary) const override;
    [[nodiscard]] FieldOfUse field_of_use() const override { return {.needs_float32_rays = true}; }
    void prepare(Frame& frame) override;
    void update(Frame& frame) override;
    void resolve(Frame& frame) override;
    [[nodiscard]] std::size_t memory_bytes() const noexcept override { return 0; }
    [[nodiscard]] std::vector<Statistic> statistics(Frame& frame) override;

private:
    int rays_;
    std::uint32_t seed_;
    bool early_out_;
    int early_out_rays_;
    std::uint64_t rays_cast_ = 0;  ///< of the last frame
};

}  // namespace penumbra
