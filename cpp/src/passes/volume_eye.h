#pragma once

#include "passes/light_summary.h"

namespace penumbra {

/// True if no point of the caster's box lies between the light and the eye or the near rectangle: then the eye is
/// outside its volume, and nothing of the volume is cut off in front of the eye. Never of an orthographic camera, whose
/// rays come from behind it without end.
[[nodiscard]] bool eye_is_outside(const Bounds& caster_ws, const Camera& camera, const Light& light);

}  // namespace penumbra
