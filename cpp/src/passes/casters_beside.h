#pragma once

#include <algorithm>
#include <cstddef>
#include <string>
#include <vector>

#include "passes/map_frustum.h"
#include "penumbra/plan.h"

namespace penumbra {

/// Draws of a caster into a face of a map that the rule caster-outside-face leaves out, for the plan.
struct CastersBeside {
    std::size_t outside = 0, draws = 0;
    std::vector<std::uint32_t> found;  ///< outside the hull of light and receivers, but drawn for lookups beside them

    void add(const LightSummary& summary, const MapFace& face) {
        draws += summary.casters.size();
        outside += summary.casters.size() - face.casters.size();
        for (const std::uint32_t instance : face.beside) {
            if (std::ranges::find(found, instance) == found.end()) {
                found.push_back(instance);
            }
        }
    }
    void tell(Plan& plan) const {
        if (outside > 0) {
            plan.leave_out("casters beside the maps", "caster-outside-face",
                           std::to_string(outside) + " of " + std::to_string(draws) +
                               " draws of a caster into a face would touch no texel before a visible receiver");
        }
    }
    /// The same of the rule caster-outside-hull.
    void tell_of_hull(const LightSummary& summary, Plan& plan) const {
        if (summary.casters_outside > found.size()) {
            plan.leave_out("casters out of reach", "caster-outside-hull",
                           std::to_string(summary.casters_outside - found.size()) +
                               " casters lie outside the space between the light and the visible receivers");
        }
    }
};

}  // namespace penumbra
