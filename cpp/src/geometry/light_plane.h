#pragma once

#include <array>
#include <cstddef>
#include <glm/glm.hpp>
#include <optional>
#include <vector>

#include "penumbra/light.h"

namespace penumbra {

/// A polygonal light in a 2D frame of its own: the point (s, t) is origin_m + s u_m + t v_m, relative to an anchor.
/// The frame is affine, not orthonormal, so that the corners of a parallelogram are exactly (+-1, +-1).
struct LightPlane {
    glm::dvec3 origin_m{0.0};
    glm::dvec3 u_m{0.0};
    glm::dvec3 v_m{0.0};
    std::vector<glm::dvec2> corners;  ///< convex, coordinates in [-1, 1], either direction
};

/// @param anchor_ws where coordinates are small: they are taken relative to it in float64
/// @return nothing if the light is not polygonal (Rectangle, Polygon) or has no area
[[nodiscard]] std::optional<LightPlane> light_plane(const Light& light, const glm::dvec3& anchor_ws);

/// An ellipse light as the regular 256-gon of equal area (affinely mapped). The visible fraction of a disc that a
/// straight edge cuts then errs by less than 1e-4 (measured: 6e-5 at most); boundaries that leave the disc whole or
/// hide it cost nothing.
/// @return nothing if the light is not an Ellipse or has no area
[[nodiscard]] std::optional<LightPlane> ellipse_as_polygon(const Light& light, const glm::dvec3& anchor_ws);

/// A blocking triangle, projected. Clipping can turn one into several.
struct PlaneTriangle {
    std::array<glm::dvec2, 3> corner;
};

/// Central projection of space to the plane of a light, as seen from one receiver point.
class CentralProjection {
public:
    /// Only what lies between these shares of the way from the receiver's parallel plane to the light's plane blocks.
    /// Nearer to the receiver, a projected point has no digits left; at the light, its own mesh must not block it.
    /// The margin is a share of the distance in space, never a bias in the plane.
    static constexpr double kSlab = 1e-9;
    /// What a triangle can become: six planes clip it to a polygon of at most nine corners.
    static constexpr std::size_t kMostParts = 7;

    /// @param receiver_m relative to the same anchor as the plane
    CentralProjection(const LightPlane& plane, const glm::dvec3& receiver_m);

    /// False if the receiver lies in the light's plane (to 1e-12 of the distance) and sees it edge on.
    [[nodiscard]] bool valid() const noexcept { return valid_; }
    /// > 0 if the receiver is on the side that u x v points away from.
    [[nodiscard]] double orientation() const noexcept { return orientation_; }
    /// Receiver to the plane's origin.
    [[nodiscard]] const glm::dvec3& towards_origin() const noexcept { return centre_; }

    /// Projects what lies between receiver and light of the triangle a, b, c and can touch the frame's square
    /// [-1, 1]^2: clipped in homogeneous coordinates, to the slab and to a wider square, before any division.
    /// @param a, b, c relative to the receiver
    /// @return number of triangles written to `out`, coordinates within [-1.75, 1.75]
    std::size_t project(const glm::dvec3& a, const glm::dvec3& b, const glm::dvec3& c,
                        std::array<PlaneTriangle, kMostParts>& out) const;

private:
    [[nodiscard]] glm::dvec3 to_homogeneous(const glm::dvec3& offset) const noexcept;

    glm::dvec3 centre_;   // plane's origin from the receiver
    glm::dvec3 depth_;    // dot with an offset: 0 at the receiver, 1 in the light's plane
    glm::dvec3 along_u_;  // dual basis of the plane
    glm::dvec3 along_v_;
    double orientation_ = 0.0;
    bool valid_ = false;
};

}  // namespace penumbra
