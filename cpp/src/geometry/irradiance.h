#pragma once

#include <glm/glm.hpp>
#include <span>

#include "penumbra/light.h"

namespace penumbra {

/// What a light turns into once its degenerate cases are told apart; the values are PENUMBRA_LIGHT_* of
/// shaders/shared/light.h. `emission` (radiometry.h) has the unit given here.
enum class LightForm {
    None = 0,   ///< gives nothing
    Point = 1,  ///< Point, Spot of radius 0, Line of length 0: intensity, W/sr
    FacingPoint =
        2,           ///< Rectangle, Ellipse, Polygon without extent: intensity along the normal, W/sr, times the cosine
    Sphere = 3,      ///< Point, Spot: radiance, W/(m^2 sr)
    Direction = 4,   ///< Sun of angle 0: irradiance on a surface that faces it, W/m^2
    Sun = 5,         ///< Sun: radiance
    Line = 6,        ///< Line: radiance x diameter of the thin cylinder, W/(m sr)
    FacingLine = 7,  ///< Rectangle, Ellipse, Polygon without width: radiance x width, W/(m sr), times the cosine
    Ellipse = 8,     ///< radiance
    Polygon = 9,     ///< Rectangle, Polygon: radiance
};

/// Sizes below 1e-12 m or 1e-9 rad, and areas below 1e-14 of the squared size, count as none.
[[nodiscard]] LightForm form_of(const Light& light);

/// Irradiance per unit of the light's emission at a point, unshadowed, without a spot's cone: for the forms with a
/// radiance, the integral of the cosine over the solid angle that the light subtends above the receiver's horizon
/// (0 .. pi). Defined everywhere and finite: 0 behind an area light, in its plane and on it, and on a line or point
/// itself; pi inside a sphere, whose inner side shines as in Cycles.
///
/// Polygon: Lambert's contour [Lambert1760], clipped to the horizon. Ellipse of any shape and orientation: closed form
/// by its cone's axes; sphere and sun: the same with a circular cone; both clipped to the horizon in closed form too.
/// Line: closed form [Nishita1985]. All are arranged so that a light that is tiny or far keeps its digits.
/// @param n_ws unit normal of the receiver
[[nodiscard]] double irradiance_per_radiance(const Light& light, const glm::dvec3& p_ws, const glm::dvec3& n_ws);

/// Transmission of a spot's cone for a receiver, 0 .. 1: Cycles' form, a smoothstep of the cosine to the axis in the
/// space where the cone's scale is taken out, seen from the light's centre. (Cycles takes each sampled point of the
/// sphere instead, which blurs the rim by the sphere's size; see radiometry.h.) 1 for other kinds of light.
[[nodiscard]] double spot_attenuation(const Light& light, const glm::dvec3& p_ws);

/// The parts, for tests and other shapes. All take vectors from the receiver, per unit radiance; not one-sided.

/// Planar polygon: corners centre + offset, in either direction.
[[nodiscard]] double polygon_irradiance(const glm::dvec3& towards_centre, std::span<const glm::dvec3> offsets,
                                        const glm::dvec3& normal);
/// Ellipse centre + a u + b v, a^2 + b^2 <= 1; u and v need not be perpendicular.
[[nodiscard]] double ellipse_irradiance(const glm::dvec3& towards_centre, glm::dvec3 u, glm::dvec3 v,
                                        const glm::dvec3& normal);
/// Circular cone of directions around `axis` (unit).
/// @param sine, cosine of half its angle, 0 .. pi/2
[[nodiscard]] double cone_irradiance(double sine, double cosine, const glm::dvec3& axis, const glm::dvec3& normal);
/// Thin cylinder centre +- half, per radiance x diameter.
/// @param facing if not null, unit normal of a flat strip instead, per radiance x width
[[nodiscard]] double line_irradiance(const glm::dvec3& towards_centre, const glm::dvec3& half, const glm::dvec3& normal,
                                     const glm::dvec3* facing = nullptr);

}  // namespace penumbra
