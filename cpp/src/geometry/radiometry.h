#pragma once

#include <glm/glm.hpp>

#include "geometry/irradiance.h"
#include "penumbra/light.h"

namespace penumbra {

/// What the light emits, RGB, from Light::power_w = P; in the unit of its form (LightForm):
///
///     Sphere       L = P / (4 pi^2 r^2)      flux pi L over the surface 4 pi r^2
///     Point        I = P / (4 pi)            its limit
///     Ellipse,
///     Polygon      L = P / (pi A)            one side; A = emitting_area
///     FacingLine   L w = P / (pi l)          its limit, l the whole length
///     FacingPoint  I = P / pi                its limit
///     Line         L d = P / (pi^2 l)        thin cylinder, flux pi L over the surface pi d l
///     Sun          L = P / (pi sin^2(angle/2))   P is the irradiance of a surface that faces it
///     Direction    E = P
///
/// Line has no counterpart in Blender. The others are Blender's definitions, checked against Cycles 4.5.15 with a
/// white diffuse plane (64 x 64 points, 256 to 2048 samples, no bounces): point of radius 0 and spot within 0.05 %
/// everywhere, mean of sphere, disc, ellipse, square, rectangle within 1e-4, also with scaled light objects (an area
/// light's power does not change with its object's scale, its area does; a point's radius is not scaled); sun of 0,
/// 1, 3 and pi radians: 5.0000 for 5; a sphere cut by the horizon, from within too: within its noise of 0.5 %.
/// Two things differ from Cycles' defaults, and must be set alike for a comparison:
/// - a point or spot with "Soft Falloff" (use_soft_falloff, on by default) is a disc facing the receiver in Cycles,
///   not a sphere: its irradiance is smaller by 1 / (1 + r^2/d^2);
/// - Cycles takes a spot's cone from each point of its sphere, here it is taken from the centre: equal for radius 0
///   (within 0.5 %), else the rim is blurred in Cycles by about r/d.
[[nodiscard]] glm::dvec3 emission(const Light& light);

/// Unshadowed irradiance at a point in W/m^2, RGB: emission x irradiance_per_radiance x spot_attenuation. A Lambert
/// surface reflects albedo / pi of it as radiance.
/// @param n_ws unit normal of the receiver
[[nodiscard]] glm::dvec3 unshadowed_irradiance(const Light& light, const glm::dvec3& p_ws, const glm::dvec3& n_ws);

}  // namespace penumbra
