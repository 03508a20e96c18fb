#pragma once

#include <cstddef>
#include <string>

#include "passes/map_frustum.h"
#include "penumbra/plan.h"

namespace penumbra {

/// Draws of a caster into a face of a map that the rule caster-outside-face leaves out, for the plan.
struct CastersBeside {
    std::size_t outside = 0, draws = 0;

    void add(const LightSummary& summary, const MapFace& face) {
        draws += summary.casters.size();
        outside += summary.casters.size() - face.casters.size();
    }
    void tell(Plan& plan) const {
        if (outside > 0) {
            plan.leave_out("casters beside the maps", "caster-outside-face",
                           std::to_string(outside) + " of " + std::to_string(draws) +
                               " draws of a caster into a face would touch no texel before a visible receiver");
        }
    }
};

}  // namespace penumbra
