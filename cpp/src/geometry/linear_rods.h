#pragma once

#include <glm/glm.hpp>
#include <vector>

#include "penumbra/light.h"

namespace penumbra {

/// One linear light that stands for a share of a light: the segment centre +- half. For a sun a segment of directions:
/// centre_ws is the unit direction of travel and half_ws, perpendicular to it, what is added to it at the ends.
struct LinearRod {
    glm::dvec3 centre_ws{0.0};
    glm::dvec3 half_ws{0.0};
    double weight = 1.0;  ///< share of the light's area; all rods of a light add up to 1
};

/// How a light with an area becomes linear lights.
enum class RodLayout {
    Auto,    ///< triangles by their sides, the rest in strips
    Strips,  ///< strips of equal area along the longest axis; each the segment of the strip's own mean and variance
    Sides,   ///< the outline: three sides of weight 1/3 for a triangle [Heidrich2000]; polygons by length of side
};

/// What a round light, which has no axes, is laid out by.
struct RodSurroundings {
    glm::dvec3 towards_ws{0.0};  ///< from the light to what it lights; zero if not known
    glm::dvec3 upright_ws{
        0.0};  ///< direction in which the lit surfaces extend least (a floor's normal); zero if not known
};

/// The linear lights for `light`: lines are themselves, a light without extent is one rod of length zero.
/// Strips: a uniform segment of half length sqrt(3 var) has the variance `var` of the strip along the axis, so that one
/// strip is the best-fitting segment: half a rectangle's longer side, sqrt(3)/2 of an ellipse's longer half axis, of
/// a sphere's radius and of a sun's half angle. A sphere's strips lie in the disc of its outline, a sun's in the disc
/// of its directions, both across the direction in which upright casters have their shadows.
/// @param strips  of lights with an area; 0: one for round lights, 1 .. 4 for the others by their proportions
/// [D: linear-light-soft-shadow-maps 1, 2.11]
[[nodiscard]] std::vector<LinearRod> linear_rods(const Light& light, RodLayout layout, int strips,
                                                 const RodSurroundings& surroundings);

}  // namespace penumbra
