#pragma once

#include "passes/centre_map.h"
#include "passes/inner_edges.h"
#include "passes/silhouette_pass.h"
#include "penumbra/technique.h"
#include "techniques/smoothies/smoothie_buffer.h"

namespace penumbra {

/// Smoothies [ChanDurand2003, Chan2004]: one depth map, and a second buffer in the light's view with quads
/// ("smoothies") glued outside the silhouettes of the casters. Their alpha runs from 0 at the silhouette to 1 at the
/// rim, divided by 1 - b/r (b the smoothie's depth, r the receiver's), so that penumbrae open with the distance from
/// the contact. A pixel behind a caster is dark, one behind a smoothie takes its alpha, all others are lit.
///
/// Published, the quads have one width t on the light's screen; here that is one choice, and the width that the light's
/// own size gives is the default. Only the outer half of the penumbra exists: V is 0 at the hard edge, umbrae never
/// shrink; `sides = both` adds the inner half (ours). What is exact and what is wrong by construction, and by how much:
/// docs/techniques/smoothies.md.
class Smoothies final : public Technique {
public:
    explicit Smoothies(const Settings& settings);
    [[nodiscard]] static const TechniqueInfo& description();

    [[nodiscard]] const TechniqueInfo& info() const noexcept override { return description(); }
    [[nodiscard]] Verdict supports(const Light& light) const override;
    [[nodiscard]] Plan plan(const LightSummary& summary) const override;
    [[nodiscard]] FieldOfUse field_of_use() const override;
    void prepare(Frame& frame) override;
    void update(Frame& frame) override;
    void resolve(Frame& frame) override;
    [[nodiscard]] std::size_t memory_bytes() const noexcept override;

    [[nodiscard]] std::vector<DebugView> debug_views(const Plan& plan) const override;
    [[nodiscard]] DebugImage debug_image(Frame& frame, std::string_view id) override;

private:
    enum class Filter { Bilinear, Published, Nearest };
    enum class Store { Auto, On, Off };

    /// A light without extent (or t = 0) has no smoothies.
    [[nodiscard]] bool has_width(const LightSummary& summary) const noexcept;
    /// Some receiver may lie in front of a smoothie without being in the map.
    [[nodiscard]] bool reads_depth(const LightSummary& summary) const noexcept;
    [[nodiscard]] const Program& lookup(Frame& frame);

    Filter filter_;
    Falloff falloff_;
    Store store_;
    bool both_sides_;
    SmoothieOptions options_;
    MapBias bias_;
    CentreMap map_;
    SilhouettePass silhouettes_;
    SmoothieBuffer buffer_;
    InnerEdges inner_;
};

}  // namespace penumbra
