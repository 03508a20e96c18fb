#pragma once

#include <cstdint>
#include <glm/glm.hpp>
#include <string>
#include <vector>

#include "penumbra/light.h"
#include "penumbra/plan.h"
#include "penumbra/scene.h"
#include "penumbra/view.h"
#include "scene/bounds.h"

namespace penumbra {

/// Visible receiver points of one block of pixels, all inside the light's mask.
struct ReceiverTile {
    glm::vec3 low_cr, high_cr;      ///< box of the points, relative to the eye, metres
    std::uint32_t first_pixel = 0;  ///< range in LightSummary::receiver_pixels
    std::uint32_t pixel_count = 0;
};

/// What of the scene matters to one light in one view. Every plan is made from it; no GPU needed.
struct LightSummary {
    const Light* light = nullptr;
    const Scene* scene = nullptr;  ///< what it was made from; both live as long as the summary
    const View* view = nullptr;
    glm::dvec3 eye_ws{0.0};
    bool has_extent = false;  ///< false: a hard shadow is the truth
    Keep keep;                ///< rules that must leave nothing out

    std::vector<std::uint8_t> mask;             ///< 1 where V is asked, as in View
    std::uint64_t lit_pixels = 0;               ///< ones in the mask
    std::vector<ReceiverTile> tiles;            ///< all pixels of the mask, 16 x 16 blocks
    std::vector<glm::vec3> receiver_points_cr;  ///< positions of the mask's pixels, tile by tile
    Bounds receivers_ws;                        ///< box of the mask's pixels; empty if there are none

    std::vector<std::uint32_t> receivers;     ///< instances seen at a pixel of the mask, ascending
    std::uint32_t receivers_not_casting = 0;  ///< of these, how many do not cast: no depth map of casters holds them

    std::vector<std::uint32_t> casters;  ///< instances that can cast onto a visible receiver (all if the rule is kept)
    std::vector<std::uint8_t> caster_needed;  ///< 0 only if the rule is kept: drawn, but must not matter
    std::uint32_t casters_outside = 0;        ///< casting instances outside the hull of light and receivers
    /// Of these, ascending, what lies no farther from the hull than twice the radius of all visible receivers. A kernel
    /// may look so far beside its receiver and find it there (MapFace::beside); kept frames depend on it.
    std::vector<std::uint32_t> near_hull;
    std::vector<Bounds> near_hull_bounds_ws;  ///< boxes of `near_hull`
    std::uint64_t caster_triangles = 0;
    std::vector<Bounds> caster_bounds_ws;  ///< boxes of `casters`

    [[nodiscard]] bool keeps(std::string_view rule) const noexcept { return keep.has(rule); }
    /// "" or why V is 1 everywhere without any work, and the rule that says so.
    struct Trivial {
        std::string rule, reason;
    };
    [[nodiscard]] Trivial trivial() const;
};

/// False where a plane keeps the box apart from the hull of the light and all that lies within `reach_m` of the visible
/// receivers: who looks that far beside them, at texels under a kernel, does not find it either.
[[nodiscard]] bool within_reach(const LightSummary& summary, const Bounds& caster_ws, double reach_m);

/// @param instance_bounds_ws box of each instance, as many as scene.instances
[[nodiscard]] LightSummary summarise_light(const Scene& scene, const View& view, const Light& light,
                                           const std::vector<Bounds>& instance_bounds_ws, const Keep& keep);

}  // namespace penumbra
