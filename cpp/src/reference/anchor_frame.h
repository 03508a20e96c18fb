#pragma once

#include <glm/glm.hpp>

namespace penumbra {

/// The space rays are traced in: world axes, the origin at the middle of the scene, lengths in a power of two near the
/// scene's half size. Coordinates of the geometry then lie within about +-1 whatever the scene's place and scale, and
/// one set of float32 tolerances serves all; the power of two adds no rounding of its own. Suffix: `_an`.
struct AnchorFrame {
    glm::dvec3 origin_ws{0.0};
    double unit_m = 1.0;

    [[nodiscard]] glm::dvec3 point(const glm::dvec3& point_ws) const noexcept {
        return (point_ws - origin_ws) * (1.0 / unit_m);
    }
    [[nodiscard]] glm::dvec3 vector(const glm::dvec3& vector_ws) const noexcept { return vector_ws * (1.0 / unit_m); }
};

}  // namespace penumbra
