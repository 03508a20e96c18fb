#include <set>

#include "techniques/renderer_fixture.h"

namespace penumbra {
namespace {

class LightSamplesGl : public RendererGl {
protected:
    static Scene edge(int size_px = 256) {
        return scenes::straight_edge(scenes::rectangle_light({0, 0, 4}, 1, 1), 1.0, 0.0, size_px, 0.3);
    }
    /// RMSE of the profile against the true ramp of width 1/3 m.
    double ramp_rmse(const Settings& settings) {
        const Scene scene = edge();
        const std::vector<double> v = profile(visibility(scene, "light_samples", settings), scene.camera);
        double sum = 0.0;
        for (int x = 0; x < scene.camera.width_px; ++x) {
            const double truth = std::clamp(0.5 + 3.0 * scenes::column_x(scene.camera, x), 0.0, 1.0);
            sum += (v[static_cast<std::size_t>(x)] - truth) * (v[static_cast<std::size_t>(x)] - truth);
        }
        return std::sqrt(sum / scene.camera.width_px);
    }
};

TEST_F(LightSamplesGl, TakesOnlyMultiplesOfOneOverN) {
    for (const float v : visibility(edge(), "light_samples", {{"samples", 9}})) {
        EXPECT_NEAR(v * 9.0F, std::round(v * 9.0F), 1e-5);
    }
}

// Wrong by construction: an edge along the grid sees root N columns of samples.
TEST_F(LightSamplesGl, AGridTakesOnlyRootNPlusOneValuesAtAnAlignedEdge) {
    std::set<long> values;
    for (const float v : visibility(edge(), "light_samples", {{"samples", 64}, {"pattern", std::string{"grid"}}})) {
        values.insert(std::lround(v * 64.0F));
    }
    EXPECT_EQ(values.size(), 9U);
    const double error = ramp_rmse({{"samples", 64}, {"pattern", std::string{"grid"}}});
    EXPECT_LE(error, 1.0 / 16.0);  // closed form: at most 1/(2 n) for n = 8
}

TEST_F(LightSamplesGl, TendsToTheTrueRampAsNGrows) {
    std::vector<double> errors;
    for (const int n : {4, 16, 64, 256}) {
        errors.push_back(ramp_rmse({{"samples", n}, {"map_size", 2048}, {"memory_mib", 0}}));
    }
    // Jittered along one axis only matters here: n columns of n points each, so about N^-3/4; allow for luck of a seed.
    EXPECT_LT(errors[3], 0.2 * errors[0]);
    EXPECT_LT(errors[3], 0.012);
    EXPECT_LT(errors[1], errors[0]);
    EXPECT_LT(errors[2], errors[1]);
}

TEST_F(LightSamplesGl, TendsToTheReferenceForEveryKindOfLight) {
    std::vector<Light> lights{scenes::rectangle_light({0.1, 0.2, 4}, 1, 0.5), scenes::point_light({0.1, 0.2, 4}, 0.5),
                              scenes::sun_light({0.1, 0.2, -1}, 0.2)};
    lights.push_back(lights[0]);
    lights.back().kind = LightKind::Ellipse;
    lights.push_back(lights[0]);
    lights.back().kind = LightKind::Line;
    lights.back().half_v_ws = glm::dvec3{0.0};
    for (const Light& light : lights) {
        Scene scene = scenes::straight_edge(light, 1.0, 0.0, 128, 1.0);
        renderer().set_scene(scene);
        const Reference truth = renderer().reference(0, {.standard_error = 0.005}, control_);
        double last = 1.0;
        for (const int n : {16, 256}) {
            const std::vector<float> v =
                renderer()
                    .visibility(0, {"light_samples", {{"samples", n}, {"map_size", 1024}, {"memory_mib", 0}}}, false,
                                control_)
                    .visibility;
            const double error = rmse(v, truth.area);
            EXPECT_LT(error, last) << to_string(light.kind) << " " << n;
            last = error;
        }
        EXPECT_LT(last, 0.012) << to_string(light.kind);
    }
}

// Two crossed half planes at different heights: fusion of occluders, where maximum or product of two penumbrae fails.
TEST_F(LightSamplesGl, OccludersFuseAsInTheReference) {
    Scene scene = scenes::straight_edge(scenes::rectangle_light({0, 0, 4}, 1, 1), 1.0, 0.0, 96, 0.6);
    Instance second = scenes::place(scenes::sheet(-20, 20, -20, 0), "second", {0, 0, 2});
    second.visible = second.receives = false;
    scene.instances.push_back(second);
    scene.camera = scenes::camera_from_above(0.6, 96, 96);
    renderer().set_scene(scene);
    const Reference truth = renderer().reference(0, {.standard_error = 0.005}, control_);
    const std::vector<float> v =
        renderer().visibility(0, {"light_samples", {{"samples", 256}, {"memory_mib", 0}}}, false, control_).visibility;
    EXPECT_LT(rmse(v, truth.area), 0.02);
}

TEST_F(LightSamplesGl, KeepingTheMapsOrNotGivesTheSameImage) {
    const Scene scene = edge();
    EXPECT_EQ(visibility(scene, "light_samples", {{"memory_mib", 512}}),
              visibility(scene, "light_samples", {{"memory_mib", 0}}));
}

TEST_F(LightSamplesGl, APointLightGivesTheHardShadowBitForBit) {
    const Scene scene = scenes::straight_edge(scenes::point_light({0, 0, 4}, 0.0), 1.0, 0.1, 256);
    EXPECT_EQ(visibility(scene, "light_samples"), visibility(scene, "shadow_map"));
}

TEST_F(LightSamplesGl, SeedsMoveTheJitter) {
    const Scene scene = edge();
    EXPECT_NE(visibility(scene, "light_samples", {{"seed", 1}}), visibility(scene, "light_samples", {{"seed", 2}}));
    EXPECT_EQ(visibility(scene, "light_samples", {{"seed", 2}}), visibility(scene, "light_samples", {{"seed", 2}}));
}

}  // namespace
}  // namespace penumbra
