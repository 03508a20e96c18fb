// Two references that share no code below the scene check each other: rays in float32, boundary intervals in float64.
#include "techniques/renderer_fixture.h"

namespace penumbra {
namespace {

class ReferenceAgreement : public RendererGl {
protected:
    struct Outliers {
        std::size_t pixels = 0;
        std::size_t area = 0, irradiance = 0;  ///< farther apart than 4 standard errors
        double largest = 0.0;
    };
    Outliers compare(const Scene& scene, double standard_error) {
        renderer().set_scene(scene);
        const Reference traced = renderer().reference(0, {.standard_error = standard_error}, control_);
        const Reference exact = renderer().reference(0, {.method = ReferenceMethod::Exact}, control_);
        Outliers found;
        for (std::size_t i = 0; i < traced.area.size(); ++i) {
            if (traced.mask[i] == 0) {
                continue;
            }
            ++found.pixels;
            const double a = std::abs(static_cast<double>(traced.area[i]) - exact.area[i]);
            const double e = std::abs(static_cast<double>(traced.irradiance[i]) - exact.irradiance[i]);
            found.area += a > 4.0 * traced.standard_error[i] ? 1 : 0;
            found.irradiance += e > 4.0 * traced.irradiance_standard_error[i] ? 1 : 0;
            found.largest = std::max(found.largest, a);
        }
        return found;
    }
    static Scene still_life(const Light& light, int size_px) {
        Scene scene;
        scene.instances.push_back(scenes::place(scenes::sheet(-20, 20, -20, 20), "ground"));
        scene.instances.push_back(scenes::place(scenes::sphere(16, false), "ball", {0.8, 0.3, 1.2}));
        scene.instances.push_back(
            scenes::place(scenes::box({-0.4F, -0.4F, 0.0F}, {0.4F, 0.4F, 1.5F}), "box", {-1, -0.3, 0}));
        for (int i = 0; i < 6; ++i) {
            scene.instances.push_back(scenes::place(scenes::box({-0.05F, -0.05F, 0.0F}, {0.05F, 0.05F, 1.0F}),
                                                    "bar " + std::to_string(i), {-1.5 + 0.6 * i, -1.6, 0.0}));
        }
        scene.lights.push_back(light);
        const double a = 0.7;
        const glm::dmat4 tilt{
            {1, 0, 0, 0}, {0, std::cos(a), std::sin(a), 0}, {0, -std::sin(a), std::cos(a), 0}, {0, 0, 0, 1}};
        scene.camera.world_from_camera = tilt;
        scene.camera.world_from_camera[3] = tilt * glm::dvec4{0, 0, 9, 1};
        scene.camera.tan_half_width = 0.35;
        scene.camera.width_px = scene.camera.height_px = size_px;
        return scene;
    }
};

TEST_F(ReferenceAgreement, WithinFourStandardErrorsOnARectangleLight) {
    const Outliers found = compare(still_life(scenes::rectangle_light({0.5, -1.0, 5.0}, 1.2, 0.8), 160), 0.004);
    EXPECT_GT(found.pixels, 20000U);
    EXPECT_LE(found.area, found.pixels / 10000) << "largest difference " << found.largest;
    EXPECT_LE(found.irradiance, found.pixels / 10000);
}

TEST_F(ReferenceAgreement, WithinFourStandardErrorsOnATriangularLight) {
    Light light;
    light.name = "triangle";
    light.kind = LightKind::Polygon;
    light.corners_ws = {{-0.5, -1.5, 4.5}, {0.5, 0.0, 5.0}, {1.0, -1.0, 4.5}};
    light.direction_ws = {0, 0, -1};
    const Outliers found = compare(still_life(light, 160), 0.004);
    EXPECT_GT(found.pixels, 20000U);
    EXPECT_LE(found.area, found.pixels / 10000) << "largest difference " << found.largest;
    EXPECT_LE(found.irradiance, found.pixels / 10000);
}

TEST_F(ReferenceAgreement, HoldsFarFromTheOriginAndAtOddScales) {
    const Scene scene = still_life(scenes::rectangle_light({0.5, -1.0, 5.0}, 1.2, 0.8), 64);
    for (const double scale : {1e-3, 1e3}) {
        const Outliers found = compare(scenes::transformed(scene, scale, scenes::odd_turn(), {1e5, -1e5, 1e5}), 0.004);
        EXPECT_LE(found.area, 1U) << scale << " largest difference " << found.largest;
    }
}

TEST_F(ReferenceAgreement, TheExactReferenceRefusesRoundLights) {
    renderer().set_scene(still_life(scenes::point_light({0, 0, 5}, 0.3), 32));
    EXPECT_THROW(static_cast<void>(renderer().reference(0, {.method = ReferenceMethod::Exact}, control_)),
                 InvalidScene);
}

}  // namespace
}  // namespace penumbra
