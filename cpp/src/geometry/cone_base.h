#pragma once

#include <glm/glm.hpp>
#include <vector>

#include "penumbra/light.h"

namespace penumbra {

/// What stands for the light's shape.
enum class ConeShape {
    Disc,    ///< a disc parallel to the map, of equal area (lines: of equal mean width)
    Sphere,  ///< point and spot: the sphere's outline as each edge sees it; other kinds: as Disc
    Light,   ///< the light's own outline; point, spot and sun: as Disc
};

/// The light as a shape in the plane z_ls = 0 of a map, relative to its centre: the base of every cone that hangs from
/// a silhouette, point-reflected [WymanHansen2003; penumbra-maps 2.7]. Metres; sun: tangents.
struct ConeBase {
    enum class Kind { Ellipse, Polygon, Sphere };
    Kind kind = Kind::Ellipse;
    glm::dmat2 ip_from_unit{1.0};     ///< Ellipse: the unit disc's image, of positive determinant; else identity
    std::vector<glm::dvec2> corners;  ///< Polygon: counter-clockwise in (x_ls, y_ls), 0 inside; 2: a segment
    double reach = 0.0;               ///< farthest point of the shape from the centre (Sphere: the radius)

    /// Half width along the unit vector n: the largest n . q.
    [[nodiscard]] double support(const glm::dvec2& n) const noexcept;
};

/// @param ls_from_world rotation of the map's face; a light that does not lie in the plane z_ls = 0 is projected onto
/// it
[[nodiscard]] ConeBase cone_base(const Light& light, ConeShape shape, const glm::dmat3& ls_from_world);

/// Radius of ConeShape::Disc: equal area; lines and areas without width 2/pi of the longest half axis (a disc of equal
/// mean width); sun: tangent of half the angle, which is taken as 85 degrees at most.
[[nodiscard]] double disc_radius(const Light& light);

/// Closed form of the published ramp [penumbra-maps 3.1]: place t = 0 .. 1 between silhouette and rim in the image
/// plane; kappa = depth of the receiver over depth of the edge, >= 1.
[[nodiscard]] double published_intensity(double t, double kappa) noexcept;
/// 3 x^2 - 2 x^3
[[nodiscard]] double smoothstep_falloff(double x) noexcept;
/// Visible fraction of a disc cut by a straight edge; u = -1 .. 1, positive on the lit side.
[[nodiscard]] double disc_fraction(double u) noexcept;

}  // namespace penumbra
