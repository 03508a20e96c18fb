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
/// Line has no counterpart in Blender. The others are Blender's definitions, checked against Cycles 4.5.15: a white
/// diffuse plane seen from above, one light, no bounces, 256 to 2048 samples, float32 EXR, pixel x pi against
/// unshadowed_irradiance at 48 x 48 points. Sum over the plane, ours against Cycles': turned and scaled rectangle,
/// disc, ellipse, sphere, stretched spot of radius 0: 1e-5 (sphere 6e-5); ellipse and rectangle that the plane cuts:
/// 2e-4; sun of 0, 1, 3 and pi radians from above, and of 1 radian cut by the horizon: 1e-5. Largest single difference
/// 4e-3 of the brightest point, 9e-3 where the light is cut: Cycles' noise. From inside a sphere Cycles gives pi L, as
/// here. (An area light's power does not change with its object's scale, its area does; a point's radius is not scaled;
/// a spot's scale acts as x / z and y / z on the cone.) What differs from Cycles and must be set alike to compare:
/// - a point or spot with "Soft Falloff" (use_soft_falloff, on by default) is a disc facing the receiver in Cycles,
///   not a sphere: its irradiance is smaller by 1 / (1 + r^2/d^2);
/// - Cycles takes a spot's cone from each point of its sphere, here it is taken from the centre: the same for radius
///   0; otherwise Cycles' rim is wider by about r/d (0.1 m at 3 m: sums agree within 1e-4, the rim within 4 % of the
///   brightest point).
[[nodiscard]] glm::dvec3 emission(const Light& light);

/// Unshadowed irradiance at a point in W/m^2, RGB: emission x irradiance_per_radiance x spot_attenuation. A Lambert
/// surface reflects albedo / pi of it as radiance.
/// @param n_ws unit normal of the receiver
[[nodiscard]] glm::dvec3 unshadowed_irradiance(const Light& light, const glm::dvec3& p_ws, const glm::dvec3& n_ws);

}  // namespace penumbra
