#pragma once

#include <glm/glm.hpp>

#include "penumbra/scene.h"

namespace penumbra {

/// Rays through the samples of the pixels, from the eye or side by side: world axes, relative to the eye, and with a
/// depth of 1 along the view for each unit of `along`.
class PixelRays {
public:
    explicit PixelRays(const Camera& camera)
        : right_{camera.world_from_camera[0]},
          up_{camera.world_from_camera[1]},
          forward_{-glm::dvec3{camera.world_from_camera[2]}},
          orthographic_{camera.orthographic} {
        const double aspect = camera.height_px * camera.pixel_aspect / camera.width_px;
        const double half_width = camera.orthographic ? camera.half_width_m : camera.tan_half_width;
        const glm::dvec2 half{half_width, half_width * aspect};
        step_ = 2.0 * half / glm::dvec2{camera.width_px, camera.height_px};
        first_ = -half + step_ * (glm::dvec2{0.5} + camera.pixel_offset) + 2.0 * half_width * camera.shift;
    }
    struct Ray {
        glm::dvec3 origin, along;
    };
    /// Of pixels of one row, whose part of the ray is row().
    [[nodiscard]] Ray at(const glm::dvec3& row, int x) const noexcept {
        const glm::dvec3 place = row + (first_.x + step_.x * x) * right_;
        return orthographic_ ? Ray{place, forward_} : Ray{glm::dvec3{0.0}, place};
    }
    [[nodiscard]] glm::dvec3 row(int y) const noexcept {
        const glm::dvec3 up = (first_.y + step_.y * y) * up_;
        return orthographic_ ? up : up + forward_;
    }

private:
    glm::dvec3 right_, up_, forward_;
    bool orthographic_;
    glm::dvec2 step_{0.0}, first_{0.0};
};

}  // namespace penumbra
