#pragma once

#include <cstdint>
#include <vector>

#include "penumbra/scene.h"
#include "penumbra/view.h"

namespace penumbra {

/// Whether some point of the light lies strictly above the tangent plane of a receiver, and the receiver where the
/// light shines. Exact in float64, per kind, with c the light's centre and r = c - p:
/// - Point, Spot: the sphere's highest point, n.r + radius > 0; Spot besides: p inside the cone, measured as Blender
///   does from the centre in axes stretched by spot_stretch (beyond the full angle its smooth rim is 0)
/// - Sun: its highest direction, n.a > -sin(angle / 2) with a the axis towards the sun
/// - Rectangle: n.r + |n.u| + |n.v| > 0; Ellipse: n.r + sqrt((n.u)^2 + (n.v)^2) > 0; Polygon: its highest corner; and
///   p strictly on the lit side of the light's plane
/// - Line: n.r + |n.u| > 0
/// @param slack_m  what "strictly above" asks for, instead of 0
[[nodiscard]] bool faces_light(const Light& light, const glm::dvec3& position_ws, const glm::dvec3& normal_ws,
                               double slack_m = 0.0) noexcept;

/// The comparison's mask for one light: 1 where a pixel has geometry, its instance receives, and faces_light() holds
/// for its geometric normal; else 0. Whether the light casts shadows makes no difference. Arrays as in View.
/// A light in the receiver's own plane (a lamp flush with its ceiling) is not above it: the slack is a few float32
/// roundings of the View's position and normal, so that such a plane is dark as a whole and not speckled.
[[nodiscard]] std::vector<std::uint8_t> light_mask(const Scene& scene, const View& view, const Light& light);

/// True if a point of the light lies under the plane of what pixel `i` sees, by more than rounding.
[[nodiscard]] bool dips_under(const Light& light, const View& view, std::size_t i) noexcept;

}  // namespace penumbra
