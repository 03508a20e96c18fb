#include "geometry/cone_base.h"
#include "techniques/renderer_fixture.h"

namespace penumbra {
namespace {

class PenumbraMapsGl : public RendererGl {
protected:
    static constexpr double kLightHeight = 4.0;

    /// Scene A of the specification: a half plane parallel to the light's disc, kappa = depth of the receiver over
    /// depth of the edge; the view spans 1 1/2 penumbrae.
    static Scene half_plane(double kappa, double radius, int size_px = 256) {
        const double height = kLightHeight * (1.0 - 1.0 / kappa);
        return scenes::straight_edge(scenes::point_light({0, 0, kLightHeight}, radius), height, 0.0, size_px,
                                     1.5 * radius * (kappa - 1.0));
    }
    static double u_of(const Scene& scene, int x, double kappa, double radius) {
        return scenes::column_x(scene.camera, x) / (radius * (kappa - 1.0));
    }
    static double penumbra_rmse(const std::vector<double>& v, const Scene& scene, double kappa, double radius) {
        double sum = 0.0;
        int count = 0;
        for (int x = 0; x < scene.camera.width_px; ++x) {
            const double u = u_of(scene, x, kappa, radius);
            if (std::abs(u) < 1.0) {
                const double difference = v[static_cast<std::size_t>(x)] - disc_fraction(u);
                sum += difference * difference;
                ++count;
            }
        }
        return std::sqrt(sum / count);
    }
};

// T1
TEST_F(PenumbraMapsGl, AStraightEdgeFollowsThePublishedRamp) {
    for (const double kappa : {1.25, 2.0, 4.0}) {
        const double radius = 0.2;
        const Scene scene = half_plane(kappa, radius);
        const double texel_u = 3.0 / 1024.0 * 1.02;
        for (const bool smooth : {true, false}) {
            const std::vector<double> v =
                profile(visibility(scene, "penumbra_maps",
                                   {{"falloff", smooth ? std::string{"smoothstep"} : std::string{"linear"}}}),
                        scene.camera);
            const auto expected = [&](double u) {
                if (u < 0.0) {
                    return 0.0;
                }
                const double intensity = published_intensity(std::min(u, 1.0), kappa);
                return smooth ? smoothstep_falloff(intensity) : intensity;
            };
            for (int x = 0; x < scene.camera.width_px; ++x) {
                const double u = u_of(scene, x, kappa, radius);
                EXPECT_GE(v[static_cast<std::size_t>(x)], expected(u - texel_u) - 2.0 / 255.0) << kappa << " " << u;
                EXPECT_LE(v[static_cast<std::size_t>(x)], expected(u + texel_u) + 2.0 / 255.0) << kappa << " " << u;
            }
        }
    }
}

// T2
TEST_F(PenumbraMapsGl, WithoutExtentItIsTheHardShadowMapBitForBit) {
    for (const char* sides : {"outer", "both"}) {
        const Scene scene = half_plane(2.0, 0.0, 64);
        Scene shown = scene;
        shown.camera = scenes::camera_from_above(1.0, 128, 128);
        EXPECT_EQ(visibility(shown, "penumbra_maps", {{"sides", std::string{sides}}}), visibility(shown, "shadow_map"));
    }
}

TEST_F(PenumbraMapsGl, BothSidesFollowTheAreaOfTheDisc) {
    for (const double kappa : {1.25, 2.0, 4.0}) {
        const double radius = 0.2;
        const Scene scene = half_plane(kappa, radius);
        const double texel_u = 3.0 / 1024.0 * 1.02;
        const std::vector<double> v =
            profile(visibility(scene, "penumbra_maps", {{"sides", std::string{"both"}}}), scene.camera);
        for (int x = 0; x < scene.camera.width_px; ++x) {
            const double u = u_of(scene, x, kappa, radius);
            EXPECT_NEAR(v[static_cast<std::size_t>(x)], disc_fraction(u), 2.0 / 255.0 + texel_u) << kappa << " " << u;
        }
    }
}

// The plainest scene: what the published form cannot do, and the variant can.
TEST_F(PenumbraMapsGl, ErrorInAStraightPenumbraIsThatOfAStepUnlessBothSidesAreDrawn) {
    const Scene scene = half_plane(1.05, 0.5, 512);
    const std::vector<double> outer =
        profile(visibility(scene, "penumbra_maps", {{"falloff", std::string{"linear"}}}), scene.camera);
    EXPECT_NEAR(penumbra_rmse(outer, scene, 1.05, 0.5), 0.289, 0.01);
    const std::vector<double> both =
        profile(visibility(scene, "penumbra_maps", {{"sides", std::string{"both"}}}), scene.camera);
    EXPECT_LT(penumbra_rmse(both, scene, 1.05, 0.5), 0.05);
}

// Casters that touch in the light's view, and one in the shadow of another: their inner edges let no light through.
TEST_F(PenumbraMapsGl, BothSidesDoNotLeakWhereCastersTouchOrOverlap) {
    const auto scene_with = [](std::vector<Instance> casters) {
        Scene scene;
        scene.instances.push_back(scenes::place(scenes::sheet(-20, 20, -20, 20), "ground"));
        for (Instance& caster : casters) {
            caster.visible = false;
            scene.instances.push_back(caster);
        }
        scene.lights.push_back(scenes::point_light({0.05, 0.03, 4}, 0.3));
        scene.camera = scenes::camera_from_above(0.5, 96, 96);
        return scene;
    };
    const auto left = scenes::place(scenes::box({-3, -3, 0.9F}, {0, 3, 1.1F}), "left");
    const auto right = scenes::place(scenes::box({0, -3, 0.9F}, {3, 3, 1.1F}), "right");
    const auto overlapping = scenes::place(scenes::box({-0.5, -3, 0.5F}, {3, 3, 0.7F}), "overlapping");
    const auto roof = scenes::place(scenes::box({-3, -3, 1.9F}, {3, 3, 2.0F}), "roof");
    const auto cube = scenes::place(scenes::box({-0.2F, -0.2F, 0.8F}, {0.2F, 0.2F, 1.0F}), "cube under it");
    for (const auto& casters :
         std::vector<std::vector<Instance>>{{left, right}, {left, overlapping}, {roof, cube}, {left, right, cube}}) {
        for (const float v :
             visibility(scene_with(casters), "penumbra_maps", {{"sides", std::string{"both"}}, {"map_size", 512}})) {
            ASSERT_LE(v, 0.01F) << casters.front().name << " and " << casters.back().name;
        }
    }
}

}  // namespace
}  // namespace penumbra
