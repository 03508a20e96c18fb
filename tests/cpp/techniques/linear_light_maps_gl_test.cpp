// Soft shadow maps for linear lights on the device: closed forms of linear-light-soft-shadow-maps section 3 and
// singular cases of section 4. The oracle itself is tested in tests/cpp/geometry/linear_light_test.cpp.
#include <functional>

#include "techniques/renderer_fixture.h"

namespace penumbra {
namespace {

constexpr const char* kId = "linear_light_maps";

Light line_light(const glm::dvec3& centre, const glm::dvec3& half) {
    Light light = scenes::rectangle_light(centre, 1.0, 1.0);
    light.kind = LightKind::Line;
    light.half_u_ws = half;
    light.half_v_ws = glm::dvec3{0.0};
    return light;
}

/// An occluder of the row scenes: [x0, x1] at depths z0 .. z1 below the light, endless along y.
struct Block {
    double x0, x1, z0, z1;
};

/// The scenes of section 3 in space: a line light from (0, 0, z_r) to (1, 0, z_r) over the ground z = slope x.
struct RowScene {
    std::vector<Block> blocks;
    double z_r = 2.0, slope = 0.0;
    bool seen = false;  ///< the camera sees the occluders, too

    [[nodiscard]] Scene scene(int width_px = 512, int height_px = 16) const {
        Scene scene;
        Instance ground = scenes::place(scenes::sheet(-40, 40, -40, 40), "ground");
        const double length = std::sqrt(1.0 + slope * slope);
        // Its own x axis leads downwards by the slope: depth below the light is z_r + slope x.
        ground.world_from_local = glm::dmat4{
            {1.0 / length, 0, -slope / length, 0}, {0, 1, 0, 0}, {slope / length, 0, 1.0 / length, 0}, {0, 0, 0, 1}};
        scene.instances.push_back(ground);
        for (const Block& block : blocks) {
            const auto x0 = static_cast<float>(block.x0);
            const auto x1 = static_cast<float>(block.x1);
            Instance instance =
                block.z0 == block.z1
                    ? scenes::place(scenes::sheet(block.x0, block.x1, -10, 10), "strip")
                    : scenes::place(scenes::box({x0, -10, static_cast<float>(block.z0 - block.z1)}, {x1, 10, 0}),
                                    "box");
            instance.world_from_local[3] = glm::dvec4{0, 0, z_r - block.z0, 1};
            instance.visible = instance.receives = seen;
            scene.instances.push_back(instance);
        }
        scene.lights.push_back(line_light({0.5, 0, z_r}, {0.5, 0, 0}));
        scene.camera = scenes::camera_from_above(3.0, width_px, height_px);
        scene.camera.world_from_camera[3].x = 0.5;
        return scene;
    }

    [[nodiscard]] double truth(double x) const {
        const double z = z_r + slope * x;
        std::vector<std::pair<double, double>> hidden;
        for (const Block& block : blocks) {
            double low = 1e300;
            double high = -1e300;
            for (const double bx : {block.x0, block.x1}) {
                for (const double bz : {block.z0, block.z1}) {
                    const double s = x + (bx - x) * z / (z - std::min(bz, z - 1e-12));
                    low = std::min(low, s);
                    high = std::max(high, s);
                }
            }
            hidden.emplace_back(std::clamp(low, 0.0, 1.0), std::clamp(high, 0.0, 1.0));
        }
        std::sort(hidden.begin(), hidden.end());
        double left = 1.0;
        double up_to = 0.0;
        for (const auto& [low, high] : hidden) {
            left -= std::max(0.0, high - std::max(low, up_to));
            up_to = std::max(up_to, high);
        }
        return left;
    }
};

Block strip(double x0, double x1, double z = 1.0) {
    return {x0, x1, z, z};
}
RowScene wide_strip() {
    return {.blocks = {strip(0.2, 1.2)}};
}
RowScene gap(double from, double to) {
    return {.blocks = {strip(-9.0, from), strip(to, 9.0)}, .z_r = 2.2};
}
RowScene two_thin_strips() {
    return {.blocks = {strip(0.35, 0.42), strip(0.58, 0.65)}};
}

struct Errors {
    double rms = 0.0, low = 0.0, high = 0.0;
};

class LinearLightMapsGl : public RendererGl {
protected:
    static double column_x(const Scene& scene, int x) {
        return scene.camera.world_from_camera[3].x + scenes::column_x(scene.camera, x);
    }
    Errors errors_of(const RowScene& row, const Settings& settings) {
        const Scene scene = row.scene();
        const std::vector<float> v = visibility(scene, kId, settings);
        Errors errors;
        double sum = 0.0;
        for (int y = 0; y < scene.camera.height_px; ++y) {
            for (int x = 0; x < scene.camera.width_px; ++x) {
                const double error =
                    v[static_cast<std::size_t>(y * scene.camera.width_px + x)] - row.truth(column_x(scene, x));
                errors.low = std::min(errors.low, error);
                errors.high = std::max(errors.high, error);
                sum += error * error;
            }
        }
        errors.rms = std::sqrt(sum / static_cast<double>(v.size()));
        return errors;
    }
    VisibilityResult result(const Scene& scene, const Settings& settings, bool keep_everything = false) {
        renderer().set_scene(scene);
        return renderer().visibility(0, {kId, settings}, keep_everything, control_);
    }
    static double statistic(const VisibilityResult& result, const std::string& id) {
        for (const Statistic& s : result.statistics) {
            if (s.id == id) {
                return s.value;
            }
        }
        return -1.0;
    }
    /// A scene and its ray-traced truth.
    struct Truth {
        Scene scene;
        Reference rays;
    };
    Truth trace(const Scene& scene) {
        renderer().set_scene(scene);
        return {scene, renderer().reference(0, {.standard_error = 0.015}, control_)};
    }
    /// RMSE over the mask.
    double error(const Truth& truth, const Settings& settings, bool irradiance = false, const std::string& id = kId) {
        Settings all = settings;
        all.insert({"map_size", 512});
        const std::vector<float> v = visibility(truth.scene, id, all);
        double sum = 0.0;
        double count = 0.0;
        for (std::size_t i = 0; i < v.size(); ++i) {
            if (truth.rays.mask[i] != 0) {
                const float reference = irradiance ? truth.rays.irradiance[i] : truth.rays.area[i];
                sum += (v[i] - reference) * static_cast<double>(v[i] - reference);
                ++count;
            }
        }
        return std::sqrt(sum / std::max(count, 1.0));
    }
    static bool fires(const Plan& plan, const std::string& rule) {
        return std::any_of(plan.steps.begin(), plan.steps.end(),
                           [&](const Step& step) { return !step.run && step.rule == rule; });
    }
};

// X2.
TEST_F(LinearLightMapsGl, AHalfPlaneUnderALineHasTheClosedFormsRampAtAnyAngle) {
    const double length = 1.0;
    for (const double degrees : {90.0, 45.0, 15.0}) {
        const double psi = degrees * scenes::kPi / 180.0;
        const Light light = line_light({0, 0, 4}, 0.5 * length * glm::dvec3{std::sin(psi), std::cos(psi), 0.0});
        const Scene scene = scenes::straight_edge(light, 1.5, 0.2, 256, 1.0);
        const double edge = 0.2 * 4.0 / 2.5;
        const double width = 0.5 * length * std::sin(psi) * 1.5 / 2.5;
        for (const int samples : {2, 3, 5}) {
            const std::vector<float> v = visibility(scene, kId, {{"samples", samples}});
            double worst = 0.0;
            for (int y = 0; y < scene.camera.height_px; ++y) {
                for (int x = 0; x < scene.camera.width_px; ++x) {
                    const double u = (scenes::column_x(scene.camera, x) - edge) / (2.0 * width);
                    const double error =
                        std::clamp(0.5 + u, 0.0, 1.0) - v[static_cast<std::size_t>(y * scene.camera.width_px + x)];
                    worst = std::max(worst, std::abs(error));
                }
            }
            EXPECT_LT(worst, 0.02) << degrees << " degrees, " << samples << " samples";
        }
    }
}

TEST_F(LinearLightMapsGl, AnEdgeAlongTheLightIsAStepRightToATexel) {
    const Scene scene = scenes::straight_edge(line_light({0, 0, 4}, {0, 0.5, 0}), 1.5, 0.2, 256, 1.0);
    const std::vector<float> v = visibility(scene, kId);
    for (int x = 0; x < scene.camera.width_px; ++x) {
        const double at = scenes::column_x(scene.camera, x);
        if (std::abs(at - 0.32) > 0.01) {
            EXPECT_EQ(v[static_cast<std::size_t>(5 * scene.camera.width_px + x)], at > 0.32 ? 1.0F : 0.0F) << at;
        }
    }
}

// X1, X5, X6, X7 with the specification's figures.
TEST_F(LinearLightMapsGl, TheRowScenesErrAsTheSpecificationMeasured) {
    struct Row {
        const char* name;
        RowScene scene;
        int samples;
        double rms, low, high;  // limits
    };
    const std::vector<Row> rows{
        {"strip", wide_strip(), 2, 0.006, -0.02, 0.02},
        {"strip", wide_strip(), 3, 0.006, -0.02, 0.02},
        {"thin strip", {.blocks = {strip(0.45, 0.55)}}, 2, 0.006, -0.02, 0.02},
        {"gap", gap(0.3, 0.7), 3, 0.006, -0.02, 0.02},
        {"off-centre gap", gap(0.75, 0.95), 5, 0.006, -0.02, 0.02},
        {"two thin strips", two_thin_strips(), 5, 0.008, -0.025, 0.025},
        {"box", {.blocks = {{0.3, 0.8, 0.8, 1.3}}, .z_r = 2.2}, 2, 0.03, -0.02, 0.2},
    };
    for (const Row& row : rows) {
        const Errors errors = errors_of(row.scene, {{"samples", row.samples}});
        EXPECT_LE(errors.rms, row.rms) << row.name << " " << row.samples;
        EXPECT_GE(errors.low, row.low) << row.name << " " << row.samples;
        EXPECT_LE(errors.high, row.high) << row.name << " " << row.samples;
    }
}

TEST_F(LinearLightMapsGl, TwoSamplesMissAGapBetweenThemAndTheThirdFindsIt) {
    const Errors two = errors_of(gap(0.3, 0.7), {});
    EXPECT_NEAR(two.low, -0.734, 0.02);
    EXPECT_NEAR(two.rms, 0.168, 0.02);
    EXPECT_GE(errors_of(gap(0.3, 0.7), {{"samples", 3}}).low, -0.02);
}

TEST_F(LinearLightMapsGl, TheAdaptiveRuleAddsSamplesWhereTwoAreTooFew) {
    struct Row {
        const char* name;
        RowScene scene;
        double samples;
    };
    for (const auto& [name, scene, samples] :
         {Row{"strip", wide_strip(), 2}, Row{"gap", gap(0.3, 0.7), 3}, Row{"off-centre gap", gap(0.75, 0.95), 5}}) {
        const VisibilityResult found = result(scene.scene(), {{"adaptive", true}});
        EXPECT_EQ(statistic(found, "samples"), samples) << name;
        EXPECT_LE(statistic(found, "undersampled"), 1e-4) << name;
        EXPECT_GE(errors_of(scene, {{"adaptive", true}}).low, -0.02) << name;
    }
}

TEST_F(LinearLightMapsGl, SlotsOfThreeSamplesAreKeptApart) {
    // Behind the strip's left edge the second half of the light is hidden first.
    const RowScene row = wide_strip();
    const Errors three = errors_of(row, {{"samples", 3}});
    const Errors five = errors_of(row, {{"samples", 5}});
    EXPECT_LE(std::max({three.high, -three.low, five.high, -five.low}), 0.02);
}

// X4.
TEST_F(LinearLightMapsGl, ATiltedReceiverErrsByKappaAndNotInExactMode) {
    for (const double slope : {0.25, 0.5, -0.4}) {
        RowScene row = wide_strip();
        row.slope = slope;
        const double kappa = (2.0 + slope) / 2.0;
        const double predicted = std::abs(std::sqrt(kappa) - 1.0) / (std::sqrt(kappa) + 1.0);
        const Errors linear = errors_of(row, {{"map_size", 2048}});
        EXPECT_NEAR(std::max(linear.high, -linear.low), predicted, 0.012) << slope;
        const Errors exact = errors_of(row, {{"map_size", 2048}, {"transition", std::string{"exact"}}});
        // Texels alone, 1.5 of a ramp of 100: the receiver comes close to the light's height, and the window is wide.
        EXPECT_LE(std::max(exact.high, -exact.low), 0.02) << slope;
    }
}

TEST_F(LinearLightMapsGl, RimsOfOccludersStayLit) {
    int dark_without_the_rule = 0;
    for (const int size_px : {97, 128, 150, 211}) {  // so that edges fall at many places in a texel
        for (const int samples : {2, 3}) {
            RowScene row = wide_strip();
            row.seen = true;
            const Scene scene = row.scene(1024);
            Settings settings{{"samples", samples}, {"map_size", size_px}};
            const std::vector<float> v = visibility(scene, kId, settings);
            settings["rim_rule"] = false;
            const std::vector<float> without = visibility(scene, kId, settings);
            for (int x = 0; x < 1024; ++x) {
                const std::size_t i = 7 * 1024 + static_cast<std::size_t>(x);
                if (const double at = column_x(scene, x); at > 0.2 && at < 1.199) {
                    EXPECT_EQ(v[i], 1.0F) << at << ", " << samples << " samples, map of " << size_px;
                    dark_without_the_rule += without[i] < 1.0F ? 1 : 0;
                }
            }
        }
    }
    EXPECT_GT(dark_without_the_rule, 0) << "else this tests nothing";
}

TEST_F(LinearLightMapsGl, WithoutSkinsItIsHardShadowsWithTrapezoidWeights) {
    const std::vector<float> v = visibility(wide_strip().scene(), kId, {{"samples", 4}, {"least_skin", 1e9}});
    for (const float value : v) {
        EXPECT_NEAR(6.0 * value, std::round(6.0 * value), 1e-5);
    }
}

TEST_F(LinearLightMapsGl, TheDarkestOfOverlappingSkinsIsNoLighterThanTheNearest) {
    const Scene scene = two_thin_strips().scene();
    const std::vector<float> nearest = visibility(scene, kId);
    const std::vector<float> darkest = visibility(scene, kId, {{"conflict", std::string{"darkest"}}});
    for (std::size_t i = 0; i < nearest.size(); ++i) {
        EXPECT_LE(darkest[i], nearest[i] + 1e-3F);
    }
    // One edge alone knows no conflict.
    const Scene edge = scenes::straight_edge(line_light({0, 0, 4}, {0.5, 0, 0}), 1.5);
    EXPECT_EQ(visibility(edge, kId), visibility(edge, kId, {{"conflict", std::string{"darkest"}}}));
}

TEST_F(LinearLightMapsGl, TheWiderFilterFindsTheSameStraightEdge) {
    const RowScene row = wide_strip();
    const Errors errors = errors_of(row, {{"edge_filter", std::string{"log5"}}});
    EXPECT_LE(std::max(errors.high, -errors.low), 0.02);
}

/// A ball and a fence over a ground, seen obliquely.
Scene fence_scene(const Light& light, int width_px = 96) {
    Scene scene;
    scene.instances.push_back(scenes::place(scenes::sheet(-20, 20, -20, 20), "ground"));
    scene.instances.push_back(scenes::place(scenes::sphere(16, false), "ball", {0.4, 0.3, 1.2}));
    const auto bar = scenes::box({-0.1F, -0.1F, 0.0F}, {0.1F, 0.1F, 1.5F});
    for (int i = 0; i < 4; ++i) {
        scene.instances.push_back(scenes::place(bar, "bar " + std::to_string(i), {-1.5 + 0.5 * i, -1.0, 0.0}));
    }
    scene.lights.push_back(light);
    scene.camera = scenes::camera_from_above(3.0, width_px, width_px * 3 / 4, 20.0);
    const double a = 0.6;
    const glm::dmat3 tilt{{1, 0, 0}, {0, std::cos(a), std::sin(a)}, {0, -std::sin(a), std::cos(a)}};
    scene.camera.world_from_camera = glm::dmat4{tilt};
    scene.camera.world_from_camera[3] = glm::dvec4{tilt * glm::dvec3{0, 0, 20}, 1.0};
    return scene;
}

TEST_F(LinearLightMapsGl, TheSoftwareEngineAgreesWithTheDevice) {
    Light square = scenes::rectangle_light({0.3, -0.2, 4.0}, 0.8, 0.8);
    Light sun = scenes::sun_light({0.2, 0.1, -1.0}, 0.1);
    for (const Light& light :
         {line_light({0.3, -0.2, 4.0}, {0.4, 0.1, 0.0}), square, sun, scenes::point_light({0.3, -0.2, 4.0}, 0.3)}) {
        for (const char* transition : {"linear", "exact"}) {
            for (const char* weights : {"visibility", "irradiance"}) {
                Settings settings{{"samples", 3},
                                  {"transition", std::string{transition}},
                                  {"weights", std::string{weights}},
                                  {"map_size", 512}};
                const std::vector<float> device = visibility(fence_scene(light), kId, settings);
                settings["engine"] = std::string{"software"};
                const std::vector<float> software = visibility(fence_scene(light), kId, settings);
                // Texels whose edge a float's rounding decides, and their skins.
                EXPECT_LE(share_that_differs(device, software, 2.0 / 255.0), 0.005)
                    << to_string(light.kind) << " " << transition << " " << weights;
            }
        }
    }
}

TEST_F(LinearLightMapsGl, ManySamplesTendToTheReference) {
    for (const Light& light :
         {line_light({0.3, -0.2, 4.0}, {0.5, 0.2, 0.0}), line_light({0.5, -1, 3.0}, {0.2, 0.1, 0.6})}) {
        const Truth truth = trace(fence_scene(light));
        const double two = error(truth, {});
        const double seventeen = error(truth, {{"samples", 17}, {"transition", std::string{"exact"}}});
        EXPECT_LT(seventeen, 0.03);
        EXPECT_LT(seventeen, two);
        EXPECT_LT(two, error(truth, {{"least_skin", 1e9}})) << "no better than two hard shadows";
    }
}

TEST_F(LinearLightMapsGl, MoreLinesAreNearerToASquare) {
    const Truth truth = trace(fence_scene(scenes::rectangle_light({0.3, -0.2, 4.0}, 0.9, 0.9)));
    const double one = error(truth, {{"lines", 1}, {"samples", 3}});
    const double four = error(truth, {{"samples", 3}});
    const double sixteen = error(truth, {{"lines", 16}, {"samples", 3}});
    EXPECT_LT(four, one);
    EXPECT_LT(sixteen, four);
    EXPECT_LT(sixteen, 0.04);
}

TEST_F(LinearLightMapsGl, RoundLightsAreNearerByTheirSegmentThanByAPoint) {
    Light disc = scenes::rectangle_light({0.3, -0.2, 4.0}, 0.9, 0.9);
    disc.kind = LightKind::Ellipse;
    for (const Light& light :
         {disc, scenes::point_light({1.5, -0.6, 3.0}, 0.4), scenes::sun_light({-0.5, 0.2, -1.0}, 0.2)}) {
        const Truth truth = trace(fence_scene(light));
        const double segment = error(truth, {{"samples", 3}});
        const double strips = error(truth, {{"samples", 3}, {"lines", 8}});
        EXPECT_LT(segment, error(truth, {}, false, "shadow_map")) << to_string(light.kind);
        EXPECT_LT(strips, segment) << to_string(light.kind);
        EXPECT_LT(strips, 0.05) << to_string(light.kind);
    }
}

// 2.11: the visibility of an edge parallel to a side of an equilateral triangle is 1/3 off at that side.
TEST_F(LinearLightMapsGl, ATriangleErrsByTheQuadraticThatItsSidesLeaveOut) {
    const double side = 1.0;
    const double height = side * std::sqrt(3.0) / 2.0;
    Light triangle = scenes::rectangle_light({0, 0, 4}, 1.0, 1.0);
    triangle.kind = LightKind::Polygon;
    // A side along y at x = 0, the tip towards +x.
    triangle.corners_ws = {{0, -0.5, 4}, {height, 0, 4}, {0, 0.5, 4}};
    triangle.position_ws = (triangle.corners_ws[0] + triangle.corners_ws[1] + triangle.corners_ws[2]) / 3.0;
    triangle.half_u_ws = triangle.half_v_ws = glm::dvec3{0.0};
    // The half plane x < 0 at height 2: the ground's point x sees light points beyond -x.
    const Scene scene = scenes::straight_edge(triangle, 2.0, 0.0, 512, 1.2);
    const std::vector<float> v = visibility(scene, kId, {{"map_size", 1024}});
    double worst = 0.0;
    double at_third = 1.0;
    for (int x = 0; x < 512; ++x) {
        const double tau = -scenes::column_x(scene.camera, x) / height;  // hidden height, as a share
        if (tau <= 0.01 || tau >= 0.99) {
            continue;
        }
        const double truth = (1.0 - tau) * (1.0 - tau);
        const double error = v[static_cast<std::size_t>(20 * 512 + x)] - truth;
        EXPECT_NEAR(error, -(tau - 1.0) * (tau - 1.0 / 3.0), 0.03) << tau;
        worst = std::max(worst, std::abs(error));
        at_third = std::abs(tau - 1.0 / 3.0) < 0.01 ? std::min(at_third, std::abs(error)) : at_third;
    }
    EXPECT_NEAR(worst, 1.0 / 3.0, 0.03);
    EXPECT_LT(at_third, 0.02);
    // Strips instead of sides.
    const std::vector<float> strips =
        visibility(scene, kId, {{"layout", std::string{"strips"}}, {"lines", 16}, {"samples", 3}, {"map_size", 512}});
    double worst_strips = 0.0;
    for (int x = 0; x < 512; ++x) {
        const double tau = std::clamp(-scenes::column_x(scene.camera, x) / height, 0.0, 1.0);
        worst_strips = std::max(worst_strips,
                                std::abs(strips[static_cast<std::size_t>(20 * 512 + x)] - (1.0 - tau) * (1.0 - tau)));
    }
    EXPECT_LT(worst_strips, 0.08);
}

TEST_F(LinearLightMapsGl, ASunsSheetOfDirectionsHasALinearPenumbra) {
    // An edge across the segment of directions, which lies across the receivers' least extent: here along x or y.
    Scene scene = scenes::straight_edge(scenes::sun_light({0.6, 0.0, -1.0}, 0.2), 1.5, 0.0, 256, 2.0);
    scene.instances[1] = scenes::place(scenes::sheet(-20.0, 20.0, -40.0, 0.0), "blocker", {0.0, 0.0, 1.5});
    scene.instances[1].visible = scene.instances[1].receives = false;
    scene.camera = scenes::camera_from_above(1.0, 64, 256);
    scene.camera.half_width_m = 0.25;
    const std::vector<float> v = visibility(scene, kId);
    // Directions (0.6, s, -1) up to scale: the segment is sqrt(3)/2 of the half angle's tangent, along y.
    const double reach = std::tan(0.1) * std::sqrt(3.0) / 2.0 * std::sqrt(1.0 + 0.36);
    for (int y = 0; y < 256; ++y) {
        const double at = 1.0 * (2.0 * (y + 0.5) / 256.0 - 1.0);
        const double truth = std::clamp(0.5 + at / (2.0 * reach * 1.5), 0.0, 1.0);
        EXPECT_NEAR(v[static_cast<std::size_t>(y * 64 + 30)], truth, 0.03) << at;
    }
}

TEST_F(LinearLightMapsGl, ALineInTheMiddleOfARoomLightsAllWalls) {
    Scene scene;
    // A room seen from inside; boxes in every direction, also beyond the line's ends.
    scene.instances.push_back(scenes::place(scenes::box({-3, -3, -2}, {3, 3, 2}), "room"));
    for (const glm::dvec3& at : {glm::dvec3{0.2, 1.5, 0.1}, glm::dvec3{0.3, -1.4, 0}, glm::dvec3{-0.2, 0.1, -1.2},
                                 glm::dvec3{0.1, 0, 1.1}, glm::dvec3{2.0, 0.1, 0}, glm::dvec3{-2.1, 0, 0.1}}) {
        scene.instances.push_back(scenes::place(scenes::box({-0.2F, -0.2F, -0.2F}, {0.2F, 0.2F, 0.2F}), "box", at));
    }
    scene.lights.push_back(line_light({0, 0, 0}, {0.5, 0, 0}));
    scene.camera.tan_half_width = 1.4;
    scene.camera.width_px = 128;
    scene.camera.height_px = 96;
    scene.camera.near_m = 0.01;
    const auto look = [&](const glm::dvec3& from, const glm::dvec3& z) {
        const glm::dvec3 x = glm::normalize(glm::cross(glm::dvec3{0.1, 0.2, 1}, z));
        scene.camera.world_from_camera = glm::dmat4{glm::dmat3{x, glm::cross(z, x), z}};
        scene.camera.world_from_camera[3] = glm::dvec4{from, 1.0};
    };
    for (const glm::dvec3& from : {glm::dvec3{2.6, 2.5, 1.5}, glm::dvec3{-2.5, -2.6, -1.4}}) {
        look(from, glm::normalize(from));
        const Truth truth = trace(scene);
        const double five = error(truth, {{"samples", 5}});
        EXPECT_LT(five, 0.06);
        EXPECT_LT(five, error(truth, {}, false, "shadow_map"));
        EXPECT_EQ(visibility(scene, kId), visibility(scene, kId, {}, true)) << "windows left out";
    }
    const Plan plan = result(scene, {}).plan;
    EXPECT_TRUE(plan.runs("maps beyond the windows"));
}

TEST_F(LinearLightMapsGl, IrradianceWeightsAreNearerToWhatArrives) {
    // A line that leads away from the ground: its near end matters most.
    const Truth truth = trace(fence_scene(line_light({1.5, 0.0, 2.6}, {0.2, 0.1, 0.9})));
    const Settings plain{{"samples", 9}, {"transition", std::string{"exact"}}};
    Settings weighted = plain;
    weighted["weights"] = std::string{"irradiance"};
    EXPECT_LT(error(truth, weighted, true), error(truth, plain, true));
    EXPECT_LT(error(truth, plain), error(truth, weighted));
}

TEST_F(LinearLightMapsGl, ReceiversThatCastNothingAreReceiversOfSkins) {
    // The ground catches shadows and casts none: skins must still end on it, and nothing hang from it.
    Scene scene = wide_strip().scene();
    const std::vector<float> casting = visibility(scene, kId);
    scene.instances[0].casts = false;
    const VisibilityResult catching = result(scene, {});
    EXPECT_TRUE(catching.plan.runs("receiver depth maps"));
    EXPECT_LE(share_that_differs(casting, catching.visibility, 0.01), 0.002);
    EXPECT_EQ(catching.visibility, visibility(scene, kId, {}, true));
    // A table that casts nothing, over a ground that does not either, leaves no mark below it.
    Instance table = scenes::place(scenes::sheet(-2.4, -1.4, -1, 1), "table", {0, 0, 0.5});
    table.casts = false;
    table.visible = true;
    scene.instances.push_back(table);
    for (const float v : visibility(scene, kId)) {
        EXPECT_TRUE(v >= 0.0F && v <= 1.0F);
    }
    const std::vector<float> with_table = visibility(scene, kId);
    const int width = scene.camera.width_px;
    for (int x = 0; x < width; ++x) {
        const double at = column_x(scene, x);
        if (at < -0.9 && (at < -2.45 || at > -1.35)) {  // beside the table, where the strip's shadow does not reach
            EXPECT_EQ(with_table[static_cast<std::size_t>(7 * width + x)], 1.0F) << at;
        }
    }
}

TEST_F(LinearLightMapsGl, AShortLightNeedsNoSkinsAndThePlanSaysSo) {
    const Scene tiny = scenes::straight_edge(line_light({0, 0, 4}, {1e-4, 0, 0}), 1.5);
    const VisibilityResult planned = result(tiny, {});
    EXPECT_TRUE(fires(planned.plan, "skin-under-threshold"));
    const VisibilityResult everything = result(tiny, {}, true);
    EXPECT_FALSE(fires(everything.plan, "skin-under-threshold"));
    EXPECT_EQ(planned.visibility, everything.visibility);
    const Scene wide = scenes::straight_edge(line_light({0, 0, 4}, {0.5, 0, 0}), 1.5);
    EXPECT_FALSE(fires(result(wide, {}).plan, "skin-under-threshold"));
}

TEST_F(LinearLightMapsGl, ThePlanSaysWhichLinesStandForTheLight) {
    const auto said = [&](const Light& light) {
        const Plan plan = result(fence_scene(light), {{"map_size", 64}}).plan;
        const auto found = std::ranges::find_if(
            plan.steps, [](const Step& step) { return step.name.find(" as ") != std::string::npos; });
        return found == plan.steps.end() ? std::string{} : found->name;
    };
    Light disc = scenes::rectangle_light({0.3, -0.2, 4.0}, 2.0, 1.0);
    disc.kind = LightKind::Ellipse;
    EXPECT_EQ(said(disc), "ellipse as 1 line, 1.7 m along (1, 0, 0)");
    EXPECT_EQ(said(scenes::rectangle_light({0.3, -0.2, 4.0}, 1.0, 1.0)),
              "rectangle as 4 lines, the first 1 m along (1, 0, 0)");
    EXPECT_TRUE(said(scenes::point_light({0.3, -0.2, 4.0}, 0.3)).starts_with("sphere as 1 line, 0.52 m along"));
    EXPECT_EQ(said(line_light({0.3, -0.2, 4.0}, {0.4, 0.1, 0.0})), "");
}

TEST_F(LinearLightMapsGl, ItTellsWhatItUsedAndShowsWhatItDrew) {
    const Scene scene = fence_scene(line_light({0.3, -0.2, 4.0}, {0.4, 0.1, 0.0}));
    const VisibilityResult found = result(scene, {{"samples", 3}, {"map_size", 256}});
    EXPECT_EQ(statistic(found, "samples"), 3.0);
    EXPECT_EQ(statistic(found, "maps"), 3.0);
    EXPECT_GT(statistic(found, "skins"), 50.0);
    EXPECT_GT(statistic(found, "skin_share"), 0.01);
    EXPECT_LT(statistic(found, "skin_share"), 0.9);
    EXPECT_EQ(statistic(found, "skins_dropped"), -1.0);
    const auto pictures = renderer().debug_images(0, {kId, {{"map_size", 256}}}, {}, control_);
    ASSERT_EQ(pictures.size(), 4U);
    for (const NamedDebugImage& picture : pictures) {
        EXPECT_EQ(picture.image.width_px, 512) << picture.view.id;
        EXPECT_FALSE(picture.image.caption.empty());
        float low = 1.0F;
        float high = 0.0F;
        for (const glm::vec3& colour : picture.image.rgb) {
            ASSERT_TRUE(colour.x >= 0.0F && colour.x <= 1.0F);
            low = std::min(low, colour.x);
            high = std::max(high, colour.x);
        }
        EXPECT_GT(high - low, 0.3F) << picture.view.id;
    }
}

// Section 4: finite and between umbra and lit, whatever the arrangement.
TEST_F(LinearLightMapsGl, SingularArrangementsStayFinite) {
    struct Row {
        const char* name;
        std::function<void(Scene&)> change;
    };
    const std::vector<Row> rows{
        {"occluder at the light", [](Scene& s) { s.instances[1].world_from_local[3].z = 4.0 - 1e-4; }},
        {"occluder through the light", [](Scene& s) { s.instances[1].world_from_local[3].z = 4.0; }},
        {"occluder on the receiver", [](Scene& s) { s.instances[1].world_from_local[3].z = 0.0; }},
        {"light in the receiver", [](Scene& s) { s.lights[0].position_ws.z = 0.0; }},
        {"light dips into the receiver",
         [](Scene& s) {
             s.lights[0].half_u_ws = {0.5, 0, 4.5};
         }},
        {"light stands on the receiver",
         [](Scene& s) {
             s.lights[0].half_u_ws = {0, 0, 4.0};
         }},
        {"no ground", [](Scene& s) { s.instances[0] = scenes::place(scenes::sheet(-1, 0.5, -1, 1), "tile"); }},
        {"a light of no length",
         [](Scene& s) {
             s.lights[0].half_u_ws = {1e-12, 0, 0};
         }},
        {"a light of a kilometre",
         [](Scene& s) {
             s.lights[0].half_u_ws = {500, 0, 0};
         }},
        {"degenerate triangle",
         [](Scene& s) {
             s.lights[0].kind = LightKind::Polygon;
             s.lights[0].corners_ws = {{0, 0, 4}, {1, 0, 4}, {1, 1e-9, 4}};
         }},
    };
    for (const Row& row : rows) {
        Scene scene = scenes::straight_edge(line_light({0, 0, 4}, {0.5, 0, 0}), 1.5, 0.2, 128, 1.0);
        row.change(scene);
        for (const char* transition : {"linear", "exact"}) {
            for (const char* engine : {"gl", "software"}) {
                for (const float v : visibility(scene, kId,
                                                {{"transition", std::string{transition}},
                                                 {"engine", std::string{engine}},
                                                 {"map_size", 256}})) {
                    ASSERT_TRUE(v >= 0.0F && v <= 1.0F) << row.name << " " << transition << " " << engine;
                }
            }
        }
    }
}

TEST_F(LinearLightMapsGl, AnOccluderOnItsReceiverHasNoPenumbra) {
    Scene scene = scenes::straight_edge(line_light({0, 0, 4}, {0.5, 0, 0}), 1e-4, 0.2, 256, 1.0);
    const std::vector<float> v = visibility(scene, kId);
    for (int x = 0; x < 256; ++x) {
        if (const double at = scenes::column_x(scene.camera, x); at > 0.21) {
            EXPECT_EQ(v[static_cast<std::size_t>(9 * 256 + x)], 1.0F) << at;
        }
    }
}

TEST_F(LinearLightMapsGl, AWallThatTheLightGrazesIsNotDarkenedByItsOwnSkins) {
    // A tall box beside the light: its sides fall on few texels of the maps.
    Scene scene;
    scene.instances.push_back(scenes::place(scenes::sheet(-20, 20, -20, 20), "ground"));
    scene.instances.push_back(scenes::place(scenes::box({-0.5F, -1, 0}, {0.5F, 1, 2}), "box"));
    scene.lights.push_back(line_light({0.9, 0, 6}, {0.3, 0, 0}));
    scene.camera = scenes::camera_from_above(1.5, 128, 96, 20.0);
    const double a = 1.0;  // from the side, onto the wall x = 0.5
    const glm::dmat3 tilt{{0, 1, 0}, {-std::sin(a), 0, std::cos(a)}, {std::cos(a), 0, std::sin(a)}};
    scene.camera.world_from_camera = glm::dmat4{tilt};
    scene.camera.world_from_camera[3] = glm::dvec4{tilt[2] * 20.0, 1.0};
    const Truth truth = trace(scene);
    for (const int samples : {2, 3}) {
        const double kept = error(truth, {{"samples", samples}});
        EXPECT_LT(kept, 0.06) << samples;
        EXPECT_LE(kept, error(truth, {{"samples", samples}, {"rim_rule", false}})) << samples;
    }
}

}  // namespace
}  // namespace penumbra
