#include "geometry/cone_base.h"
#include "techniques/renderer_fixture.h"

namespace penumbra {
namespace {

class PenumbraMapsGl : public RendererGl {
protected:
    static double value_of(const VisibilityResult& result, const std::string& id) {
        for (const Statistic& statistic : result.statistics) {
            if (statistic.id == id) {
                return statistic.value;
            }
        }
        ADD_FAILURE() << "no statistic " << id;
        return 0.0;
    }
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

/// Checks one row of pixels against a closed form in world x, within a texel and 2/255.
class PenumbraMapsScenes : public PenumbraMapsGl {
protected:
    static constexpr double kRadius = 0.2;

    static Instance hidden(std::shared_ptr<const Mesh> mesh, const std::string& name, const glm::dvec3& at = {}) {
        Instance instance = scenes::place(std::move(mesh), name, at);
        instance.visible = false;
        return instance;
    }
    /// Light at height 4 over the ground, looked at straight from above; casters are not seen.
    static Scene over_ground(std::vector<Instance> casters, double half_m, int width_px, int height_px,
                             double radius = kRadius) {
        Scene scene;
        scene.instances.push_back(scenes::place(scenes::sheet(-50, 50, -50, 50), "ground"));
        for (Instance& caster : casters) {
            scene.instances.push_back(std::move(caster));
        }
        scene.lights.push_back(scenes::point_light({0, 0, kLightHeight}, radius));
        scene.camera = scenes::camera_from_above(half_m, width_px, height_px);
        return scene;
    }
    static std::shared_ptr<Mesh> disc(double radius, int sides) {
        std::vector<glm::vec3> points{{0, 0, 0}};
        std::vector<glm::uvec3> triangles;
        for (unsigned i = 0; i < static_cast<unsigned>(sides); ++i) {
            const double angle = 2.0 * scenes::kPi * i / sides;
            points.emplace_back(radius * std::cos(angle), radius * std::sin(angle), 0.0);
            triangles.emplace_back(0, 1 + i, 1 + (i + 1) % static_cast<unsigned>(sides));
        }
        return scenes::mesh("disc", points, triangles);
    }
    static std::shared_ptr<Mesh> ring(double inner, double outer, int sides) {
        std::vector<glm::vec3> points;
        std::vector<glm::uvec3> triangles;
        const auto n = static_cast<unsigned>(sides);
        for (unsigned i = 0; i < n; ++i) {
            const double angle = 2.0 * scenes::kPi * i / sides;
            for (const double r : {inner, outer}) {
                points.emplace_back(r * std::cos(angle), r * std::sin(angle), 0.0);
            }
            triangles.emplace_back(2 * i, 2 * i + 1, (2 * i + 3) % (2 * n));
            triangles.emplace_back(2 * i, (2 * i + 3) % (2 * n), (2 * i + 2) % (2 * n));
        }
        return scenes::mesh("ring", points, triangles);
    }
    /// M of one straight edge at depth `edge` above the ground at depth 4; x beyond its hard edge on the ground.
    static double outer_ramp(double x, double edge, double radius = kRadius) {
        const double width = radius * (kLightHeight - edge) / edge;
        return x <= 0.0 ? 0.0 : smoothstep_falloff(published_intensity(std::min(1.0, x / width), kLightHeight / edge));
    }
    template <class Expected>
    static void expect_row(const std::vector<float>& v, const Scene& scene, int row, double slack_m,
                           const Expected& expected) {
        const Camera& camera = scene.camera;
        for (int x = 0; x < camera.width_px; ++x) {
            const double at = scenes::column_x(camera, x);
            const double value = v[static_cast<std::size_t>(row * camera.width_px + x)];
            double low = 1.0, high = 0.0;
            for (const double offset : {-slack_m, 0.0, slack_m}) {
                low = std::min(low, expected(at + offset));
                high = std::max(high, expected(at + offset));
            }
            EXPECT_GE(value, low - 2.0 / 255.0) << "x " << at;
            EXPECT_LE(value, high + 2.0 / 255.0) << "x " << at;
        }
    }
};

// T3
TEST_F(PenumbraMapsScenes, APenumbraUnderHalfATexelIsLeftOutAndChangesNothing) {
    const Scene scene = over_ground({hidden(disc(0.5, 64), "disc", {0.1, 0, 1})}, 1.5, 128, 128, 1e-6);
    renderer().set_scene(scene);
    const VisibilityResult planned = renderer().visibility(0, {"penumbra_maps", {}}, false, control_);
    EXPECT_FALSE(planned.plan.runs("penumbra map"));
    EXPECT_TRUE(std::ranges::any_of(planned.plan.steps, [](const Step& step) {
        return step.name == "penumbra map" && step.rule == "penumbra-under-half-a-texel";
    }));
    EXPECT_EQ(planned.visibility, visibility(scene, "penumbra_maps", {}, true));
    EXPECT_EQ(planned.visibility, visibility(scene, "shadow_map"));
    const Scene wide = over_ground({hidden(disc(0.5, 64), "disc", {0.1, 0, 1})}, 1.5, 128, 128, 0.1);
    renderer().set_scene(wide);
    EXPECT_TRUE(renderer().visibility(0, {"penumbra_maps", {}}, false, control_).plan.runs("penumbra map"));
}

// T4, scene B: the umbra of a small occluder vanishes, the method's does not: wrong by up to -1 in the middle.
TEST_F(PenumbraMapsScenes, ADiscOccluderHasThePublishedRampAroundAFullUmbra) {
    const double edge = 2.0;
    for (const double a : {0.05, 0.4}) {
        const Scene scene = over_ground({hidden(disc(a, 256), "disc", {0, 0, kLightHeight - edge})}, 1.2, 257, 9);
        const std::vector<float> v = visibility(scene, "penumbra_maps");
        const double hard = a * kLightHeight / edge;
        // The polygon's flats lie a (1 - cos(pi/256)) inside.
        expect_row(v, scene, 4, 2.4 / 1000.0 + 2e-4 * hard,
                   [&](double x) { return outer_ramp(std::abs(x) - hard, edge); });
    }
}

// T5, scene H: a round hole is too bright, S(I(u)) against u^2.
TEST_F(PenumbraMapsScenes, ARoundHoleShowsItsRimsRampInTheMiddle) {
    const double edge = 2.0;
    double largest = 0.0;
    for (const double u : {0.3, 0.5, 2.0 / 3.0, 0.8, 0.95}) {
        const double hole = u * kRadius * (kLightHeight - edge) / kLightHeight;
        const Scene scene =
            over_ground({hidden(ring(hole, 30.0, 256), "holed", {0, 0, kLightHeight - edge})}, 0.02, 9, 9);
        const std::vector<float> v = visibility(scene, "penumbra_maps");
        const double expected = smoothstep_falloff(published_intensity(u, kLightHeight / edge));
        EXPECT_NEAR(v[40], expected, 0.01) << u;
        largest = std::max(largest, v[40] - u * u);
    }
    EXPECT_NEAR(largest, 0.109, 0.015);
}

// T6, scenes E and F
TEST_F(PenumbraMapsScenes, NestedAndOpposedEdgesTakeTheDarker) {
    const auto left = [](double edge_x) { return scenes::sheet(edge_x - 20.0, edge_x, -40, 40); };
    const auto right = [](double edge_x) { return scenes::sheet(edge_x, edge_x + 20.0, -40, 40); };
    const double slack = 1.2 / 1000.0;
    const Scene nested =
        over_ground({hidden(left(0.0), "high", {0, 0, 2}), hidden(left(0.02), "low", {0, 0, 1})}, 0.5, 256, 9);
    expect_row(visibility(nested, "penumbra_maps"), nested, 4, slack,
               [&](double x) { return std::min(outer_ramp(x, 2.0), outer_ramp(x - 0.02 * 4.0 / 3.0, 3.0)); });
    const Scene slit =
        over_ground({hidden(left(-0.06), "left", {0, 0, 2}), hidden(right(0.06), "right", {0, 0, 2})}, 0.5, 256, 9);
    expect_row(visibility(slit, "penumbra_maps"), slit, 4, slack,
               [&](double x) { return std::min(outer_ramp(x + 0.12, 2.0), outer_ramp(0.12 - x, 2.0)); });
}

// T7, scene G: min of the two ramps where a true corner has their product.
TEST_F(PenumbraMapsScenes, AConcaveCornerTakesTheDarkerOfItsSides) {
    auto mesh = scenes::mesh("corner", {{-20, -20, 0}, {20, -20, 0}, {20, 0, 0}, {0, 0, 0}, {0, 20, 0}, {-20, 20, 0}},
                             {{0, 1, 2}, {0, 2, 3}, {0, 3, 5}, {3, 4, 5}});
    const Scene scene = over_ground({hidden(mesh, "corner", {0, 0, 2})}, 0.3, 65, 65);
    const std::vector<float> v = visibility(scene, "penumbra_maps");
    for (const int row : {34, 40, 50, 60}) {
        const double y = scene.camera.half_width_m * (2.0 * (row + 0.5) / 65.0 - 1.0);
        expect_row(v, scene, row, 1.5 / 1000.0,
                   [&](double x) { return std::min(outer_ramp(x, 2.0), outer_ramp(y, 2.0)); });
    }
}

// T7, scene I: the outline of a sphere is taken from the light's centre, so its penumbra comes out a little narrow.
TEST_F(PenumbraMapsScenes, ASpherePenumbraIsNarrowByTheTableOfTheSpecification) {
    // D = 5, R = 1, Zp = 8, scaled by 1/2 to the light's height of 4.
    const double depth = 2.5, ball = 0.5, radius = 0.25;
    Instance sphere = hidden(scenes::sphere(96, false), "sphere");
    sphere.world_from_local = glm::dmat4{ball};
    sphere.world_from_local[3] = glm::dvec4{0, 0, kLightHeight - depth, 1};
    const Scene scene = over_ground({sphere}, 1.6, 513, 9, radius);
    const std::vector<float> v = visibility(scene, "penumbra_maps", {{"falloff", std::string{"linear"}}});
    const double edge = depth - ball * ball / depth;
    const double hard = ball * std::sqrt(1.0 - ball * ball / (depth * depth)) * kLightHeight / edge;
    const double width = radius * (kLightHeight - edge) / edge;
    double rim = 0.0;
    for (int x = 0; x < 513; ++x) {
        if (v[static_cast<std::size_t>(4 * 513 + x)] < 1.0F - 1e-3F) {
            rim = std::max(rim, std::abs(scenes::column_x(scene.camera, x)));
        }
    }
    EXPECT_NEAR(rim, hard + width, 3.2 / 512.0 + 0.002);
    const double slope = std::atan(radius / depth) + std::asin(ball / std::sqrt(radius * radius + depth * depth));
    const double truth = kLightHeight * std::tan(slope) - radius;
    EXPECT_NEAR((truth - hard - width) / (truth - hard), 0.025, 0.002);
}

// T8 and issue 4: the published construction against the exact one on a tilted open plate.
TEST_F(PenumbraMapsScenes, LiteralAndExactAgreeWithinTheBoundOfTheSpecification) {
    auto plate =
        scenes::mesh("plate", {{-0.5F, -0.5F, 1.2F}, {0.4F, -0.4F, 2.4F}, {0.5F, 0.4F, 2.3F}, {-0.4F, 0.5F, 1.0F}},
                     {{0, 1, 2}, {0, 2, 3}});
    const Scene scene = over_ground({hidden(plate, "plate")}, 2.0, 192, 192);
    const std::vector<float> exact = visibility(scene, "penumbra_maps", {{"trim_cones", false}});
    const auto percentile = [&](const Settings& settings) {
        const std::vector<float> v = visibility(scene, "penumbra_maps", settings);
        std::vector<double> differences(v.size());
        for (std::size_t i = 0; i < v.size(); ++i) {
            differences[i] = std::abs(static_cast<double>(v[i]) - exact[i]);
        }
        const auto at = differences.begin() + static_cast<std::ptrdiff_t>(0.999 * static_cast<double>(v.size()));
        std::ranges::nth_element(differences, at);
        return *at;
    };
    const auto literal = [](int parts) {
        return Settings{{"mode", std::string{"literal"}}, {"facets", 64}, {"sheet_parts", parts}};
    };
    EXPECT_LE(percentile(literal(1)), 0.15);
    EXPECT_LE(percentile(literal(8)), 0.03);
    EXPECT_LE(percentile(literal(32)), 0.012);
    // A full cone is darker than the sheet by at most t - u.
    EXPECT_LE(percentile({}), 0.02);
}

// T9
TEST_F(PenumbraMapsScenes, DepthTestAndMinimumKeepTheSameBits) {
    const Scene scene = over_ground({hidden(scenes::sphere(12, false), "ball", {0.2, 0.1, 1.5}),
                                     hidden(scenes::box({-0.9F, -0.4F, 0.3F}, {-0.4F, 0.5F, 0.9F}), "box")},
                                    2.0, 160, 160);
    for (const char* mode : {"exact", "literal"}) {
        for (const char* ramp : {"depth", "image", "exact"}) {
            const auto with = [&](const char* combine) {
                return visibility(
                    scene, "penumbra_maps",
                    {{"mode", std::string{mode}}, {"ramp", std::string{ramp}}, {"combine", std::string{combine}}});
            };
            EXPECT_EQ(with("minimum"), with("depth_test")) << mode << " " << ramp;
        }
    }
}

// T10, property 3: what the method darkens is darker in truth as well, up to a rim narrower than the light samples.
TEST_F(PenumbraMapsScenes, NothingFullyLitIsDarkened) {
    const Scene scene = over_ground({hidden(scenes::sphere(24, false), "ball", {0.3, 0.2, 1.5}),
                                     hidden(scenes::box({-0.9F, -0.4F, 0.3F}, {-0.4F, 0.5F, 0.9F}), "box")},
                                    1.6, 96, 96);
    const std::vector<float> m =
        visibility(scene, "penumbra_maps",
                   {{"falloff", std::string{"linear"}}, {"ramp", std::string{"image"}}, {"map_size", 2048}});
    renderer().set_scene(scene);
    const Reference truth = renderer().reference(0, {.standard_error = 0.002}, control_);
    int darkened = 0;
    for (std::size_t i = 0; i < m.size(); ++i) {
        if (m[i] < 0.85F) {
            ++darkened;
            EXPECT_LT(truth.area[i], 1.0F) << i << " M " << m[i];
        }
    }
    EXPECT_GT(darkened, 500);
}

TEST_F(PenumbraMapsScenes, TheOrderOfTrianglesChangesNothing) {
    const auto ball = scenes::sphere(14, false);
    auto shuffled = std::make_shared<Mesh>(*ball);
    for (std::size_t i = 0; i < shuffled->triangles.size(); ++i) {
        std::swap(shuffled->triangles[i], shuffled->triangles[(i * 7919) % shuffled->triangles.size()]);
        const glm::uvec3 t = shuffled->triangles[i];
        shuffled->triangles[i] = {t.y, t.z, t.x};
    }
    for (const char* sides : {"outer", "both"}) {
        const auto of = [&](std::shared_ptr<const Mesh> mesh) {
            return visibility(over_ground({hidden(std::move(mesh), "ball", {0.2, 0.1, 1.5})}, 2.0, 160, 160),
                              "penumbra_maps", {{"sides", std::string{sides}}, {"mode", std::string{"exact"}}});
        };
        EXPECT_EQ(of(ball), of(shuffled)) << sides;
    }
}

// T12: every row of the specification's section 4 that a scene can bring about.
TEST_F(PenumbraMapsScenes, SingularScenesStayFiniteAndWithinBounds) {
    const auto triangle = scenes::mesh("triangle", {{-0.5F, -0.5F, 0}, {0.5F, -0.4F, 0}, {0, 0.6F, 0.2F}}, {{0, 1, 2}});
    const auto needle = scenes::mesh("needle", {{0, 0, 1}, {0, 0, 3}, {0.001F, 0, 2}}, {{0, 1, 2}});
    const auto flat = scenes::mesh("no area", {{-0.3F, 0, 1}, {0.3F, 0, 1}, {0, 0, 1}}, {{0, 1, 2}});
    const auto fan =
        scenes::mesh("three at an edge", {{0, -0.5F, 1}, {0, 0.5F, 1}, {0.5F, 0, 1}, {-0.5F, 0, 1.2F}, {0.2F, 0, 1.6F}},
                     {{0, 1, 2}, {0, 1, 3}, {0, 1, 4}});
    const auto behind =
        scenes::mesh("past the light", {{-0.3F, -0.3F, 1}, {0.4F, -0.3F, 9}, {0.1F, 0.5F, 2}}, {{0, 1, 2}});
    const auto around = scenes::box({-0.3F, -0.3F, 3.7F}, {0.3F, 0.3F, 4.3F});
    const auto touching = scenes::box({0, 0, 3}, {0.5F, 0.5F, 4});
    const auto contact = scenes::box({-0.4F, -0.4F, 0}, {0.4F, 0.4F, 1e-5F});
    const auto crack = scenes::mesh(
        "crack", {{-0.5F, -0.5F, 1}, {0.5F, -0.5F, 1}, {0.5F, 0.5F, 1}, {-0.5F, 0.5F, 1}, {0, 0.00001F, 1}},
        {{0, 1, 4}, {1, 2, 4}, {0, 2, 3}});
    for (const auto& mesh : {triangle, needle, flat, fan, behind, around, touching, contact, crack}) {
        for (const double radius : {1e-3, 0.3, 3.0}) {
            const Scene scene = over_ground(
                {hidden(mesh, mesh->name, mesh == triangle ? glm::dvec3{0, 0, 1} : glm::dvec3{})}, 1.5, 48, 48, radius);
            for (const Settings& settings :
                 {Settings{}, Settings{{"mode", std::string{"literal"}}}, Settings{{"sides", std::string{"both"}}},
                  Settings{{"shape", std::string{"sphere"}}}, Settings{{"ramp", std::string{"exact"}}}}) {
                Settings small = settings;
                small["map_size"] = 256;
                for (const float v : visibility(scene, "penumbra_maps", small)) {
                    ASSERT_TRUE(v >= 0.0F && v <= 1.0F) << mesh->name << " radius " << radius << ": " << v;
                }
            }
        }
    }
}

// T14: the rim of the cones at the deepest receiver, however deep that is.
TEST_F(PenumbraMapsGl, AReceiverFarBelowChangesNothingAbove) {
    const double kappa = 2.0, radius = 0.2;
    Scene scene = half_plane(kappa, radius);
    scene.instances[0] = scenes::place(scenes::sheet(-50, 0.25, -50, 50), "ground");
    scene.instances.push_back(scenes::place(scenes::sheet(-400, 400, -400, 400), "pit", {0, 0, -36}));
    scene.camera.far_m = 200.0;
    const std::vector<double> v = profile(visibility(scene, "penumbra_maps"), scene.camera);
    for (int x = 0; x < scene.camera.width_px; ++x) {
        const double u = u_of(scene, x, kappa, radius);
        if (u * radius * (kappa - 1.0) < 0.24) {
            const auto expected = [&](double at) {
                return at < 0.0 ? 0.0 : smoothstep_falloff(published_intensity(std::min(at, 1.0), kappa));
            };
            EXPECT_GE(v[static_cast<std::size_t>(x)], expected(u - 0.006) - 2.0 / 255.0) << u;
            EXPECT_LE(v[static_cast<std::size_t>(x)], expected(u + 0.006) + 2.0 / 255.0) << u;
        }
    }
}

// T15: one object per light; a light knows nothing of the others.
TEST_F(PenumbraMapsScenes, TwoLightsGiveTheMapsOfEachAlone) {
    Scene both = over_ground({hidden(scenes::sphere(12, false), "ball", {0.2, 0.1, 1.5})}, 2.0, 96, 96);
    Light second = scenes::rectangle_light({1.0, 0.5, 3.0}, 0.4, 0.2);
    Scene alone = both;
    alone.lights = {second};
    both.lights.push_back(second);
    renderer().set_scene(both);
    const std::vector<float> of_two = renderer().visibility(1, {"penumbra_maps", {}}, false, control_).visibility;
    EXPECT_EQ(of_two, visibility(alone, "penumbra_maps"));
}

TEST_F(PenumbraMapsScenes, PackedAndUnpackedAreTheSameImage) {
    const Scene scene = over_ground({hidden(scenes::sphere(12, false), "ball", {0.2, 0.1, 1.5})}, 2.0, 96, 96);
    for (const char* filter : {"nearest", "gathered"}) {
        const auto with = [&](bool packed) {
            return visibility(scene, "penumbra_maps", {{"packed", packed}, {"filter", std::string{filter}}});
        };
        EXPECT_EQ(with(true), with(false)) << filter;
    }
}

// Gathering moves values by a texel at most and lets no light onto a caster's rim. The light stands over the box's
// side, whose upper edge, at depth 2, throws the wider penumbra.
TEST_F(PenumbraMapsScenes, GatheredFilteringStaysBetweenItsTexels) {
    const Scene scene = over_ground({hidden(scenes::box({-3, -3, 1}, {0, 3, 2}), "box")}, 0.5, 256, 9);
    const std::vector<float> v = visibility(scene, "penumbra_maps", {{"filter", std::string{"gathered"}}});
    expect_row(v, scene, 4, 2.0 / 1000.0, [&](double x) { return outer_ramp(x, 2.0); });
}

TEST_F(PenumbraMapsScenes, SimplifiedCastersCastNearlyTheSameShadowWithoutAcne) {
    Instance ball = scenes::place(scenes::sphere(64, false), "ball", {0.2, 0.1, 1.5});
    const Scene scene = over_ground({ball}, 2.0, 128, 128);
    const std::vector<float> full = visibility(scene, "penumbra_maps");
    const std::vector<float> reduced = visibility(scene, "penumbra_maps", {{"caster_triangles", 2000}});
    EXPECT_LT(share_that_differs(full, reduced, 0.1), 0.02);
    // The ball's lit side, straight under the light.
    EXPECT_EQ(reduced[64 * 128 + 70], 1.0F);
    EXPECT_EQ(full[64 * 128 + 70], 1.0F);
}

struct ShapeCase {
    const char* name;
    Light light;
    double width_m;      ///< half width across the edge
    bool linear = true;  ///< the area's ramp
};

// The light's own shape: V of a straight edge is the area that it leaves, exactly, if both sides are drawn.
TEST_F(PenumbraMapsGl, OwnShapesFollowTheirAreaOnAStraightEdge) {
    const auto area = [](LightKind kind, const glm::dvec3& u, const glm::dvec3& v) {
        Light light = scenes::rectangle_light({0, 0, kLightHeight}, 1, 1);
        light.kind = kind;
        light.half_u_ws = u;
        light.half_v_ws = v;
        return light;
    };
    const ShapeCase cases[] = {
        {"rectangle across", area(LightKind::Rectangle, {0.2, 0, 0}, {0, -0.05, 0}), 0.2},
        {"rectangle along", area(LightKind::Rectangle, {0.05, 0, 0}, {0, -0.2, 0}), 0.05},
        {"ellipse across", area(LightKind::Ellipse, {0.2, 0, 0}, {0, -0.05, 0}), 0.2, false},
        {"ellipse along", area(LightKind::Ellipse, {0.05, 0, 0}, {0, -0.2, 0}), 0.05, false},
        {"line across", area(LightKind::Line, {0.2, 0, 0}, {0, 0, 0}), 0.2},
    };
    for (const ShapeCase& c : cases) {
        const double kappa = 2.0;
        const Scene scene = scenes::straight_edge(c.light, 2.0, 0.0, 256, 0.3);
        const std::vector<double> v = profile(
            visibility(scene, "penumbra_maps", {{"sides", std::string{"both"}}, {"shape", std::string{"light"}}}),
            scene.camera);
        for (int x = 0; x < scene.camera.width_px; ++x) {
            const double u = scenes::column_x(scene.camera, x) / (c.width_m * (kappa - 1.0));
            const double truth = c.linear ? std::clamp(0.5 + 0.5 * u, 0.0, 1.0) : disc_fraction(u);
            EXPECT_NEAR(v[static_cast<std::size_t>(x)], truth, 2.0 / 255.0 + 0.6 / (1000.0 * c.width_m))
                << c.name << " " << u;
        }
    }
}

// A triangle is cut off centre: V at the hard edge is not 1/2.
TEST_F(PenumbraMapsGl, ATriangleLightFollowsItsArea) {
    Light light = scenes::rectangle_light({0, 0, kLightHeight}, 1, 1);
    light.kind = LightKind::Polygon;
    light.half_u_ws = light.half_v_ws = glm::dvec3{0.0};
    light.corners_ws = {{-0.1, -0.15, kLightHeight}, {-0.1, 0.15, kLightHeight}, {0.2, 0, kLightHeight}};
    std::swap(light.corners_ws[0], light.corners_ws[1]);
    light.direction_ws = {0, 0, -1};
    light.position_ws = {0, 0, kLightHeight};
    const Scene scene = scenes::straight_edge(light, 2.0, 0.0, 256, 0.3);
    const std::vector<double> v =
        profile(visibility(scene, "penumbra_maps", {{"sides", std::string{"both"}}, {"shape", std::string{"light"}}}),
                scene.camera);
    for (int x = 0; x < scene.camera.width_px; ++x) {
        // The part of the light with q_x > -at; kappa = 2. Similar triangles: from the tip at 0.2, 0.3 long.
        const double at = scenes::column_x(scene.camera, x);
        const double share = std::clamp((0.2 + at) / 0.3, 0.0, 1.0);
        EXPECT_NEAR(v[static_cast<std::size_t>(x)], share * share, 0.03) << at;
    }
}

TEST_F(PenumbraMapsGl, ASunFollowsTheAreaOfItsDisc) {
    const double angle = 0.2;
    const Scene scene = scenes::straight_edge(scenes::sun_light({0, 0, -1}, angle), 1.0, 0.0, 256, 0.15);
    const std::vector<double> v =
        profile(visibility(scene, "penumbra_maps", {{"sides", std::string{"both"}}}), scene.camera);
    for (int x = 0; x < scene.camera.width_px; ++x) {
        const double u = scenes::column_x(scene.camera, x) / std::tan(0.5 * angle);
        EXPECT_NEAR(v[static_cast<std::size_t>(x)], disc_fraction(u), 0.015) << u;
    }
}

// Away from the axis a disc parallel to the map is smaller than the sphere by the cosine; the sphere's own shape is
// not.
TEST_F(PenumbraMapsGl, TheSpheresOwnShapeIsNearerToTheTruthAwayFromTheAxis) {
    Scene scene = scenes::straight_edge(scenes::point_light({0, 0, 2}, 0.15), 1.0, 1.0, 256, 2.3);
    renderer().set_scene(scene);
    const Reference truth = renderer().reference(0, {.standard_error = 0.003}, control_);
    const auto error = [&](const char* shape) {
        const std::vector<float> v =
            visibility(scene, "penumbra_maps",
                       {{"sides", std::string{"both"}}, {"shape", std::string{shape}}, {"map_size", 2048}});
        double sum = 0.0;
        int count = 0;
        for (std::size_t i = 0; i < v.size(); ++i) {
            if (truth.area[i] > 0.0F && truth.area[i] < 1.0F) {
                sum += (v[i] - truth.area[i]) * (v[i] - truth.area[i]);
                ++count;
            }
        }
        return std::sqrt(sum / count);
    };
    const double disc = error("disc"), sphere = error("sphere");
    EXPECT_LT(sphere, 0.03);
    EXPECT_GT(disc, 2.0 * sphere);
}

// Lights side by side: layers of common arrays, each light's image its own to the bit.
TEST_F(PenumbraMapsGl, SeveralLightsShareArraysAndHaveTheirImagesOfBefore) {
    Scene scene;
    scene.instances.push_back(scenes::place(scenes::sheet(-3, 3, -3, 3), "ground"));
    scene.instances.push_back(scenes::place(scenes::sphere(16, false), "ball", {0.3, 0.2, 1.2}));
    scene.instances.push_back(scenes::place(scenes::box({-0.3F, -0.3F, 0.0F}, {0.3F, 0.3F, 0.8F}), "box", {-1, -1, 0}));
    scene.camera = scenes::camera_from_above(2.0, 96, 96);
    Light spot = scenes::point_light({1.0, 0.5, 4.0}, 0.2);
    spot.kind = LightKind::Spot;
    spot.spot_angle_rad = 1.4;
    scene.lights = {spot, scenes::point_light({-0.2, 0.9, 0.7}, 0.1), scenes::sun_light({0.3, 0.2, -1.0}, 0.05)};
    renderer().set_scene(scene);
    for (const char* packed : {"false", "true"}) {
        const Job job{"penumbra_maps", {{"map_size", 256}, {"packed", packed == std::string{"true"}}}};
        const std::vector<std::size_t> lights{0, 1, 2};
        const auto together = renderer().visibility(lights, job, false, control_);
        ASSERT_EQ(together.size(), 3U);
        std::size_t bytes = 0;
        double faces = 0.0;
        for (const std::size_t light : lights) {
            const VisibilityResult alone = renderer().visibility(light, job, false, control_);
            EXPECT_EQ(alone.visibility, together[light].visibility) << light << " packed " << packed;
            EXPECT_EQ(alone.memory_bytes, together[light].memory_bytes) << "a light pays for its own layers";
            bytes += alone.memory_bytes;
            faces += value_of(alone, "map_layers");
            EXPECT_EQ(value_of(alone, "map_arrays"), value_of(together.back(), "map_arrays"))
                << "as many arrays for three lights as for one";
        }
        EXPECT_GT(bytes, 0U);
        EXPECT_EQ(value_of(together.back(), "map_layers"), faces);
        EXPECT_GT(value_of(together[1], "map_layers"), 3.0 * 2.0) << "the point light has several faces";
        // Nothing is left of them.
        EXPECT_LT(value_of(renderer().visibility(0, job, false, control_), "map_layers"), faces);
    }
}

}  // namespace
}  // namespace penumbra
