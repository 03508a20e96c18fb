#pragma once

#include <array>
#include <glm/glm.hpp>
#include <optional>
#include <span>
#include <vector>

namespace penumbra::plateau {

/// Closed forms of [Haines2001] on one receiver plane, in float64: what the shaders of techniques/plateaus compute, and
/// the oracles that test them. Plane coordinates: x and y in the plane, z = h above it towards the light, metres.
/// lambda is the slope coordinate: 0 at the hard shadow's edge, 1 where the light is whole again.

/// Light point (w = 1) or unit direction towards a sun (w = 0) in plane coordinates; z > 0.
using PlaneLight = glm::dvec4;

/// Where the light throws a vertex: the line from the light through it meets the plane.
/// @param vertex  z < light.z if w = 1
[[nodiscard]] glm::dvec2 project(const glm::dvec3& vertex, const PlaneLight& light) noexcept;

/// sigma: how much larger than the light its image on the plane is, h / (H - h); a sun: h over the sine of its
/// elevation, per unit of the tangent of its half angle.
[[nodiscard]] double image_scale(double height_m, const PlaneLight& light) noexcept;

/// A disc of the light's plane that straddles a straight edge: its visible part where the edge passes at `xi` radii
/// from the centre, xi in [-1, 1]: 1/2 + (xi sqrt(1 - xi^2) + asin xi) / pi.
[[nodiscard]] double disc_cut(double xi) noexcept;
/// The same of the square [-1, 1]^2; `normal` is the edge's, of any length, and xi counts in the square's own reach
/// along it, |n.x| + |n.y|.
[[nodiscard]] double square_cut(double xi, const glm::dvec2& normal) noexcept;
/// The same of a convex polygon around the origin.
[[nodiscard]] double polygon_cut(double xi, const glm::dvec2& normal, std::span<const glm::dvec2> corners) noexcept;

enum class Falloff { Linear, Sine, Smoothstep, Disc, DiscFull };
/// F of section 2.9. Disc jumps from 0 to 1/2 at lambda = 0 (exact outside a straight edge with outer match);
/// DiscFull is exact for width match.
[[nodiscard]] double falloff(Falloff kind, double lambda) noexcept;

/// Two circles on the plane, the images of the light through the ends of an edge.
struct Circles {
    glm::dvec2 s0{0.0}, s1{0.0};
    double r0 = 0.0, r1 = 0.0;
};
struct Tangent {
    glm::dvec2 t0{0.0}, t1{0.0};
    glm::dvec2 normal{0.0};  ///< unit, outward
};
/// Common outer tangent on the right of s0 -> s1; nothing where one circle holds the other.
[[nodiscard]] std::optional<Tangent> outer_tangent(const Circles& circles) noexcept;

/// min over the edge of |p - c(s)| / r(s): both cones, the sheet between them, and the case without a tangent.
[[nodiscard]] double envelope(const glm::dvec2& p, const Circles& circles) noexcept;
/// The paper's sheet, the bilinear patch over edge and tangent, inverted exactly; infinite outside the patch.
[[nodiscard]] double bilinear(const glm::dvec2& p, const Circles& circles) noexcept;
/// Largest error of a sheet cut into n x n pairs of triangles: that of its narrowest row of cells.
[[nodiscard]] double cell_error(double r0, double r1, int n) noexcept;
/// Least n with cell_error < 1/255, at most 32; 1 for equal radii.
[[nodiscard]] int cells_needed(double r0, double r1) noexcept;
/// D(g): how far the bilinear sheet and the cones lie above the envelope at most, g = (r0 - r1) / |s1 - s0|.
[[nodiscard]] double envelope_gap(double g) noexcept;

/// Shape of a light in coordinates of its own plane: the box [-core, core] widened by a disc of `radius`. A disc:
/// core 0, radius 1; a rectangle: core 1, radius 0; a lozenge: core (1, 0), radius its half width.
struct RoundedBox {
    glm::dvec2 core{0.0};
    double radius = 1.0;
};
/// Gauge: the factor by which the shape must grow to reach x.
[[nodiscard]] double gauge(const RoundedBox& shape, const glm::dvec2& x) noexcept;
/// Least gauge over the segment between the homogeneous points a and b (x, y, w), as far as w > 0; infinite if it is
/// nowhere.
[[nodiscard]] double gauge(const RoundedBox& shape, const glm::dvec3& a, const glm::dvec3& b) noexcept;
/// The same for a convex polygon around the origin, counter-clockwise.
[[nodiscard]] double gauge(std::span<const glm::dvec2> corners, const glm::dvec2& x) noexcept;
[[nodiscard]] double gauge(std::span<const glm::dvec2> corners, const glm::dvec3& a, const glm::dvec3& b) noexcept;

/// An ellipse on the plane: the image of a ball, or of a sun.
struct Ellipse {
    double along_m = 0.0;   ///< half axis along the light's azimuth
    double across_m = 0.0;  ///< half axis across it
    double shift_m = 0.0;   ///< of its centre past the projected vertex, away from the light
};
/// @param height_m  of the vertex; @param zenith_rad  theta; @param alpha_rad  half angle of the light as the vertex
/// sees it. @return nothing if the light reaches below the horizon (cos theta <= sin alpha): the image is a hyperbola
[[nodiscard]] std::optional<Ellipse> ball_image(double height_m, double zenith_rad, double alpha_rad) noexcept;
/// Outer tangent on the right of two ellipses x^T Q^-1 x = 1 around c0 and c1, by bisection.
[[nodiscard]] std::optional<Tangent> outer_tangent(const glm::dvec2& c0, const glm::dmat2& q0, const glm::dvec2& c1,
                                                   const glm::dmat2& q1) noexcept;

/// The part of a vertex's cone that its two edges leave visible, as angles in the outer sector, from one edge to the
/// other. Empty (first >= second): nothing of the cone shows.
struct Sector {
    double from_rad = 0.0, to_rad = 0.0;
    [[nodiscard]] bool empty() const noexcept { return from_rad >= to_rad; }
};
/// @param sector_rad    outer angle between the edges, 0 .. 2 pi
/// @param g_a, g_b      (r - r_i) / D_i of the edges to the neighbours
[[nodiscard]] Sector visible_sector(double sector_rad, double g_a, double g_b, double r, double d_a,
                                    double d_b) noexcept;

/// Bilinear patch of section 2.7: (1-v)((1-u) s0 + u s1) + v((1-u) t0 + u t1).
[[nodiscard]] glm::dvec2 patch(const Circles& circles, const Tangent& tangent, double u, double v) noexcept;

/// Overlap area of two circles of radii a and b at distance s (B4).
[[nodiscard]] double lens(double s, double a, double b) noexcept;

}  // namespace penumbra::plateau
