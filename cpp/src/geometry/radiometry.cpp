#include "geometry/radiometry.h"

#include <cmath>
#include <numbers>

#include "geometry/light_shape.h"

namespace penumbra {

glm::dvec3 emission(const Light& light) {
    constexpr double kPi = std::numbers::pi;
    switch (form_of(light)) {
        case LightForm::None:
            break;
        case LightForm::Point:
            return light.power_w / (4.0 * kPi);
        case LightForm::FacingPoint:
            return light.power_w / kPi;
        case LightForm::Direction:
            return light.power_w;
        case LightForm::Sun: {
            const double sine = std::sin(0.5 * light.sun_angle_rad);
            return light.power_w / (kPi * sine * sine);
        }
        case LightForm::Line:
            return light.power_w / (kPi * kPi * 2.0 * glm::length(light.half_u_ws));
        case LightForm::FacingLine:
            return light.power_w / (kPi * 2.0 * glm::length(longest_half_axis(light)));
        case LightForm::Sphere:
        case LightForm::Ellipse:
        case LightForm::Polygon:
            return light.power_w / (kPi * emitting_area(light));
    }
    return glm::dvec3{0.0};
}

glm::dvec3 unshadowed_irradiance(const Light& light, const glm::dvec3& p_ws, const glm::dvec3& n_ws) {
    const double factor = irradiance_per_radiance(light, p_ws, n_ws) * spot_attenuation(light, p_ws);
    return factor > 0.0 ? emission(light) * factor : glm::dvec3{0.0};
}

}  // namespace penumbra
