#pragma once

#include "geometry/planar_receivers.h"
#include "geometry/plateau.h"
#include "gl/glsl_types.h"
#include "penumbra/light.h"

namespace penumbra {

namespace gpu {
#include "shared/plateau_block.h"
#include "shared/plateau_draws.h"
static_assert(sizeof(PlaneDraws) == 128);
static_assert(sizeof(PlateauPlane) == sizeof(vec4) * (12 + PENUMBRA_MAX_PLATEAU_CORNERS));
static_assert(sizeof(PlateauBlock) == 32 + PENUMBRA_MAX_PLANES * sizeof(PlateauPlane));
}  // namespace gpu

/// How the light's shape becomes a penumbra on a plane.
struct PlateauLight {
    enum class Gauge { Disc, RoundedBox, Polygon };  ///< GAUGE of plateau.glsl
    enum class Frame { Parallel, Tilted, Ball };     ///< FRAME of plateau.glsl
    Gauge gauge = Gauge::Disc;
    Frame frame = Frame::Parallel;
};

struct PlateauOptions {
    bool own_shape = true;         ///< false: a disc of the light's area, parallel to the plane
    bool linear_radius = false;    ///< r = k h
    double k = 0.0;                ///< of linear_radius; 0: from the light
    double match = 1.0;            ///< 1 outer, 2 width
    double corner_radius = 0.0;    ///< rectangle: share of its half sides that is rounded
    double lozenge_radius = 0.02;  ///< line: half width over half length
    double least_radius_texels = 0.0;
};

/// Which shader variant serves the light; the same for all planes.
[[nodiscard]] PlateauLight plateau_light(const Light& light, const PlateauOptions& options);

/// The light in plane coordinates; z <= 0: behind the plane.
[[nodiscard]] plateau::PlaneLight light_on(const PlanarReceiver& plane, const Light& light);

/// False if the light stands so low over the plane, or so near to it, that its image is no bounded shape.
[[nodiscard]] bool light_serves(const PlanarReceiver& plane, const Light& light);

/// Everything of the block but `window` and `size`.
/// @param origin_ws  of the pass; @param heights  least and largest height that casts, metres
[[nodiscard]] gpu::PlateauPlane make_plateau_plane(const PlanarReceiver& plane, const Light& light,
                                                   const PlateauOptions& options, const glm::dvec3& origin_ws,
                                                   const glm::dvec2& heights);

}  // namespace penumbra
