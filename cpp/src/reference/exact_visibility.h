#pragma once

#include <memory>

#include "geometry/boundary_intervals.h"
#include "geometry/light_plane.h"
#include "penumbra/reference.h"
#include "reference/shaft_bvh.h"

namespace penumbra {

/// The exact visibility of one planar light from points one at a time: what exact_visibility() runs in parallel.
/// `plane` and `casters` share one anchor and outlive the object. One object per thread.
class ExactPoint {
public:
    struct Result {
        double area = 1.0;        ///< V, 0 .. 1
        double irradiance = 1.0;  ///< visible over unshadowed irradiance, 0 .. 1; 1 where the unshadowed one is 0
    };

    ExactPoint(const LightPlane& plane, const glm::dvec3& shines_towards, const ShaftBvh& casters);

    /// @param position_m relative to the anchor
    /// @param normal     unit
    /// @param rounding_m how far the position may lie off its own surface by rounding alone
    ///
    /// What blocks: all of a casting triangle that lies strictly between the receiver's plane parallel to the light
    /// and the light's plane (CentralProjection::kSlab), from both sides, except triangles whose plane holds the
    /// point: these would be seen edge on, and the point's own triangle is among them. "Holds" means nearer than
    /// rounding_m plus 64 float64 roundings of the distance to the triangle's corners.
    /// In the light's own plane V is 1; behind the light V is the geometric value and the irradiance ratio 1.
    [[nodiscard]] Result operator()(const glm::dvec3& position_m, const glm::dvec3& normal, double rounding_m);

    /// Triangles that the last call projected to the light.
    [[nodiscard]] std::size_t triangle_count() const noexcept { return boundary_.triangle_count(); }

private:
    /// Visible and unshadowed irradiance per unit radiance of the polygon in boundary_, from `pieces_`.
    [[nodiscard]] double ratio(const CentralProjection& projection, const glm::dvec3& normal) const;

    const LightPlane& plane_;
    glm::dvec3 shines_towards_;
    const ShaftBvh& casters_;
    std::vector<glm::dvec3> corners_m_;
    double radius_m_ = 0.0;  // largest distance of a corner from the plane's origin
    BoundaryIntervals boundary_;
    std::vector<BoundaryPiece> pieces_;
    std::vector<PlaneTriangle> projected_;
};

/// exact_visibility() for an Ellipse light, as ellipse_as_polygon states it: V within 1e-4.
/// @throws InvalidScene if the light is not an Ellipse or has no area
[[nodiscard]] ExactResult nearly_exact_visibility(const Scene& scene, const Light& light,
                                                  std::span<const glm::dvec3> positions_ws,
                                                  std::span<const glm::dvec3> normals_ws, Control& control);

}  // namespace penumbra
