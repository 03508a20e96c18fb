#pragma once

#include <vector>

#include "penumbra/light.h"

namespace penumbra {

/// For techniques that take every kind of light.
[[nodiscard]] inline std::vector<LightKind> all_light_kinds() {
    return {LightKind::Point,   LightKind::Spot, LightKind::Sun,    LightKind::Rectangle,
            LightKind::Ellipse, LightKind::Line, LightKind::Polygon};
}

}  // namespace penumbra
