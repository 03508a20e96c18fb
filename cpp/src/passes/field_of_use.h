#pragma once

#include <vector>

#include "passes/light_summary.h"
#include "penumbra/plan.h"
#include "penumbra/technique.h"

namespace penumbra {

/// What of a light and its scene breaks what a technique takes for granted, each in one sentence with the numbers.
/// Reads the summary alone; of casters whose boxes reach into the light also the triangles.
[[nodiscard]] std::vector<Warning> outside_field(const FieldOfUse& field, const LightSummary& summary);

}  // namespace penumbra
