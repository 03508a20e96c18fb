#pragma once

#include <array>
#include <optional>
#include <string_view>

#include "penumbra/light.h"

namespace penumbra {

/// All kinds, in the order of the enumeration.
inline constexpr std::array kLightKinds{LightKind::Point,   LightKind::Spot, LightKind::Sun,    LightKind::Rectangle,
                                        LightKind::Ellipse, LightKind::Line, LightKind::Polygon};

/// The inverse of to_string(LightKind); nothing for a name that is not in its list.
[[nodiscard]] std::optional<LightKind> light_kind_from_string(std::string_view name) noexcept;

/// Rectangle, Ellipse, Line, Polygon: the kinds whose shape is given by half axes or corners.
[[nodiscard]] bool is_area(LightKind kind) noexcept;

}  // namespace penumbra
