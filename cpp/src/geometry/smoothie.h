#pragma once

#include <glm/glm.hpp>
#include <vector>

#include "penumbra/light.h"

namespace penumbra {

/// How a ramp 0 .. 1 becomes V.
enum class Falloff {
    Linear,
    Sinusoidal,  ///< (1 - cos(pi v)) / 2
    Cubic,       ///< 3 v^2 - 2 v^3
    Disc,        ///< area of a disc cut by a straight edge: 1/2 + (x sqrt(1 - x^2) + asin x) / pi, x = 2 v - 1
};
/// @param v clamped to 0 .. 1
[[nodiscard]] double falloff(Falloff kind, double v) noexcept;

/// Smoothie alpha after the remap [Chan2004, Eq. 1]: alpha / (1 - b/r), clamped; 1 where the smoothie is hidden
/// (b >= r), 0/0 included. @param alpha 0 at the silhouette .. 1 at the rim  @param b_over_r >= 0
[[nodiscard]] double remapped_alpha(double alpha, double b_over_r) noexcept;

/// World width of a smoothie penumbra on a receiver parallel to the light's image plane, outwards from the hard edge.
/// @param t_ip screen width as a tangent  @param b_m, r_m depths of blocker and receiver from the light, metres
[[nodiscard]] double smoothie_width_m(double t_ip, double b_m, double r_m) noexcept;

/// What a light's shape means to an outline that it throws: how far the lit rim of the penumbra lies out.
///
/// The light is taken as its parallel projection onto the map's image plane through the light's centre. Behind a
/// straight edge with outer unit normal n the rim lies at half_width(n) * (1/b - 1/r) tangents (a sun: half_width(n) *
/// (r - b) metres) from the hard edge, which is exact for a light that lies in that plane.
class LightExtent {
public:
    enum class Shape { Disc, Parallelogram, Ellipse, Polygon };

    /// The light's own shape. @param ls_from_world rotation to the map's axes
    [[nodiscard]] static LightExtent of(const Light& light, const glm::dmat3& ls_from_world);
    /// A disc of the same area; a line has none, so the disc of the same mean half width (2/pi of its half length).
    [[nodiscard]] static LightExtent disc_of(const Light& light);

    [[nodiscard]] Shape shape() const noexcept { return shape_; }
    /// Metres; a sun: tangent of half its angle. Support of the shape against the edge's outer normal.
    [[nodiscard]] double half_width(const glm::dvec2& outer_normal) const noexcept;
    /// Of all directions.
    [[nodiscard]] double largest() const noexcept;
    /// Disc: radius in u.x. Else half axes, conjugate ones for an ellipse, in the map's x_ls and y_ls.
    [[nodiscard]] const glm::dvec2& u() const noexcept { return u_; }
    [[nodiscard]] const glm::dvec2& v() const noexcept { return v_; }
    [[nodiscard]] const std::vector<glm::dvec2>& corners() const noexcept { return corners_; }

private:
    Shape shape_ = Shape::Disc;
    glm::dvec2 u_{0.0}, v_{0.0};
    std::vector<glm::dvec2> corners_;
};

}  // namespace penumbra
