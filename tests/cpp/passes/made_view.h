#pragma once

#include "penumbra/scene.h"
#include "penumbra/view.h"

namespace penumbra {

/// The view of a flat ground z = 0 from above, made by hand: what ViewPass gives for camera_from_above().
inline View view_of_ground(const Camera& camera, std::int32_t ground_instance = 0) {
    View view;
    view.width = camera.width_px;
    view.height = camera.height_px;
    view.eye_ws = glm::dvec3{camera.world_from_camera[3]};
    const double aspect = static_cast<double>(camera.height_px) / camera.width_px;
    for (int y = 0; y < view.height; ++y) {
        for (int x = 0; x < view.width; ++x) {
            const glm::dvec3 p{view.eye_ws.x + camera.half_width_m * (2.0 * (x + 0.5) / view.width - 1.0),
                               view.eye_ws.y + camera.half_width_m * aspect * (2.0 * (y + 0.5) / view.height - 1.0),
                               0.0};
            view.position_cr.emplace_back(p - view.eye_ws);
            view.normal_ws.emplace_back(0.0F, 0.0F, 1.0F);
            view.shading_normal_ws.emplace_back(0.0F, 0.0F, 1.0F);
            view.albedo.emplace_back(0.8F);
            view.instance.push_back(ground_instance);
            view.triangle.push_back(0);
        }
    }
    return view;
}

}  // namespace penumbra
