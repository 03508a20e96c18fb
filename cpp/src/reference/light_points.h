#pragma once

#include <array>
#include <glm/glm.hpp>

#include "penumbra/light.h"
#include "reference/anchor_frame.h"
#include "reference/receivers.h"

namespace penumbra {

/// Sample coordinates in [0, 1)^2, one pair per lane.
struct alignas(64) SampleLanes {
    std::array<float, kRayLanes> u, v;
};

/// Points on one light, seen from given receivers, such that V is the plain mean of their visibility:
/// - Point, Spot: uniform in the cone of directions that the sphere subtends, the ray ends on the near surface; a
///   receiver inside the sphere looks in all directions, uniformly; radius 0 is the exact point
/// - Sun: uniform in its cone of directions, the ray has no end
/// - Rectangle, Line: uniform by area and length; Ellipse by the concentric map [Shirley1997]; Polygon as a fan
///   about its first corner, swept by u and filled outwards by v
/// All maps are continuous and keep areas, so that strata of the unit square stay compact strata of the light.
class LightPoints {
public:
    /// Expects a light that validate() has passed.
    LightPoints(const Light& light, const AnchorFrame& frame);

    /// Only u matters: a line light, whose strata are intervals.
    [[nodiscard]] bool one_dimensional() const noexcept { return one_dimensional_; }
    /// All samples are one point or direction: a single ray tells all.
    [[nodiscard]] bool single_point() const noexcept { return single_point_; }

    /// Fills org, dir, tnear and tfar of all lanes. A ray starts off the surface on the side it leaves to, so that a
    /// light point below the receiver's horizon is hidden by real geometry only, and stops just before the light.
    void aim(const ReceiverLanes& receivers, const SampleLanes& samples, RayPacket& rays) const noexcept;

    /// The same, and the factor `weight` by which each sample counts in the irradiance: E is proportional to
    /// mean(weight x visible), with one constant per receiver (scale() tells it). Cosine to the receiver's shading
    /// normal (0 below its horizon); area lights: one-sided cosine at the light over distance^2; line: sine to the line
    /// over distance^2; sphere and sun: nothing more, since directions are uniform. A spot's cone is constant over its
    /// sphere.
    void aim(const ReceiverLanes& receivers, const SampleLanes& samples, RayPacket& rays, float* weight) const noexcept;

    /// E / (L mean(weight x visible)) at a receiver: the area (m^2), length (m) or solid angle (sr), in world units.
    [[nodiscard]] double scale(const glm::dvec3& position_ws) const noexcept;

private:
    template <bool Weighted>
    void aim_lanes(const ReceiverLanes& receivers, const SampleLanes& samples, RayPacket& rays,
                   float* weight) const noexcept;

    static constexpr int kMaxFan = 6;

    Light light_;
    AnchorFrame frame_;
    LightKind kind_;
    bool one_dimensional_ = false;
    bool single_point_ = false;
    glm::vec3 centre_an_{0.0F};  ///< Polygon: first corner
    glm::vec3 direction_{0.0F};  ///< unit, where the light shines
    glm::vec3 half_u_an_{0.0F};
    glm::vec3 half_v_an_{0.0F};
    float radius_squared_an_ = 0.0F;
    float one_minus_cosine_ = 0.0F;              ///< Sun: of half its angle
    glm::vec3 tangent_{0.0F}, bitangent_{0.0F};  ///< Sun: across its axis
    int fan_count_ = 0;
    std::array<glm::vec3, kMaxFan> fan_a_an_{}, fan_b_an_{};    ///< edges of the fan triangles from the first corner
    std::array<float, kMaxFan> fan_begin_{}, fan_per_share_{};  ///< where a triangle's share of u begins, 1 / its size
};

}  // namespace penumbra
