// Soft shadow maps for linear lights on the device: closed forms of linear-light-soft-shadow-maps section 3 and
// singular cases of section 4. The oracle itself is tested in tests/cpp/geometry/linear_light_test.cpp.
#include "techniques/renderer_fixture.h"

namespace penumbra {
namespace {

class LinearLightMapsGl : public RendererGl {
protected:
    static Light line(const glm::dvec3& centre, const glm::dvec3& half) {
        Light light = scenes::rectangle_light(centre, 1.0, 1.0);
        light.kind = LightKind::Line;
        light.half_u_ws = half;
        light.half_v_ws = glm::dvec3{0.0};
        return light;
    }
    static double clamped(double v) { return std::clamp(v, 0.0, 1.0); }

    /// X2: V on the ground under scenes::straight_edge() with a line light of length l at angle psi to the edge.
    static double half_plane(double x, double length, double psi, double light_z, double height, double edge_x) {
        const double e = edge_x * light_z / (light_z - height);
        const double w = 0.5 * length * std::abs(std::sin(psi)) * height / (light_z - height);
        return w > 0.0 ? clamped(0.5 + (x - e) / (2.0 * w)) : (x > e ? 1.0 : 0.0);
    }
};

TEST_F(LinearLightMapsGl, AHalfPlaneUnderALineHasTheClosedFormsRamp) {
    const double length = 1.0;
    for (const double degrees : {90.0, 45.0, 15.0}) {
        const double psi = degrees * scenes::kPi / 180.0;
        const Light light = line({0, 0, 4}, 0.5 * length * glm::dvec3{std::sin(psi), std::cos(psi), 0.0});
        const Scene scene = scenes::straight_edge(light, 1.5, 0.2, 256, 1.0);
        for (const int samples : {2, 3, 5}) {
            const std::vector<float> v = visibility(scene, "linear_light_maps", {{"samples", samples}});
            double worst = 0.0;
            for (int y = 0; y < scene.camera.height_px; ++y) {
                for (int x = 0; x < scene.camera.width_px; ++x) {
                    const double truth = half_plane(scenes::column_x(scene.camera, x), length, psi, 4.0, 1.5, 0.2);
                    worst =
                        std::max(worst, std::abs(truth - v[static_cast<std::size_t>(y * scene.camera.width_px + x)]));
                }
            }
            EXPECT_LT(worst, 0.02) << degrees << " degrees, " << samples << " samples";
        }
    }
}

}  // namespace
}  // namespace penumbra
