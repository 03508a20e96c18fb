#include "techniques/renderer_fixture.h"

namespace penumbra {
namespace {

class ShadowMapGl : public RendererGl {
protected:
    static constexpr double kAngle = 1.0;  ///< of the sun to the ground's normal, radians

    static Scene slanted_sun_on_ground() {
        Scene scene;
        scene.instances.push_back(scenes::place(scenes::sheet(-50, 50, -50, 50), "ground"));
        scene.lights.push_back(scenes::sun_light({std::sin(kAngle), 0.0, -std::cos(kAngle)}, 0.0));
        scene.camera = scenes::camera_from_above(2.0, 256, 256);
        return scene;
    }
    double dark_share(const Scene& scene, const Settings& settings) {
        const std::vector<float> v = visibility(scene, "shadow_map", settings);
        return static_cast<double>(std::count(v.begin(), v.end(), 0.0F)) / static_cast<double>(v.size());
    }
};

TEST_F(ShadowMapGl, HardEdgeLiesWhereTheCentreOfTheLightPutsIt) {
    for (const double edge_x : {0.0, 0.3, -0.45}) {
        const Scene scene = scenes::straight_edge(scenes::rectangle_light({0, 0, 4}, 1, 1), 1.0, edge_x, 512);
        const std::vector<double> v = profile(visibility(scene, "shadow_map"), scene.camera);
        const double expected = edge_x * 4.0 / 3.0;
        const double texel_m = 4.0 / 1020.0;
        for (int x = 0; x < scene.camera.width_px; ++x) {
            const double at = scenes::column_x(scene.camera, x);
            if (std::abs(at - expected) > texel_m) {
                EXPECT_EQ(v[static_cast<std::size_t>(x)], at > expected ? 1.0 : 0.0) << "x " << at;
            }
        }
    }
}

// A step against the true ramp: what no resolution can cure.
TEST_F(ShadowMapGl, ErrorInAStraightPenumbraIsThatOfAStep) {
    const Scene scene = scenes::straight_edge(scenes::rectangle_light({0, 0, 4}, 1, 1), 1.0, 0.0, 1024, 0.5);
    const std::vector<double> v = profile(visibility(scene, "shadow_map"), scene.camera);
    const double width = 1.0 * 1.0 / 3.0;
    double sum = 0.0;
    int count = 0;
    for (int x = 0; x < scene.camera.width_px; ++x) {
        const double truth = 0.5 + scenes::column_x(scene.camera, x) / width;
        if (truth > 0.0 && truth < 1.0) {
            sum += (v[static_cast<std::size_t>(x)] - truth) * (v[static_cast<std::size_t>(x)] - truth);
            ++count;
        }
    }
    EXPECT_NEAR(std::sqrt(sum / count), 1.0 / std::sqrt(12.0), 0.01);
}

// Closed form (baselines.md section 1): nearest sampling, slope g per texel, bias B: acne share max(0, 1/2 - B/g).
TEST_F(ShadowMapGl, AcneShareFollowsTheClosedForm) {
    const Scene scene = slanted_sun_on_ground();
    EXPECT_NEAR(dark_share(scene, {{"bias", std::string{"none"}}, {"map_size", 128}}), 0.5, 0.03);
    const double slope = std::tan(kAngle);  // depth per texel, in widths of the wider texel side
    for (const double share : {0.4, 0.25, 0.1}) {
        // Texels are not square: the constant is in widths of the wider side, which lies along y here, while the slope
        // runs along x, foreshortened by the cosine.
        const double texel_ratio = std::cos(kAngle);
        const double bias = (0.5 - share) * slope * texel_ratio;
        EXPECT_NEAR(dark_share(scene, {{"bias", std::string{"constant"}}, {"bias_constant", bias}, {"map_size", 128}}),
                    share, 0.04);
    }
}

TEST_F(ShadowMapGl, EveryBiasButNoneKeepsASlantedPlaneFreeOfAcne) {
    const Scene scene = slanted_sun_on_ground();
    for (const char* mode : {"slope", "receiver_plane", "second_depth", "midpoint"}) {
        EXPECT_EQ(dark_share(scene, {{"bias", std::string{mode}}, {"map_size", 128}}), 0.0) << mode;
    }
    // Normal offset moves by texel x sin: enough for the slope along one axis with a factor of 1.
    EXPECT_EQ(dark_share(scene, {{"bias", std::string{"normal_offset"}}, {"map_size", 128}}), 0.0);
    // The constant must exceed half the slope per texel.
    EXPECT_EQ(dark_share(scene, {{"bias", std::string{"constant"}}, {"bias_constant", 1.0}, {"map_size", 128}}), 0.0);
}

TEST_F(ShadowMapGl, SlopeBiasStartsToFailBelowItsClosedForm) {
    const Scene scene = slanted_sun_on_ground();
    EXPECT_GT(dark_share(scene, {{"bias_scale", 0.5}, {"bias_constant", 0.0}, {"map_size", 128}}), 0.15);
}

// Closed form: behind a thin upright sheet the first B sin(angle) of its shadow is lit, B measured along the ray.
TEST_F(ShadowMapGl, BiasDetachesTheShadowByTheClosedForm) {
    Scene scene = slanted_sun_on_ground();
    scene.instances.push_back(scenes::place(
        scenes::mesh("wall", {{0, -20, 0}, {0, 20, 0}, {0, 20, 1}, {0, -20, 1}}, {{0, 1, 2}, {0, 2, 3}}), "wall"));
    scene.camera = scenes::camera_from_above(2.0, 1024, 8);
    const int map_size = 2048;
    const std::vector<float> v = visibility(
        scene, "shadow_map", {{"bias", std::string{"constant"}}, {"bias_constant", 40.0}, {"map_size", map_size}});
    // The map is fitted to the view: 4 m x cos(angle) along the sun's slope, 4 m / 128 across. Its wider texel side:
    const double texel_m = std::max(4.0 * std::cos(kAngle), 4.0 / 128.0) / (map_size - 4.0);
    const double gap_m = 40.0 * texel_m * std::sin(kAngle);
    double lit_m = 0.0;
    for (int x = 0; x < 1024; ++x) {
        const double at = scenes::column_x(scene.camera, x);
        if (at > 0.0 && at < 0.5 * std::tan(kAngle)) {
            lit_m += v[static_cast<std::size_t>(4 * 1024 + x)] * 4.0 / 1024.0;
        }
    }
    EXPECT_NEAR(lit_m, gap_m, 0.01);
}

TEST_F(ShadowMapGl, SecondDepthDrawsOnlyFacesTurnedAway) {
    // The sheet faces up, to the light: left out, so no shadow. Turned over, or mirrored and turned over, it casts.
    Scene scene = scenes::straight_edge(scenes::point_light({0, 0, 4}, 0), 1.0);
    const Settings settings{{"bias", std::string{"second_depth"}}};
    const auto darkest = [&] {
        const std::vector<float> v = visibility(scene, "shadow_map", settings);
        return *std::min_element(v.begin(), v.end());
    };
    EXPECT_EQ(darkest(), 1.0F);
    glm::dmat4& m = scene.instances[1].world_from_local;
    m[2][2] = -1.0;  // mirrored in its own plane: the same triangles, but the normal goes along and points down
    EXPECT_EQ(darkest(), 0.0F);
    m[1] = -m[1];
    m[2][2] = -1.0;  // turned about x: faces down
    EXPECT_EQ(darkest(), 0.0F);
    m[2][2] = 1.0;  // and mirrored besides: up again
    EXPECT_EQ(darkest(), 1.0F);
}

TEST_F(ShadowMapGl, MidpointShadowsBehindAnOpenSheet) {
    const Scene scene = scenes::straight_edge(scenes::point_light({0, 0, 4}, 0), 1.0, 0.0, 256);
    const std::vector<double> v =
        profile(visibility(scene, "shadow_map", {{"bias", std::string{"midpoint"}}}), scene.camera);
    EXPECT_EQ(v[20], 0.0);
    EXPECT_EQ(v[236], 1.0);
}

TEST_F(ShadowMapGl, ACasterAroundTheLightPointStillCasts) {
    // A box with the lamp in its open bottom part: its walls reach above and below the light.
    Scene scene;
    scene.instances.push_back(scenes::place(scenes::sheet(-50, 50, -50, 50), "ground"));
    scene.instances.push_back(
        scenes::place(scenes::mesh("wall", {{-0.02F, -40, -2}, {-0.02F, 40, -2}, {-0.02F, 40, 2}, {-0.02F, -40, 2}},
                                   {{0, 1, 2}, {0, 2, 3}}),
                      "wall", {0, 0, 3}));
    scene.instances[1].visible = false;
    scene.lights.push_back(scenes::point_light({0, 0, 3}, 0));
    scene.camera = scenes::camera_from_above(4.0, 128, 16);
    const std::vector<double> v = profile(visibility(scene, "shadow_map"), scene.camera);
    EXPECT_EQ(v[10], 0.0) << "behind the wall, which passes 2 cm beside the light";
    EXPECT_EQ(v[118], 1.0);
}

TEST_F(ShadowMapGl, CubeFacesServeALampBelowATable) {
    // Receivers all around the lamp, a ring of posts: every direction has its shadow.
    Scene scene;
    scene.instances.push_back(scenes::place(scenes::sheet(-50, 50, -50, 50), "ground"));
    const auto post = scenes::box({-0.1F, -0.1F, 0.0F}, {0.1F, 0.1F, 3.0F});
    for (int i = 0; i < 8; ++i) {
        const double a = scenes::kPi * i / 4.0 + 0.2;
        Instance instance = scenes::place(post, "post", {2.0 * std::cos(a), 2.0 * std::sin(a), 0.0});
        instance.visible = false;
        scene.instances.push_back(instance);
    }
    scene.lights.push_back(scenes::point_light({0, 0, 1}, 0));
    scene.camera = scenes::camera_from_above(8.0, 256, 256);
    const std::vector<float> map = visibility(scene, "shadow_map", {{"map_size", 2048}});
    const std::vector<float> rays = visibility(scene, "ray_traced", {{"rays", 1}});
    EXPECT_LT(share_that_differs(map, rays, 0.5), 0.004);
    EXPECT_GT(static_cast<double>(std::count(map.begin(), map.end(), 0.0F)) / static_cast<double>(map.size()), 0.1);
}

TEST_F(ShadowMapGl, EdgeErrorIsAtMostATexelAtEverySize) {
    // An edge slanted to the map's axes: its staircase stays within one texel diagonal of the true edge.
    for (const int size : {256, 512, 1024}) {
        Scene scene = scenes::straight_edge(scenes::point_light({0, 0, 4}, 0), 1.0, 0.0, 256);
        const double a = 0.4;
        scene.instances[1].world_from_local =
            glm::dmat4{{std::cos(a), std::sin(a), 0, 0}, {-std::sin(a), std::cos(a), 0, 0}, {0, 0, 1, 0}, {0, 0, 1, 1}};
        scene.camera = scenes::camera_from_above(2.0, 256, 256);
        const std::vector<float> v = visibility(scene, "shadow_map", {{"map_size", size}});
        const double texel_m = 4.0 / (size - 4.0);
        double worst = 0.0;
        for (int y = 0; y < 256; ++y) {
            for (int x = 0; x < 256; ++x) {
                const double px = scenes::column_x(scene.camera, x), py = scenes::column_x(scene.camera, y);
                const double from_edge = px * std::cos(a) + py * std::sin(a);
                const bool lit = v[static_cast<std::size_t>(y * 256 + x)] > 0.5F;
                if (lit != (from_edge > 0.0)) {
                    worst = std::max(worst, std::abs(from_edge));
                }
            }
        }
        EXPECT_LE(worst, 0.75 * texel_m) << "map size " << size;  // half a texel along each axis: 0.71 of one
        EXPECT_GT(worst, 0.0) << "no staircase at all would be a wonder";
    }
}

}  // namespace
}  // namespace penumbra
