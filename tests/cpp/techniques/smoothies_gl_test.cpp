// Smoothies against the closed forms of the specification (section 3: rows; section 4: singular cases), in float32.
// tau: width of a ramp in texels; filter A deviates from a straight ramp by 1 / (4 tau) at most.
#include "geometry/smoothie.h"
#include "techniques/renderer_fixture.h"

namespace penumbra {
namespace {

using namespace std::string_literals;

Settings with(Settings settings, const Settings& more) {
    for (const auto& [id, value] : more) {
        settings[id] = value;
    }
    return settings;
}

class SmoothiesGl : public RendererGl {
protected:
    static Settings linear(const Settings& more = {}) { return with({{"falloff", "linear"s}}, more); }
    static Settings fixed(double t, const Settings& more = {}) {
        return with(linear({{"width", "fixed"s}, {"t", t}}), more);
    }
    std::vector<float> smoothies(const Scene& scene, const Settings& settings) {
        return visibility(scene, "smoothies", settings);
    }
    /// t_ip of a map fitted to a view from above, half_m across, the light in its middle at height_m.
    static double t_ip(double t, const Scene& scene, double light_m, int map_px = 1024) {
        const Camera& c = scene.camera;
        const double seen = c.half_width_m * (1.0 - 1.0 / c.width_px);  // pixel centres
        return t * seen / light_m * map_px / (map_px - 4.0);
    }
    static double texel_m(const Scene& scene, int map_px = 1024) {
        return 2.0 * scene.camera.half_width_m / (map_px - 4.0);
    }
    /// Largest |profile - clamp((x - edge) / width)|.
    static double deviation(const std::vector<double>& profile, const Camera& camera, double edge_m, double width_m) {
        double worst = 0.0;
        for (int x = 0; x < camera.width_px; ++x) {
            const double at = scenes::column_x(camera, x) - edge_m;
            worst =
                std::max(worst, std::abs(profile[static_cast<std::size_t>(x)] - std::clamp(at / width_m, 0.0, 1.0)));
        }
        return worst;
    }
};

constexpr double kLight_m = 4.0;
constexpr double kSheet_m = 1.0;
constexpr double kDepth_m = kLight_m - kSheet_m;

// Row 1, plain t: W = t k (r - b) wherever the edge lies.
TEST_F(SmoothiesGl, PlainWidthIsTkTimesTheDistanceBehindTheBlocker) {
    for (const double edge_x : {-0.9, -0.3, 0.0, 0.7}) {
        const Scene scene = scenes::straight_edge(scenes::point_light({0, 0, kLight_m}, 0.1), kSheet_m, edge_x, 512);
        const double width = smoothie_width_m(t_ip(0.3, scene, kLight_m), kDepth_m, kLight_m);
        const double tau = width / texel_m(scene);
        const auto v = profile(smoothies(scene, fixed(0.3)), scene.camera);
        EXPECT_LE(deviation(v, scene.camera, edge_x * kLight_m / kDepth_m, width), 0.25 / tau + 2e-3) << edge_x;
    }
}

// Row 1, width of the light: W = R (r - b) / b, for every kind's own half width.
TEST_F(SmoothiesGl, LightsWidthIsTheTrueOuterHalfOfThePenumbra) {
    Light disc = scenes::rectangle_light({0, 0, kLight_m}, 0.8, 1.2);
    disc.kind = LightKind::Ellipse;
    Light line = scenes::rectangle_light({0, 0, kLight_m}, 0.8, 0.0);
    line.kind = LightKind::Line;
    Light triangle = scenes::rectangle_light({0, 0, kLight_m}, 0.8, 0.8);
    triangle.kind = LightKind::Polygon;
    triangle.corners_ws = {{-0.4, -0.6, kLight_m}, {-0.4, 0.6, kLight_m}, {0.8, 0.0, kLight_m}};
    for (const Light& light : {scenes::point_light({0, 0, kLight_m}, 0.4), disc, line, triangle,
                               scenes::rectangle_light({0, 0, kLight_m}, 0.8, 1.2)}) {
        const Scene scene = scenes::straight_edge(light, kSheet_m, 0.0, 512);
        const double width = 0.4 * kSheet_m / kDepth_m;
        const double tau = width / texel_m(scene);
        const auto v = profile(smoothies(scene, linear()), scene.camera);
        EXPECT_LE(deviation(v, scene.camera, 0.0, width), 0.25 / tau + 2e-3) << to_string(light.kind);
    }
}

TEST_F(SmoothiesGl, ASunsWidthIsTheTangentOfHalfItsAngleTimesTheDrop) {
    for (const bool plain : {false, true}) {
        const double slope = plain ? 0.2 : std::tan(0.15);
        const Scene scene = scenes::straight_edge(scenes::sun_light({0, 0, -1}, 0.3), kSheet_m, 0.1, 512);
        const auto v = profile(smoothies(scene, plain ? fixed(0.2) : linear()), scene.camera);
        const double tau = slope / texel_m(scene);
        EXPECT_LE(deviation(v, scene.camera, 0.1, slope * kSheet_m), 0.25 / tau + 2e-3) << plain;
    }
}

// Row 2: an upright edge on a floor. The shadow point at X comes from height y = H (1 - x0 / X): the penumbra opens
// linearly from nothing at the contact.
TEST_F(SmoothiesGl, PenumbraOfAnUprightEdgeOpensFromTheContact) {
    const double x0 = 0.5;
    Scene scene;
    scene.instances.push_back(scenes::place(scenes::sheet(-50, 50, -50, 50), "ground"));
    scene.instances.push_back(scenes::place(
        scenes::mesh("wall", {{x0, 0, 0}, {x0, 40, 0}, {x0, 40, 3.4}, {x0, 0, 3.4}}, {{0, 1, 2}, {0, 2, 3}}), "wall"));
    scene.instances[1].visible = false;
    scene.lights.push_back(scenes::point_light({0, 0, kLight_m}, 0.1));
    scene.camera = scenes::camera_from_above(1.6, 512, 256);
    const std::vector<float> v = smoothies(scene, fixed(0.3));
    const double texel = texel_m(scene);
    double worst = 0.0;
    for (int y = 0; y < 128; ++y) {
        for (int x = 0; x < 512; ++x) {
            const double at = scenes::column_x(scene.camera, x);
            const double out = (y + 0.5) * 3.2 / 512;
            if (at < x0 + 0.05 || at > 1.5) {
                continue;
            }
            const double width = t_ip(0.3, scene, kLight_m) * kLight_m * (1.0 - x0 / at);
            const double expected = std::min(out / width, 1.0);
            worst = std::max(
                worst, std::abs(v[static_cast<std::size_t>((127 - y) * 512 + x)] - expected) - 0.25 * texel / width);
        }
    }
    EXPECT_LE(worst, 4e-3);
}

// Row 3: the same edge over two floors.
TEST_F(SmoothiesGl, TwoReceiversTakeWidthsInProportionToTheirDistances) {
    Scene scene = scenes::straight_edge(scenes::point_light({0, 0, kLight_m}, 0.1), 2.0, 0.0, 512);
    scene.instances.push_back(scenes::place(scenes::sheet(-40, 40, 0, 40), "upper floor", {0, 0, 1.0}));
    scene.camera = scenes::camera_from_above(2.0, 512, 128);
    const std::vector<float> v = smoothies(scene, fixed(0.3));
    const double t = t_ip(0.3, scene, kLight_m);
    const auto row = [&](int y) {
        std::vector<double> values(512);
        for (std::size_t x = 0; x < 512; ++x) {
            values[x] = v[static_cast<std::size_t>(y) * 512 + x];
        }
        return values;
    };
    // The upper floor fills more of the light's picture, so the map is a little wider than the lower floor asks.
    const double wider = 4.0 / 3.0;
    for (const auto& [y, r] : {std::pair{20, 4.0}, std::pair{100, 3.0}}) {
        const double width = smoothie_width_m(t * wider, 2.0, r);
        EXPECT_LE(deviation(row(y), scene.camera, 0.0, width), 0.25 * texel_m(scene) * wider / width + 3e-3) << r;
    }
}

// Row 4: around a corner, lines of equal V are circles about the projected vertex.
TEST_F(SmoothiesGl, ConvexCornersAreRound) {
    for (const double turn : {0.0, 0.5}) {
        Scene scene = scenes::straight_edge(scenes::point_light({0, 0, kLight_m}, 0.6), kSheet_m, 0.0, 256, 0.5);
        scene.instances[1].mesh = scenes::sheet(-20, 0, -20, 0);
        scene.instances[1].world_from_local[0] = {std::cos(turn), std::sin(turn), 0, 0};
        scene.instances[1].world_from_local[1] = {-std::sin(turn), std::cos(turn), 0, 0};
        scene.camera = scenes::camera_from_above(0.5, 256, 256);
        const double width = 0.6 * kSheet_m / kDepth_m;
        const double tau = width / texel_m(scene);
        const std::vector<float> v = smoothies(scene, linear());
        double worst = 0.0;
        for (int y = 0; y < 256; ++y) {
            for (int x = 0; x < 256; ++x) {
                const double wx = scenes::column_x(scene.camera, x), wy = scenes::column_x(scene.camera, y);
                const double px = wx * std::cos(turn) + wy * std::sin(turn);
                const double py = wy * std::cos(turn) - wx * std::sin(turn);
                const double out = std::hypot(std::max(px, 0.0), std::max(py, 0.0));
                worst =
                    std::max(worst, std::abs(v[static_cast<std::size_t>(y * 256 + x)] - std::min(out / width, 1.0)));
            }
        }
        EXPECT_LE(worst, 0.43 / tau + 3e-3) << turn;
    }
}

// A needle's tip turns by nearly 180 degrees: the wedge is split, the rim stays round.
TEST_F(SmoothiesGl, NeedlesHaveRoundTips) {
    Scene scene = scenes::straight_edge(scenes::point_light({0, 0, kLight_m}, 0.6), kSheet_m, 0.0, 256, 0.5);
    scene.instances[1].mesh = scenes::mesh("needle", {{-5, -0.02, 0}, {0, 0, 0}, {-5, 0.02, 0}}, {{0, 1, 2}});
    scene.camera = scenes::camera_from_above(0.5, 256, 256);
    const double width = 0.6 * kSheet_m / kDepth_m;
    const double tau = width / texel_m(scene);
    const std::vector<float> v = smoothies(scene, linear());
    double worst = 0.0;
    for (int y = 0; y < 256; ++y) {
        for (int x = 0; x < 256; ++x) {
            const double px = scenes::column_x(scene.camera, x), py = scenes::column_x(scene.camera, y);
            if (px < 0.0) {
                continue;
            }
            worst = std::max(
                worst, std::abs(v[static_cast<std::size_t>(y * 256 + x)] - std::min(std::hypot(px, py) / width, 1.0)));
        }
    }
    EXPECT_LE(worst, 0.71 / tau + 3e-3);
}

// A concave corner needs no wedge: the nearer edge decides.
TEST_F(SmoothiesGl, ConcaveCornersTakeTheNearerEdge) {
    Scene scene = scenes::straight_edge(scenes::point_light({0, 0, kLight_m}, 0.6), kSheet_m, 0.0, 256, 0.5);
    scene.instances[1].mesh = scenes::mesh("L", {{-9, -9, 0}, {9, -9, 0}, {9, 0, 0}, {0, 0, 0}, {0, 9, 0}, {-9, 9, 0}},
                                           {{0, 1, 2}, {0, 2, 3}, {0, 3, 4}, {0, 4, 5}});
    scene.camera = scenes::camera_from_above(0.5, 256, 256);
    const double width = 0.6 * kSheet_m / kDepth_m;
    const double tau = width / texel_m(scene);
    const std::vector<float> v = smoothies(scene, linear());
    double worst = 0.0;
    for (int y = 0; y < 256; ++y) {
        for (int x = 0; x < 256; ++x) {
            const double px = scenes::column_x(scene.camera, x), py = scenes::column_x(scene.camera, y);
            worst = std::max(worst, std::abs(v[static_cast<std::size_t>(y * 256 + x)] -
                                             std::clamp(std::min(px, py) / width, 0.0, 1.0)));
        }
    }
    EXPECT_LE(worst, 0.36 / tau + 3e-3);
}

// Row 5: without the remap the width is t on the screen everywhere, at a contact as well.
TEST_F(SmoothiesGl, WithoutTheRemapContactsAreAsSoftAsAllElse) {
    for (const double height : {0.01, 1.0, 2.0}) {
        const Scene scene = scenes::straight_edge(scenes::point_light({0, 0, kLight_m}, 0.1), height, 0.0, 512);
        const double width = t_ip(0.2, scene, kLight_m) * kLight_m;
        const auto v = profile(smoothies(scene, fixed(0.2, {{"remap", false}})), scene.camera);
        EXPECT_LE(deviation(v, scene.camera, 0.0, width), 0.25 * texel_m(scene) / width + 3e-3) << height;
        const auto with_remap = profile(smoothies(scene, fixed(0.2)), scene.camera);
        EXPECT_LE(deviation(with_remap, scene.camera, 0.0, width * height / kLight_m),
                  0.25 * texel_m(scene) / (width * height / kLight_m) + 0.75)
            << height;
    }
}

/// Ball, bars and a box on a floor: all that outlines do.
Scene things() {
    Scene scene;
    scene.instances.push_back(scenes::place(scenes::sheet(-20, 20, -20, 20), "ground"));
    scene.instances.push_back(scenes::place(scenes::sphere(16, false), "ball", {0.4, 0.3, 1.2}));
    const auto bar = scenes::box({-0.1F, -0.1F, 0.0F}, {0.1F, 0.1F, 1.5F});
    for (int i = 0; i < 4; ++i) {
        scene.instances.push_back(scenes::place(bar, "bar " + std::to_string(i), {-1.5 + 0.5 * i, -1.0, 0.0}));
    }
    scene.lights.push_back(scenes::point_light({0.3, -0.2, 4.0}, 0.3));
    scene.camera = scenes::camera_from_above(3.0, 192, 144, 20.0);
    const double a = 0.6;
    scene.camera.world_from_camera =
        glm::dmat4{glm::dmat3{{1, 0, 0}, {0, std::cos(a), std::sin(a)}, {0, -std::sin(a), std::cos(a)}}};
    scene.camera.world_from_camera[3] = {0.0, -20 * std::sin(a), 20 * std::cos(a), 1.0};
    return scene;
}

// Row 6.
TEST_F(SmoothiesGl, WiderSmoothiesOnlyDarkenAndUmbraeStay) {
    for (const char* filter : {"bilinear", "published", "nearest"}) {
        const Settings more{{"filter", std::string{filter}}};
        std::vector<float> wider = smoothies(things(), fixed(0.0, more));
        const std::vector<float> hard = wider;
        for (const double t : {0.02, 0.05, 0.1, 0.2, 1.0}) {
            const std::vector<float> v = smoothies(things(), fixed(t, more));
            for (std::size_t i = 0; i < v.size(); ++i) {
                ASSERT_LE(v[i], wider[i] + 1e-5F) << filter << " t " << t;
                ASSERT_FALSE(hard[i] == 0.0F && v[i] != 0.0F);
                if (std::string{filter} == "nearest") {
                    ASSERT_EQ(v[i] == 0.0F, hard[i] == 0.0F) << t;
                }
            }
            wider = v;
        }
    }
}

// Row 7.
TEST_F(SmoothiesGl, OrderOfTrianglesAndObjectsDoesNotMatterToTheBit) {
    Scene scene = things();
    const std::vector<float> v = smoothies(scene, {});
    for (Instance& instance : scene.instances) {
        auto mesh = std::make_shared<Mesh>(*instance.mesh);
        std::reverse(mesh->triangles.begin(), mesh->triangles.end());
        for (std::size_t i = 0; i < mesh->triangles.size(); i += 2) {
            glm::uvec3& t = mesh->triangles[i];
            t = {t.y, t.z, t.x};
        }
        instance.mesh = mesh;
    }
    std::reverse(scene.instances.begin(), scene.instances.end());
    EXPECT_EQ(v, smoothies(scene, {}));
}

// Row 8: two casters at different depths.
TEST_F(SmoothiesGl, OverlapIsTheMinimumOfBoth) {
    Scene both = scenes::straight_edge(scenes::point_light({0, 0, kLight_m}, 0.6), 1.0, -0.1, 256, 1.0);
    both.camera = scenes::camera_from_above(1.0, 256, 256);
    Instance second = scenes::place(scenes::sheet(-20, 20, -20, 0.05), "second", {0, 0, 1.5});
    second.visible = second.receives = false;
    both.instances.push_back(second);
    Scene first_alone = both, second_alone = both;
    first_alone.instances.pop_back();
    second_alone.instances.erase(second_alone.instances.begin() + 1);
    const double tau = 0.6 * 1.0 / 3.0 / texel_m(both);
    const auto v = smoothies(both, linear());
    const auto v1 = smoothies(first_alone, linear());
    const auto v2 = smoothies(second_alone, linear());
    double worst = 0.0;
    for (std::size_t i = 0; i < v.size(); ++i) {
        worst = std::max(worst, std::abs(static_cast<double>(v[i]) - std::min(v1[i], v2[i])));
    }
    EXPECT_LE(worst, 0.5 / tau + 1e-3);
}

TEST_F(SmoothiesGl, PublishedFilterJumpsAtTheUmbraAndBilinearDoesNot) {
    const Scene scene = scenes::straight_edge(scenes::point_light({0, 0, kLight_m}, 0.12), kSheet_m, 0.0, 2048, 0.25);
    const double width = 0.12 * kSheet_m / kDepth_m;
    const double texel = texel_m(scene, 128), tau = width / texel;
    const Settings small{{"map_size", 128}};
    const auto a = profile(smoothies(scene, linear(small)), scene.camera);
    const auto b = profile(smoothies(scene, linear(with(small, {{"filter", "published"s}}))), scene.camera);
    EXPECT_LE(deviation(a, scene.camera, 0.0, width), 0.25 / tau + 3e-3);
    EXPECT_LE(deviation(b, scene.camera, 0.0, width), 1.0 / tau + 3e-3);
    double jump_a = 0.0, jump_b = 0.0, dark_a = 0.0, dark_b = 0.0;
    for (std::size_t x = 1; x < a.size(); ++x) {
        jump_a = std::max(jump_a, std::abs(a[x] - a[x - 1]));
        jump_b = std::max(jump_b, std::abs(b[x] - b[x - 1]));
        dark_a += a[x] == 0.0 ? 0.5 / 2048 : 0.0;
        dark_b += b[x] == 0.0 ? 0.5 / 2048 : 0.0;
    }
    EXPECT_LE(jump_a, 0.02);
    EXPECT_GE(jump_b, 0.3 / tau);
    EXPECT_LE(jump_b, 1.0 / tau + 3e-3);
    EXPECT_LE(dark_b - dark_a, 1.0 * texel + 1e-3);
    EXPECT_GT(dark_b - dark_a, 0.2 * texel);
}

// Section 3: against the truth of a strip light the outer ramp errs as a step does.
TEST_F(SmoothiesGl, ErrorInAStraightPenumbraIsThatOfAStep) {
    const Scene scene = scenes::straight_edge(scenes::rectangle_light({0, 0, 4}, 1, 1), 1.0, 0.0, 1024, 0.5);
    const double width = 1.0 / 3.0;
    const auto error = [&](const char* falloff) {
        const auto v = profile(smoothies(scene, {{"falloff", std::string{falloff}}}), scene.camera);
        double sum = 0.0;
        int count = 0;
        for (int x = 0; x < scene.camera.width_px; ++x) {
            const double truth = 0.5 + scenes::column_x(scene.camera, x) / width;
            if (truth > 0.0 && truth < 1.0) {
                const double e = v[static_cast<std::size_t>(x)] - truth;
                if (falloff[0] == 'l') {
                    EXPECT_LE(e, 2e-3) << "never too light";
                }
                sum += e * e;
                ++count;
            }
        }
        return std::sqrt(sum / count);
    };
    EXPECT_NEAR(error("linear"), 1.0 / std::sqrt(12.0), 0.01);
    EXPECT_NEAR(error("sinusoidal"), 0.3085, 0.01) << "the bent ramp costs a little more against a linear truth";
}

// Section 4.
TEST_F(SmoothiesGl, WithoutWidthItIsTheFilteredHardMapToTheBit) {
    const std::vector<float> soft = visibility(things(), "pcf", {{"filter", "2x2"s}});
    const std::vector<float> hard = visibility(things(), "shadow_map");
    for (const bool keep : {false, true}) {
        EXPECT_EQ(visibility(things(), "smoothies", fixed(0.0, {{"map_size", 1024}}), keep), soft);
        EXPECT_EQ(visibility(things(), "smoothies", fixed(0.0, {{"filter", "nearest"s}}), keep), hard);
    }
    const std::vector<float> published = smoothies(things(), fixed(0.0, {{"filter", "published"s}}));
    for (std::size_t i = 0; i < soft.size(); ++i) {
        ASSERT_EQ(published[i], soft[i] < 1.0F ? 0.0F : 1.0F) << "dark where any of four is shadowed";
    }
}

TEST_F(SmoothiesGl, ALightWithoutExtentThrowsTheHardShadowToTheBit) {
    Scene scene = things();
    Light flat = scenes::rectangle_light({0.3, -0.2, 4.0}, 0.0, 0.0);
    for (const Light& light :
         {scenes::point_light({0.3, -0.2, 4.0}, 0.0), flat, scenes::sun_light({0.2, 0.1, -1}, 0)}) {
        scene.lights[0] = light;
        for (const bool keep : {false, true}) {
            EXPECT_EQ(visibility(scene, "smoothies", {}, keep), visibility(scene, "shadow_map", {}, keep))
                << to_string(light.kind) << keep;
        }
    }
}

TEST_F(SmoothiesGl, TinyAndHugeWidthsStayFiniteAndBetweenZeroAndOne) {
    for (const double t : {1e-300, 1e-30, 1e-7, 1.0, 4.0}) {
        for (const float v : smoothies(things(), fixed(t))) {
            ASSERT_TRUE(v >= 0.0F && v <= 1.0F) << t;
        }
    }
    const auto hard = visibility(things(), "pcf", {{"filter", "2x2"s}});
    EXPECT_EQ(smoothies(things(), fixed(1e-30)), hard) << "narrower than any texel";
}

TEST_F(SmoothiesGl, BothWaysToKeepTheDepthGiveTheSameImage) {
    Scene scene = things();
    Instance ghost = scenes::place(scenes::sheet(-1, 1, -1, 1), "ghost", {-0.7, -1.2, 0.7});
    ghost.casts = false;
    scene.instances.push_back(ghost);
    EXPECT_EQ(smoothies(scene, {}), smoothies(scene, {{"passes", "separate"s}}));
    EXPECT_EQ(smoothies(things(), {{"store_depth", "on"s}}),
              smoothies(things(), {{"store_depth", "on"s}, {"passes", "separate"s}}));
    EXPECT_EQ(smoothies(things(), {}), smoothies(things(), {{"passes", "separate"s}}));
}

/// A straight edge over a floor; the upper half of the picture shows a sheet that receives and does not cast.
Scene with_ghost(double blocker_m, double ghost_m) {
    Scene scene = scenes::straight_edge(scenes::point_light({0, 0, kLight_m}, 0.6), blocker_m, 0.0, 512);
    Instance ghost = scenes::place(scenes::sheet(-40, 40, 0, 40), "ghost", {0, 0, ghost_m});
    ghost.casts = false;
    scene.instances.push_back(ghost);
    scene.camera = scenes::camera_from_above(2.0, 512, 64);
    return scene;
}

std::vector<double> row_of(const std::vector<float>& v, int y) {
    return {v.begin() + 512 * y, v.begin() + 512 * (y + 1)};
}

// Section 2.7: a receiver that does not cast is not in the map of casters. With its own depth the width is right;
// as published it is that of the floor below, too wide by (1 - b/r) / (1 - b/r').
TEST_F(SmoothiesGl, ReceiversThatDoNotCastTakeTheirOwnWidth) {
    const Scene scene = with_ghost(2.0, 1.0);
    const double own = 0.6 * (3.0 - 2.0) / 2.0, published = 0.6 * 3.0 * (1.0 / 2.0 - 1.0 / 4.0);
    const double wider = 4.0 / 3.0;  // the map, since the ghost is nearer to the light
    const double tau = own / (texel_m(scene) * wider);
    const auto cured = row_of(smoothies(scene, linear()), 48);
    const auto plain = row_of(smoothies(scene, linear({{"depth_from", "casters"s}})), 48);
    EXPECT_LE(deviation(cured, scene.camera, 0.0, own), 0.25 / tau + 3e-3);
    EXPECT_LE(deviation(plain, scene.camera, 0.0, published), 0.25 / tau + 3e-3);
    EXPECT_NEAR(published / own, 1.5, 1e-12);
}

// The smoothie's own depth exists for receivers in front of it that the map does not hold.
TEST_F(SmoothiesGl, ReceiversInFrontOfASmoothieStayLit) {
    const Scene scene = with_ghost(1.0, 1.5);
    for (const char* passes : {"merged", "separate"}) {
        for (const char* from : {"receivers", "casters"}) {
            for (const double v :
                 row_of(smoothies(scene, {{"passes", std::string{passes}}, {"depth_from", std::string{from}}}), 48)) {
                ASSERT_EQ(v, 1.0) << passes << " " << from;
            }
        }
    }
    const auto without = row_of(smoothies(scene, {{"store_depth", "off"s}, {"depth_from", "casters"s}}), 48);
    EXPECT_LT(*std::min_element(without.begin(), without.end()), 0.1) << "as published without the smoothie's depth";
}

// Where every receiver casts, the map itself tells what lies in front: the image differs only at steps of depth.
TEST_F(SmoothiesGl, TheMapStandsInForTheSmoothiesDepthWhereEveryReceiverCasts) {
    const auto kept = smoothies(things(), {{"store_depth", "on"s}});
    const auto left_out = smoothies(things(), {});
    EXPECT_LE(share_that_differs(kept, left_out, 1e-6), 0.003);
    EXPECT_LE(rmse(kept, left_out), 0.01);
    const auto published = smoothies(things(), {{"store_depth", "off"s}});
    EXPECT_LE(share_that_differs(kept, published, 1e-6), 0.02);
    EXPECT_GT(rmse(kept, published), rmse(kept, left_out)) << "rims of lit surfaces darken without either";
}

TEST_F(SmoothiesGl, RulesFireWhereTheyShouldAndNowhereElse) {
    const auto fires = [&](const Scene& scene, const std::string& step, const Settings& settings = {}) -> std::string {
        renderer().set_scene(scene);
        const Plan plan = renderer().visibility(0, {"smoothies", settings}, false, control_).plan;
        for (const Step& s : plan.steps) {
            if (s.name == step) {
                EXPECT_TRUE(s.run || !s.reason.empty());
                return s.run ? "runs" : s.rule;
            }
        }
        return "absent";
    };
    Scene scene = scenes::straight_edge(scenes::point_light({0, 0, kLight_m}, 0.6), 1.0);
    EXPECT_EQ(fires(scene, "smoothie buffer"), "runs");
    EXPECT_EQ(fires(scene, "smoothie depth"), "every-receiver-casts");
    EXPECT_EQ(fires(scene, "smoothie buffer", fixed(0.0)), "smoothie-without-width");
    EXPECT_EQ(fires(scene, "silhouettes", fixed(0.1)), "runs");
    scene.instances[0].casts = false;
    EXPECT_EQ(fires(scene, "smoothie depth"), "absent");
    scene.lights[0].radius_m = 0.0;
    EXPECT_EQ(fires(scene, "silhouettes"), "light-without-extent");
    EXPECT_EQ(fires(scene, "smoothie buffer"), "light-without-extent");
    EXPECT_EQ(fires(scene, "smoothie buffer", fixed(0.1)), "runs") << "the plain t does not ask for the light";
}

// Two casters that touch: outer smoothies end on the other's surface, so the seam lets no light through.
TEST_F(SmoothiesGl, TouchingCastersDoNotLeak) {
    Scene scene = scenes::straight_edge(scenes::point_light({0, 0, kLight_m}, 0.6), 1.0, 0.0, 256, 1.0);
    Instance other = scenes::place(scenes::sheet(0, 20, -40, 40), "other", {0, 0, 1.0});
    other.visible = other.receives = false;
    scene.instances.push_back(other);
    for (const float v : smoothies(scene, {})) {
        ASSERT_EQ(v, 0.0F);
    }
}

// A light inside a closed caster sees averted faces only: no silhouettes, and all is dark.
TEST_F(SmoothiesGl, ALightInsideAClosedCasterIsDarkEverywhere) {
    Scene scene = scenes::straight_edge(scenes::point_light({0, 0, kLight_m}, 0.3), 1.0, 0.0, 64);
    scene.instances[1].mesh = scenes::box({-1, -1, 2}, {1, 1, 5});
    for (const float v : smoothies(scene, {})) {
        ASSERT_EQ(v, 0.0F);
    }
}

TEST_F(SmoothiesGl, EdgesBesideAndBehindTheLightHarmNothing) {
    Scene scene = scenes::straight_edge(scenes::point_light({0, 0, 3}, 0.1), 1.0, 0.0, 128, 2.0);
    scene.instances[1] = scenes::place(
        scenes::mesh("wall", {{0.1F, -40, -3}, {0.1F, 40, -3}, {0.1F, 40, 3}, {0.1F, -40, 3}}, {{0, 1, 2}, {0, 2, 3}}),
        "wall", {0, 0, 3});
    scene.instances[1].visible = false;
    for (const char* width : {"light", "fixed"}) {
        const auto v = profile(smoothies(scene, {{"width", std::string{width}}}), scene.camera);
        for (const double value : v) {
            ASSERT_TRUE(value >= 0.0 && value <= 1.0);
        }
        EXPECT_EQ(v[10], 1.0) << width;
        EXPECT_LE(v[120], 1e-3) << width;
    }
}

TEST_F(SmoothiesGl, DegenerateTrianglesAndDoubledEdgesChangeNothing) {
    Scene scene = things();
    const auto plain = smoothies(scene, {});
    for (Instance& instance : scene.instances) {
        auto mesh = std::make_shared<Mesh>(*instance.mesh);
        mesh->triangles.emplace_back(0, 0, 1);
        mesh->triangles.emplace_back(1, 1, 1);
        instance.mesh = mesh;
    }
    scene.instances.push_back(scene.instances[1]);  // a second ball in the same place
    EXPECT_EQ(plain, smoothies(scene, {}));
}

// Without corners, wedges are missing at convex vertices: lit notches there, nowhere darker.
TEST_F(SmoothiesGl, CornersCloseTheGapsAtConvexVertices) {
    Scene scene = scenes::straight_edge(scenes::point_light({0, 0, kLight_m}, 0.6), kSheet_m, 0.0, 128, 0.5);
    scene.instances[1].mesh = scenes::sheet(-20, 0, -20, 0);
    scene.camera = scenes::camera_from_above(0.5, 128, 128);
    const auto fan = smoothies(scene, linear());
    const auto none = smoothies(scene, linear({{"corners", "none"s}}));
    const auto at = [](const std::vector<float>& v, int x, int y) { return v[static_cast<std::size_t>(y * 128 + x)]; };
    EXPECT_NEAR(at(fan, 74, 74), std::hypot(10.5, 10.5) / 128 / 0.2, 0.03);
    EXPECT_EQ(at(none, 74, 74), 1.0F);
    for (std::size_t i = 0; i < fan.size(); ++i) {
        ASSERT_LE(fan[i], none[i] + 1e-6F);
    }
    EXPECT_EQ(fan, smoothies(scene, linear({{"corners", "thesis"s}}))) << "two edges meet here: the thesis' corner too";
}

// Two sheets that touch in one vertex: four silhouettes meet. The thesis' tips cut the circle by their chords.
TEST_F(SmoothiesGl, ThesisTipsCutTheCircleThatFansKeep) {
    Scene scene = scenes::straight_edge(scenes::point_light({0, 0, kLight_m}, 0.6), kSheet_m, 0.0, 256, 0.5);
    scene.instances[1].mesh =
        scenes::mesh("bow tie", {{0, 0, 0}, {-9, 9, 0}, {-9, -9, 0}, {9, -9, 0}, {9, 9, 0}}, {{0, 1, 2}, {0, 3, 4}});
    scene.camera = scenes::camera_from_above(0.5, 256, 256);
    const auto fan = smoothies(scene, linear());
    const auto thesis = smoothies(scene, linear({{"corners", "thesis"s}}));
    for (const auto& v : {fan, thesis}) {
        for (const float value : v) {
            ASSERT_TRUE(value >= 0.0F && value <= 1.0F);
        }
    }
    // Both sheets bound the opening from both sides, so that the edges' own quads decide there.
    EXPECT_LE(rmse(fan, thesis), 0.05);
}

// The proposed variant that widens at vertices only is right where the receiver is flat.
TEST_F(SmoothiesGl, ResizingAtVerticesIsRightOnAFlatReceiver) {
    const Scene scene = scenes::straight_edge(scenes::point_light({0, 0, kLight_m}, 0.6), kSheet_m, 0.0, 256);
    EXPECT_LE(largest_difference(smoothies(scene, linear()), smoothies(scene, linear({{"resize", "vertex"s}}))), 2e-3);
}

// --- Both sides: ours
// -------------------------------------------------------------------------------------------------

double penumbra_rmse(const std::vector<double>& v, const Camera& camera, double width_m, bool disc) {
    double sum = 0.0;
    int count = 0;
    for (int x = 0; x < camera.width_px; ++x) {
        const double u = scenes::column_x(camera, x) / width_m;
        if (std::abs(u) < 1.0) {
            const double truth = falloff(disc ? Falloff::Disc : Falloff::Linear, 0.5 + 0.5 * u);
            sum += (v[static_cast<std::size_t>(x)] - truth) * (v[static_cast<std::size_t>(x)] - truth);
            ++count;
        }
    }
    return std::sqrt(sum / count);
}

TEST_F(SmoothiesGl, BothSidesMakeTheTrueRampOfAStraightEdge) {
    Light disc = scenes::rectangle_light({0, 0, 4}, 1, 1);
    disc.kind = LightKind::Ellipse;
    for (const Light& light : {disc, scenes::rectangle_light({0, 0, 4}, 1, 1), scenes::point_light({0, 0, 4}, 0.5)}) {
        const Scene scene = scenes::straight_edge(light, 1.0, 0.0, 1024, 0.5);
        const bool round = light.kind != LightKind::Rectangle;
        for (const char* filter : {"bilinear", "nearest"}) {
            const auto v =
                profile(smoothies(scene, {{"sides", "both"s}, {"filter", std::string{filter}}}), scene.camera);
            EXPECT_LE(penumbra_rmse(v, scene.camera, 0.5 / 3.0, round), 0.02) << to_string(light.kind) << filter;
        }
    }
    const Scene sun = scenes::straight_edge(scenes::sun_light({0, 0, -1}, 0.3), 1.0, 0.0, 1024, 0.5);
    const auto v = profile(smoothies(sun, {{"sides", "both"s}}), sun.camera);
    EXPECT_LE(penumbra_rmse(v, sun.camera, std::tan(0.15), true), 0.02);
}

TEST_F(SmoothiesGl, BothSidesDoNotLeakWhereCastersTouchOrOverlap) {
    Scene touching = scenes::straight_edge(scenes::point_light({0, 0, kLight_m}, 0.6), 1.0, 0.0, 256, 1.0);
    Instance other = scenes::place(scenes::sheet(0, 20, -40, 40), "other", {0, 0, 1.0});
    other.visible = other.receives = false;
    touching.instances.push_back(other);
    Scene under = touching;  // a small caster in the middle under a large one
    under.instances.back() = scenes::place(scenes::sheet(-20, 20, -40, 40), "large", {0, 0, 2.0});
    under.instances.back().visible = under.instances.back().receives = false;
    for (const Scene& scene : {touching, under}) {
        for (const float v : smoothies(scene, {{"sides", "both"s}})) {
            ASSERT_LE(v, 0.01F);
        }
    }
}

TEST_F(SmoothiesGl, BothSidesKeepZeroSizeAndBounds) {
    for (const float v : smoothies(things(), {{"sides", "both"s}})) {
        ASSERT_TRUE(v >= 0.0F && v <= 1.0F);
    }
    Scene scene = things();
    scene.lights[0].radius_m = 0.0;
    EXPECT_EQ(smoothies(scene, {{"sides", "both"s}}), visibility(scene, "shadow_map"));
    EXPECT_EQ(visibility(things(), "smoothies", {{"sides", "both"s}}, false),
              visibility(things(), "smoothies", {{"sides", "both"s}}, true));
}

}  // namespace
}  // namespace penumbra
