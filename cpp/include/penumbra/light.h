#pragma once

#include <glm/glm.hpp>
#include <string>
#include <string_view>
#include <vector>

namespace penumbra {

enum class LightKind {
    Point,      ///< sphere of radius_m; 0 is a true point
    Spot,       ///< sphere of radius_m inside a cone; the cone belongs to shading and to the mask, not to V
    Sun,        ///< disc of directions of full angle sun_angle_rad
    Rectangle,  ///< parallelogram centre +- half_u +- half_v, one-sided
    Ellipse,    ///< centre + a half_u + b half_v with a^2 + b^2 <= 1, one-sided (a disc if the axes are equal)
    Line,       ///< segment centre +- half_u, radiates as a thin cylinder (Lambert per length, all around)
    Polygon,    ///< convex planar polygon corners_ws (3 .. 8 corners), one-sided
};

/// One light, in world space: float64, metres, radians. Plain data; validate(Light) is the border.
struct Light {
    std::string name;
    LightKind kind = LightKind::Point;

    glm::dvec3 position_ws{0.0};              ///< centre; unused by Sun; for Polygon the mean of the corners
    glm::dvec3 direction_ws{0.0, 0.0, -1.0};  ///< unit; direction in which it shines (spot axis, sun rays, area normal)
    glm::dvec3 half_u_ws{0.0};                ///< area kinds: centre to the edge; Spot: unit local x axis
    glm::dvec3 half_v_ws{0.0};                ///< the same along v; zero for Line
    std::vector<glm::dvec3> corners_ws;       ///< Polygon only; counter-clockwise seen from the lit side

    double radius_m = 0.0;                       ///< Point, Spot
    double sun_angle_rad = 0.0;                  ///< Sun: full apex angle, 0 .. pi
    double spot_angle_rad = 0.7853981633974483;  ///< Spot: full angle of the cone, 0 .. pi
    double spot_blend = 0.15;                    ///< Spot: 0 hard .. 1 soft rim of the cone
    glm::dvec2 spot_stretch{1.0};                ///< Spot: scale of the cone along half_u and half_v, > 0

    glm::dvec3 power_w{10.0};  ///< RGB watts as Blender defines them, Sun: W/m^2; negative takes light away
    bool casts_shadow = true;  ///< false: V is 1 everywhere
};

/// "point", "spot", "sun", "rectangle", "ellipse", "line", "polygon".
[[nodiscard]] std::string_view to_string(LightKind kind) noexcept;

/// True if no point of the light differs from another (radius, angle or both half axes zero): a hard shadow.
[[nodiscard]] bool has_no_extent(const Light& light) noexcept;

/// @throws InvalidScene for NaN, infinite or contradictory members, negative sizes and angles; an area light of zero
/// area is allowed and becomes a Line or a Point that shines on one side only (see has_no_extent).
void validate(const Light& light);

}  // namespace penumbra
