#include "geometry/light_block.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "geometry/irradiance.h"
#include "geometry/light_shape.h"
#include "geometry/radiometry.h"

namespace penumbra {

namespace {

glm::vec4 pack(const glm::dvec3& xyz, double w) {
    return glm::vec4{glm::vec3{xyz}, static_cast<float>(w)};
}

}  // namespace

gpu::LightBlock light_block(const Light& light, const glm::dvec3& eye_ws) {
    const LightForm form = form_of(light);
    gpu::LightBlock block{};
    block.centre_cr = pack(light.kind == LightKind::Sun ? glm::dvec3{0.0} : light.position_ws - eye_ws, light.radius_m);
    block.emission_form = pack(emission(light), static_cast<double>(form));
    block.spot.x = -2.0F;

    glm::dvec3 u = light.half_u_ws;
    glm::dvec3 v = light.half_v_ws;
    double u_w = 0.0;
    double v_w = 0.0;
    if (form == LightForm::Ellipse) {
        principal_axes(u, v);
    } else if (form == LightForm::FacingLine) {
        u = longest_half_axis(light);
    } else if (form == LightForm::Sun) {
        u_w = std::sin(0.5 * light.sun_angle_rad);
        v_w = std::cos(0.5 * light.sun_angle_rad);
    }
    if (light.kind == LightKind::Spot) {
        block.spot = {static_cast<float>(std::cos(0.5 * light.spot_angle_rad)), static_cast<float>(light.spot_blend),
                      static_cast<float>(light.spot_stretch.x), static_cast<float>(light.spot_stretch.y)};
    }
    block.half_u = pack(u, u_w);
    block.half_v = pack(v, v_w);

    std::size_t corners = 0;
    if (form == LightForm::Polygon && light.kind == LightKind::Rectangle) {
        // Counter-clockwise seen from the side that it shines to.
        const bool turned = glm::dot(glm::cross(u, v), light.direction_ws) < 0.0;
        const std::array offsets{-u - v, turned ? v - u : u - v, u + v, turned ? u - v : v - u};
        for (const glm::dvec3& offset : offsets) {
            block.corner[corners++] = pack(offset, 0.0);
        }
    } else if (form == LightForm::Polygon) {
        corners = std::min<std::size_t>(light.corners_ws.size(), PENUMBRA_MAX_LIGHT_CORNERS);
        const glm::dvec3& first = light.corners_ws[0];
        glm::dvec3 area{0.0};
        for (std::size_t i = 2; i < corners; ++i) {
            area += glm::cross(light.corners_ws[i - 1] - first, light.corners_ws[i] - first);
        }
        const bool turned = glm::dot(area, light.direction_ws) < 0.0;
        for (std::size_t i = 0; i < corners; ++i) {
            block.corner[i] = pack(light.corners_ws[turned ? corners - 1 - i : i] - light.position_ws, 0.0);
        }
    }
    block.direction = pack(light.direction_ws, static_cast<double>(corners));
    return block;
}

}  // namespace penumbra
