#pragma once

#include "penumbra/light.h"

namespace penumbra {

/// Checks a light and gives every member its one defined form; validate(Scene) calls it for each light:
/// - `direction_ws` becomes unit. For an area light it becomes the exact normal of its plane on the side it pointed to;
///   where the area is zero, it is made perpendicular to what is left of the light.
/// - Spot: `half_u_ws` and `half_v_ws` become unit vectors perpendicular to the direction and to each other.
/// - Polygon: repeated corners are dropped, the order becomes counter-clockwise seen from the lit side,
///   `position_ws` the mean of the corners.
/// Line and Polygon get zeros in the half axes they do not use.
/// @throws InvalidScene as validate(Light) does
void normalise(Light& light);

}  // namespace penumbra
