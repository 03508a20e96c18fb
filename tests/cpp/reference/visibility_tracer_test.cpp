#include "reference/visibility_tracer.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <thread>

#include "base/parallel.h"
#include "reference/light_mask.h"
#include "test_scenes.h"

namespace penumbra {
namespace {

using test::kPi;
using test::Point;

/// V at the points, all of which count.
std::vector<float> trace(const Scene& scene, const Light& light, const std::vector<Point>& points,
                         const TraceOptions& options, int width = 0) {
    Control control;
    const RayScene rays{scene, control};
    const View view = test::view_of(points, width);
    const std::vector<std::uint8_t> mask(view.size(), 1);
    std::vector<float> visibility(view.size());
    trace_visibility(rays, scene, view, light, mask, options, visibility, control);
    return visibility;
}

TraceOptions rays(int count, std::uint32_t seed = 1) {
    TraceOptions options;
    options.rays_per_pixel = count;
    options.seed = seed;
    return options;
}

/// Blocker at height 1 that covers x < 0, far wider than any light here, over a floor that is no caster.
Scene half_plane(double edge_angle = 0.0) {
    Scene scene;
    scene.instances = {
        test::place(test::square(10)),
        test::place(test::quad({-50, -50, 1}, {0, -50, 1}, {0, 50, 1}, {-50, 50, 1}),
                    glm::rotate(glm::dmat4{1.0}, edge_angle, glm::dvec3(0, 0, 1))),
    };
    scene.instances[0].casts = false;
    return scene;
}

double rms_difference(const std::vector<float>& a, const std::vector<double>& b) {
    double sum = 0.0;
    for (std::size_t i = 0; i < a.size(); ++i) {
        sum += (a[i] - b[i]) * (a[i] - b[i]);
    }
    return std::sqrt(sum / static_cast<double>(a.size()));
}

// --- closed forms ----------------------------------------------------------------------------------------------

TEST(TraceVisibility, UnderAHalfPlaneEdgeIsOneHalfForEveryKindOfLight) {
    Light spot = test::point_light({0, 0, 2}, 0.3);
    spot.kind = LightKind::Spot;
    for (const Light& light :
         {test::rectangle({0, 0, 2}, 0.5, 0.25), test::ellipse({0, 0, 2}, 0.5, 0.25),
          test::line({0, 0, 2}, {0.5, 0, 0}), test::point_light({0, 0, 2}, 0.3), spot, test::sun({0, 0, -1}, 0.2),
          test::polygon({{-0.5, -0.5, 2}, {-0.5, 0.5, 2}, {0.5, 0.5, 2}, {0.5, -0.5, 2}})}) {
        const std::vector<Point> points(64, Point{{0, 0, 0}});
        double mean = 0.0;
        for (const float v : trace(half_plane(), light, points, rays(1024))) {
            EXPECT_NEAR(v, 0.5, 0.02) << light.name;
            mean += v / 64.0;
        }
        EXPECT_NEAR(mean, 0.5, 0.002) << light.name;
    }
}

TEST(TraceVisibility, OfAStripLightIsALinearRampOfWidthDRB) {
    // Light of width D at r above the floor, blocker b below the light: W = D (r - b) / b on the floor.
    const double d = 1.0;
    const double r = 2.0;
    const double b = 1.0;
    const double w = d * (r - b) / b;
    const std::vector<Point> points = test::floor_points({-w, 0}, {w, 0}, 201, 1);
    const std::vector<float> v = trace(half_plane(), test::rectangle({0, 0, r}, d / 2, 0.1), points, rays(4096));
    for (std::size_t i = 0; i < v.size(); ++i) {
        // 64 x 64 strata, the edge runs along a column of them: one column of 64 is in doubt.
        EXPECT_NEAR(v[i], std::clamp(0.5 + points[i].position_ws.x / w, 0.0, 1.0), 5.0 * 0.5 / 64 / 8);
    }
}

TEST(TraceVisibility, OfADiscLightIsTheAreaOfACircularSegment) {
    const std::vector<Point> points = test::floor_points({-0.6, 0}, {0.6, 0}, 101, 1);
    const std::vector<float> v = trace(half_plane(0.4), test::ellipse({0, 0, 2}, 0.5, 0.5), points, rays(4096));
    for (std::size_t i = 0; i < v.size(); ++i) {
        const double t = std::clamp(points[i].position_ws.x * std::cos(0.4) / 0.5, -1.0, 1.0);
        EXPECT_NEAR(v[i], 0.5 + (t * std::sqrt(1 - t * t) + std::asin(t)) / kPi, 0.005)
            << "x " << points[i].position_ws.x;
    }
}

TEST(TraceVisibility, OfASphereBehindADiscOnItsAxisIsARatioOfCaps) {
    for (const double blocker : {0.05, 0.1, 0.2}) {
        Scene scene;
        scene.instances = {test::place(test::disc(static_cast<float>(blocker), 2048), test::moved({0, 0, 1}))};
        const double distance = 3.0;
        const double radius = 0.8;
        const double sphere = 1.0 - std::sqrt(1.0 - radius * radius / (distance * distance));
        const double hidden = 1.0 - 1.0 / std::sqrt(1.0 + blocker * blocker);
        const std::vector<Point> points(16, Point{{0, 0, 0}});
        for (const float v : trace(scene, test::point_light({0, 0, distance}, radius), points, rays(16384))) {
            EXPECT_NEAR(v, std::max(0.0, 1.0 - hidden / sphere), 0.002) << "blocker " << blocker;
        }
    }
}

TEST(TraceVisibility, InsideASphereLightCountsDirections) {
    // The plane z = 1/2 cuts a cap of the unit sphere around the receiver: a quarter of all directions.
    Scene scene;
    scene.instances = {test::place(test::square(2), test::moved({0, 0, 0.5}))};
    for (const float v : trace(scene, test::point_light({0, 0, 0}, 1.0), {{{0, 0, 0}}}, rays(16384))) {
        EXPECT_NEAR(v, 0.75, 0.003);
    }
}

TEST(TraceVisibility, BelowTheHorizonOnlyRealGeometryBlocks) {
    // A receiver on an open sheet, the light wholly or partly below its tangent plane: nothing there to hide it.
    Scene scene;
    scene.instances = {test::place(test::square(0.1F))};
    EXPECT_EQ(trace(scene, test::point_light({3, 0, 0}, 1.0), {{{0, 0, 0}}}, rays(1024))[0], 1.0F);
    // The same receiver on a closed box: the lower half of the sphere is behind the box.
    scene.instances = {test::place(test::cube(1.0F), test::moved({0, 0, -1}))};
    EXPECT_NEAR(trace(scene, test::point_light({3, 0, 0}, 1.0), {{{0, 0, 0}, {0, 0, 1}, 0, 3}}, rays(4096))[0], 0.5,
                0.01);
}

// --- limits and odd places --------------------------------------------------------------------------------------

TEST(TraceVisibility, WithoutCastersIsOne) {
    Scene scene;
    EXPECT_EQ(trace(scene, test::point_light({0, 0, 2}, 0.5), {{{0, 0, 0}, {0, 0, 1}, 0}}, rays(4))[0], 1.0F);
    scene = half_plane();
    scene.instances[1].casts = false;
    for (const float v :
         trace(scene, test::point_light({0, 0, 2}, 0.5), test::floor_points({-1, -1}, {1, 1}, 9, 9), rays(4))) {
        EXPECT_EQ(v, 1.0F);
    }
}

TEST(TraceVisibility, OfALightThatCastsNoShadowIsOne) {
    Light light = test::point_light({-1, 0, 2}, 0.5);
    light.casts_shadow = false;
    EXPECT_EQ(trace(half_plane(), light, {{{-1, 0, 0}}}, rays(4))[0], 1.0F);
}

TEST(TraceVisibility, OutsideTheMaskIsOneAndCostsNoRay) {
    Control control;
    const Scene scene = half_plane();
    const RayScene ray_scene{scene, control};
    const View view = test::view_of({{{-1, 0, 0}}, {{-1, 1, 0}}, {{1, 0, 0}}});
    const std::vector<std::uint8_t> mask{0, 1, 1};
    std::vector<float> v(3);
    const std::uint64_t cast =
        trace_visibility(ray_scene, scene, view, test::rectangle({0, 0, 2}, 0.1, 0.1), mask, rays(9), v, control);
    EXPECT_EQ(v, (std::vector<float>{1.0F, 0.0F, 1.0F}));
    EXPECT_EQ(cast, 18U);
}

TEST(TraceVisibility, OfALightWithoutSizeIsTheHardShadowForAnyNumberOfRays) {
    const std::vector<Point> points = test::floor_points({-1, -1}, {1, 1}, 40, 40);
    for (const Light& light : {test::point_light({0.3, 0, 2}, 0.0), test::sun({0.1, 0, -1}, 0.0),
                               test::rectangle({0.3, 0, 2}, 0.0, 0.0), test::line({0.3, 0, 2}, {0, 0, 0})}) {
        const std::vector<float> once = trace(half_plane(0.3), light, points, rays(1));
        EXPECT_EQ(once, trace(half_plane(0.3), light, points, rays(64, 7))) << light.name;
        for (std::size_t i = 0; i < points.size(); ++i) {
            const glm::dvec3 p = points[i].position_ws;
            const glm::dvec3 at = light.kind == LightKind::Sun ? p + light.direction_ws / light.direction_ws.z
                                                               : 0.5 * (p + light.position_ws);
            const double side = at.x * std::cos(0.3) + at.y * std::sin(0.3);
            if (std::abs(side) > 1e-5) {
                EXPECT_EQ(once[i], side > 0.0 ? 1.0F : 0.0F) << light.name << " at " << p.x << ", " << p.y;
            }
        }
    }
}

TEST(TraceVisibility, ShrinkingTheLightTendsToTheHardShadow) {
    const std::vector<Point> points = test::floor_points({-1, -1}, {1, 1}, 40, 40);
    const std::vector<float> hard = trace(half_plane(0.3), test::point_light({0.3, 0, 2}, 0.0), points, rays(1));
    const std::vector<float> tiny = trace(half_plane(0.3), test::point_light({0.3, 0, 2}, 1e-7), points, rays(16));
    EXPECT_EQ(hard, tiny);
}

TEST(TraceVisibility, GeometryBehindTheLightDoesNotBlock) {
    Scene scene;
    scene.instances = {test::place(test::square(5), test::moved({0, 0, 2.001}))};
    for (const Light& light : {test::rectangle({0, 0, 2}, 0.5, 0.5), test::ellipse({0, 0, 2}, 0.5, 0.5),
                               test::line({0, 0, 2}, {0.5, 0, 0}), test::point_light({0, 0, 2}, 0.0)}) {
        EXPECT_EQ(trace(scene, light, {{{0, 0, 0}}}, rays(1024))[0], 1.0F) << light.name;
    }
}

TEST(TraceVisibility, ThePanelThatSharesTheLightsPlaceDoesNotBlock) {
    for (const double scale : {1e-4, 1.0, 1e4}) {
        Scene scene;
        scene.instances = {test::place(test::square(10)), test::place(test::square(0.5F), test::moved({0, 0, 2}))};
        Light light = test::rectangle({0, 0, 2}, 0.5, 0.5);
        std::vector<Point> points = test::floor_points({-8, -8}, {8, 8}, 64, 64);
        const glm::dmat4 turn = glm::rotate(glm::dmat4{1.0}, 0.7, glm::normalize(glm::dvec3(1, 2, 3)));
        test::transform(test::moved({3e5, -1e6, 7e5}) * glm::scale(turn, glm::dvec3(scale)), scene, light, points);
        for (const float v : trace(scene, light, points, rays(16), 64)) {
            ASSERT_EQ(v, 1.0F) << "scale " << scale;
        }
    }
}

TEST(TraceVisibility, OfALightInsideAClosedCasterIsZeroOutside) {
    Scene scene;
    scene.instances = {test::place(test::cube(0.5F), test::moved({0, 0, 2}))};
    EXPECT_EQ(trace(scene, test::point_light({0, 0, 2}, 0.2), {{{0, 0, 0}}, {{5, 1, 0}}}, rays(256)),
              (std::vector<float>{0.0F, 0.0F}));
}

TEST(TraceVisibility, ThroughMeshedWallsNoRayLeaksAtSharedEdgesAndVertices) {
    // A wall of 64 x 64 cells; receivers and light mirror each other at the wall, so that the rays of a point light
    // meet vertices and edges exactly where float32 allows.
    std::vector<glm::vec3> positions;
    std::vector<glm::uvec3> triangles;
    for (unsigned y = 0; y <= 64; ++y) {
        for (unsigned x = 0; x <= 64; ++x) {
            positions.emplace_back(static_cast<float>(x) - 32.0F, static_cast<float>(y) - 32.0F, 1.0F);
            if (x < 64 && y < 64) {
                const unsigned i = y * 65 + x;
                triangles.emplace_back(i, i + 1, i + 66);
                triangles.emplace_back(i, i + 66, i + 65);
            }
        }
    }
    for (const double angle : {0.0, 0.3, 1.0}) {
        Scene scene;
        scene.instances = {test::place(test::make_mesh(positions, triangles))};
        Light light = test::point_light({0, 0, 2}, 0.0);
        // Steps of half a cell on the wall.
        std::vector<Point> points = test::floor_points({-60, -60}, {60, 60}, 121, 121);
        test::transform(glm::rotate(glm::dmat4{1.0}, angle, glm::normalize(glm::dvec3(1, 2, 3))), scene, light, points);
        for (const float v : trace(scene, light, points, rays(1), 121)) {
            ASSERT_EQ(v, 0.0F) << "turned by " << angle;
        }
    }
}

// --- self-intersection ------------------------------------------------------------------------------------------

/// A convex closed object never shadows a point of its own that has the whole light above its tangent plane.
TEST(TraceVisibility, AConvexObjectDoesNotShadowItselfAtGrazingAngles) {
    struct Shape {
        const char* name;
        std::shared_ptr<Mesh> mesh;
    };
    const std::vector<Shape> shapes = {{"cube", test::cube(1.0F)},
                                       {"coarse sphere", test::sphere(1.0F, 8, 12)},
                                       {"fine sphere", test::sphere(1.0F, 96, 192)}};
    const glm::dmat4 turn = glm::rotate(glm::dmat4{1.0}, 0.7, glm::normalize(glm::dvec3(1, 2, 3)));
    const glm::dmat4 squash = glm::scale(glm::dmat4{1.0}, glm::dvec3(1.0, 3.0, 0.01));
    const glm::dmat4 mirror = glm::scale(glm::dmat4{1.0}, glm::dvec3(-1.0, 1.0, 1.0));
    for (const Shape& shape : shapes) {
        for (const double scale : {1e-4, 1.0, 1e4}) {
            for (const glm::dvec3 move : {glm::dvec3(0.0), glm::dvec3(1e6, -3e5, 2e5)}) {
                for (const glm::dmat4& form : {glm::dmat4{1.0}, squash, mirror}) {
                    Scene scene;
                    scene.instances = {test::place(shape.mesh, form)};
                    std::vector<Point> points =
                        test::surface_points(scene, 0, shape.mesh->triangles.size() > 999 ? 1 : 100);
                    Light light = test::sun({-1.0, -0.37, -1e-3}, 0.0);
                    test::transform(test::moved(move) * glm::scale(turn, glm::dvec3(scale)), scene, light, points);
                    // The rounding of the normals alone is 1e-7; 1e-5 is a thousandth of a degree.
                    std::erase_if(points,
                                  [&](const Point& p) { return glm::dot(p.normal_ws, light.direction_ws) > -1e-5; });
                    ASSERT_GT(points.size(), 100U);
                    int wrong = 0;
                    for (const float v : trace(scene, light, points, rays(1))) {
                        wrong += v < 1.0F ? 1 : 0;
                    }
                    EXPECT_EQ(wrong, 0) << shape.name << ", scale " << scale << ", moved by " << move.x << ", of "
                                        << points.size();
                }
            }
        }
    }
}

TEST(TraceVisibility, ALargeTurnedPlaneHasNoAcneUnderGrazingLight) {
    for (const double half : {1e-3, 1.0, 1e5}) {
        for (const double angle : {0.0, 0.3, 0.7, 1.1}) {
            for (const double altitude : {1e-4, 1e-2, 1.0}) {
                Scene scene;
                scene.instances = {test::place(test::square(static_cast<float>(half)))};
                std::vector<Point> points = test::floor_points({-half, -half}, {half, half}, 60, 60);
                Light light = test::sun({-std::cos(altitude), 0, -std::sin(altitude)}, 0.0);
                test::transform(glm::rotate(glm::dmat4{1.0}, angle, glm::normalize(glm::dvec3(1, 2, 3))), scene, light,
                                points);
                for (const float v : trace(scene, light, points, rays(1), 60)) {
                    ASSERT_EQ(v, 1.0F) << "half size " << half << ", turned by " << angle << ", altitude " << altitude;
                }
            }
        }
    }
}

// --- invariances ------------------------------------------------------------------------------------------------

/// Some boxes and a sphere over a floor.
Scene clutter() {
    Scene scene;
    const auto box = test::cube(0.2F);
    scene.instances = {test::place(test::square(3))};
    for (int i = 0; i < 12; ++i) {
        const glm::dmat4 turn = glm::rotate(test::moved({std::cos(2.4 * i), std::sin(2.4 * i) * 0.8, 0.3 + 0.05 * i}),
                                            0.9 * i, glm::normalize(glm::dvec3(1, i, 2)));
        scene.instances.push_back(test::place(test::cube(0.2F), turn));
    }
    scene.instances.push_back(test::place(test::sphere(0.3F, 16, 24), test::moved({0, 0, 0.5})));
    return scene;
}

TEST(TraceVisibility, OfAContactAtOneTenThousandthOfTheSceneIsOffByTheLiftOfTheRaysAlone) {
    // A ramp of V = 1/2 + x / h under an edge at the height h. A ray's start is lifted off the floor, so the ramp is
    // that of h less the lift: 4 roundings of the floor's size are 0.5 % of it, and more would show on every crease.
    constexpr double kHeight = 1e-4;
    Scene scene;
    scene.instances = {
        test::place(test::square(1)),
        test::place(test::quad({-1, -1, 0}, {0, -1, 0}, {0, 1, 0}, {-1, 1, 0}), test::moved({0, 0, kHeight}))};
    const std::vector<Point> points = test::floor_points({-0.45 * kHeight, -0.1}, {0.45 * kHeight, 0.1}, 16, 8);
    const std::vector<float> v = trace(scene, test::rectangle({0, 0, 1}, 0.5, 0.5), points, rays(1024), 16);
    double along = 0.0;
    double squares = 0.0;
    for (std::size_t i = 0; i < points.size(); ++i) {
        const double x = points[i].position_ws.x / kHeight;
        along += (v[i] - 0.5) * x;
        squares += x * x;
    }
    EXPECT_NEAR(along / squares, 1.0, 0.008);
}

TEST(TraceVisibility, IsTheSameForASceneScaledMovedAndTurned) {
    const std::vector<Point> floor = test::floor_points({-2, -2}, {2, 2}, 100, 100);
    const Light above = test::rectangle({0.4, 0.3, 2.5}, 0.4, 0.3);
    const std::vector<float> original = trace(clutter(), above, floor, rays(64), 100);
    const glm::dmat4 turn = glm::rotate(glm::dmat4{1.0}, 0.7, glm::normalize(glm::dvec3(1, 2, 3)));
    const glm::dmat4 far = test::moved({1e6, -1e6, 1e6});
    for (const glm::dmat4& by :
         {glm::scale(glm::dmat4{1.0}, glm::dvec3(1e-4)), glm::scale(glm::dmat4{1.0}, glm::dvec3(1e4)), far, turn,
          far * turn, glm::scale(turn, glm::dvec3(3e-4))}) {
        Scene scene = clutter();
        Light light = above;
        std::vector<Point> points = floor;
        test::transform(by, scene, light, points);
        const std::vector<float> v = trace(scene, light, points, rays(64), 100);
        int changed = 0;
        for (std::size_t i = 0; i < v.size(); ++i) {
            changed += v[i] != original[i] ? 1 : 0;
            // The same samples, so only rays within float32 rounding of an edge may turn: at most two of 64 here.
            ASSERT_LE(std::abs(v[i] - original[i]), 2.01F / 64.0F);
        }
        EXPECT_LE(changed, 20) << "of 10000 pixels with 64 rays each";
    }
}

TEST(TraceVisibility, OfInstancesEqualsThatOfCopies) {
    const auto shared = test::sphere(0.2F, 24, 32);
    Scene instanced;
    Scene copied;
    instanced.instances = {test::place(test::square(3))};
    copied.instances = instanced.instances;
    for (int i = 0; i < 12; ++i) {
        const glm::dmat4 at =
            glm::scale(glm::rotate(test::moved({std::cos(2.4 * i), std::sin(2.4 * i), 0.3 + 0.05 * i}), 0.9 * i,
                                   glm::normalize(glm::dvec3(1, i, 2))),
                       glm::dvec3(i % 2 == 0 ? 1.0 : -1.5, 1.0, 1.0 + 0.1 * i));
        instanced.instances.push_back(test::place(shared, at));
        copied.instances.push_back(test::place(test::sphere(0.2F, 24, 32), at));
    }
    Control control;
    EXPECT_EQ((RayScene{instanced, control}.instanced_count()), 12U);
    EXPECT_EQ((RayScene{copied, control}.instanced_count()), 0U);
    const std::vector<Point> floor = test::floor_points({-2, -2}, {2, 2}, 100, 100);
    const Light light = test::rectangle({0.4, 0.3, 2.5}, 0.4, 0.3);
    const std::vector<float> a = trace(instanced, light, floor, rays(64), 100);
    const std::vector<float> b = trace(copied, light, floor, rays(64), 100);
    int changed = 0;
    for (std::size_t i = 0; i < a.size(); ++i) {
        changed += a[i] != b[i] ? 1 : 0;
        ASSERT_LE(std::abs(a[i] - b[i]), 2.01F / 64.0F);
    }
    EXPECT_LE(changed, 20);
    // On the instances themselves no acne either.
    Light low = test::sun({-1, -0.4, -0.05}, 0.0);
    for (int instance = 1; instance <= 12; ++instance) {
        Scene alone = instanced;
        alone.instances = {instanced.instances[static_cast<std::size_t>(instance)],
                           test::place(shared, test::moved({100, 0, 0}))};
        std::vector<Point> points = test::surface_points(alone, 0, 2);
        std::erase_if(points, [&](const Point& p) { return glm::dot(p.normal_ws, low.direction_ws) > -1e-5; });
        for (const float v : trace(alone, low, points, rays(1))) {
            ASSERT_EQ(v, 1.0F) << "instance " << instance;
        }
    }
}

TEST(TraceVisibility, IsTheSameForAnyNumberOfThreadsAndDiffersBetweenSeeds) {
    const std::vector<Point> floor = test::floor_points({-2, -2}, {2, 2}, 100, 100);
    const Light light = test::ellipse({0.4, 0.3, 2.5}, 0.4, 0.3);
    for (const int count : {1, 3, 16, 20}) {
        set_thread_count(1);
        const std::vector<float> one = trace(clutter(), light, floor, rays(count), 100);
        set_thread_count(7);
        const std::vector<float> seven = trace(clutter(), light, floor, rays(count), 100);
        set_thread_count(0);
        EXPECT_EQ(one, seven) << count << " rays";
        EXPECT_NE(one, trace(clutter(), light, floor, rays(count, 2), 100)) << count << " rays";
    }
}

// --- convergence ------------------------------------------------------------------------------------------------

/// Slope of log RMSE over log N between 4 and 1024 rays, edges at all angles and positions through the penumbra.
double slope(const Light& light, SamplePattern pattern) {
    std::vector<double> log_n;
    std::vector<double> log_error;
    constexpr int kEdges = 24;
    // The truth from 16384 rays: its own error is an eighth of that at 1024.
    std::vector<std::vector<Point>> points;
    std::vector<std::vector<double>> truth;
    std::vector<Scene> scenes;
    for (int e = 0; e < kEdges; ++e) {
        const double angle = 2.0 * kPi * (e + 0.37) / kEdges;
        scenes.push_back(half_plane(angle));
        std::vector<Point> across = test::floor_points({-0.45, 0}, {0.45, 0}, 64, 1);
        for (Point& p : across) {
            p.position_ws =
                glm::dvec3(glm::rotate(glm::dmat4{1.0}, angle, glm::dvec3(0, 0, 1)) * glm::dvec4(p.position_ws, 1));
        }
        const std::vector<float> v = trace(scenes.back(), light, across, rays(16384, 99));
        truth.emplace_back(v.begin(), v.end());
        points.push_back(std::move(across));
    }
    for (const int side : {2, 4, 8, 16, 32}) {
        TraceOptions options = rays(side * side, 5);
        options.pattern = pattern;
        double sum = 0.0;
        for (int e = 0; e < kEdges; ++e) {
            const double rms = rms_difference(trace(scenes[e], light, points[e], options), truth[e]);
            sum += rms * rms / kEdges;
        }
        log_n.push_back(std::log(side * side));
        log_error.push_back(0.5 * std::log(sum));
    }
    const auto n = static_cast<double>(log_n.size());
    double sx = 0.0;
    double sy = 0.0;
    double sxx = 0.0;
    double sxy = 0.0;
    for (std::size_t i = 0; i < log_n.size(); ++i) {
        sx += log_n[i];
        sy += log_error[i];
        sxx += log_n[i] * log_n[i];
        sxy += log_n[i] * log_error[i];
    }
    const double result = (n * sxy - sx * sy) / (n * sxx - sx * sx);
    testing::Test::RecordProperty("slope", std::to_string(result));
    testing::Test::RecordProperty("constant", std::to_string(std::exp((sy - result * sx) / n)));
    return result;
}

TEST(Convergence, OfAStratifiedSquareLightIsNToTheMinusThreeQuarters) {
    EXPECT_NEAR(slope(test::rectangle({0, 0, 2}, 0.5, 0.5), SamplePattern::Stratified), -0.75, 0.07);
}

TEST(Convergence, OfAStratifiedDiscLightIsNToTheMinusThreeQuarters) {
    EXPECT_NEAR(slope(test::ellipse({0, 0, 2}, 0.5, 0.5), SamplePattern::Stratified), -0.75, 0.07);
}

TEST(Convergence, OfAStratifiedSphereLightIsNToTheMinusThreeQuarters) {
    EXPECT_NEAR(slope(test::point_light({0, 0, 2}, 0.5), SamplePattern::Stratified), -0.75, 0.07);
}

TEST(Convergence, OfAStratifiedPolygonLightIsNToTheMinusThreeQuarters) {
    EXPECT_NEAR(slope(test::polygon({{-0.5, -0.5, 2}, {-0.5, 0.5, 2}, {0.5, 0.5, 2}, {0.6, 0, 2}, {0.5, -0.5, 2}}),
                      SamplePattern::Stratified),
                -0.75, 0.07);
}

TEST(Convergence, OfAStratifiedLineLightIsOneOverN) {
    EXPECT_NEAR(slope(test::line({0, 0, 2}, {0.5, 0.2, 0}), SamplePattern::Stratified), -1.0, 0.07);
}

TEST(Convergence, OfIndependentSamplesIsOneOverTheRootOfN) {
    EXPECT_NEAR(slope(test::rectangle({0, 0, 2}, 0.5, 0.5), SamplePattern::Random), -0.5, 0.05);
}

TEST(EarlyOut, SavesRaysAndItsBiasStaysBelowTheOneDocumented) {
    Control control;
    const Scene scene = half_plane();
    const RayScene ray_scene{scene, control};
    const Light light = test::rectangle({0, 0, 2}, 0.5, 0.5);
    // 400 x 25 pixels across the penumbra and beyond it.
    std::vector<Point> points = test::floor_points({-1.0, -0.3}, {1.0, 0.3}, 400, 25);
    const View view = test::view_of(points, 400);
    const std::vector<std::uint8_t> mask(view.size(), 1);
    std::vector<float> v(view.size());
    TraceOptions options = rays(64);
    options.early_out = true;
    options.early_out_rays = 16;
    const std::uint64_t cast = trace_visibility(ray_scene, scene, view, light, mask, options, v, control);
    EXPECT_LT(cast, 64U * view.size() * 7 / 10);
    for (int x = 0; x < 400; ++x) {
        double mean = 0.0;
        for (int y = 0; y < 25; ++y) {
            mean += v[static_cast<std::size_t>(y) * 400 + x] / 25.0;
        }
        const double truth = std::clamp(0.5 + points[x].position_ws.x, 0.0, 1.0);
        // 25 pixels leave a standard deviation of at most 0.25 / sqrt(16 * 25), taken five times.
        EXPECT_NEAR(mean, truth, 0.75 * 0.022 + 0.0625) << "x " << points[x].position_ws.x;
    }
}

TEST(TraceVisibility, StopsWithCancelled) {
    Control control;
    const Scene scene = clutter();
    const RayScene ray_scene{scene, control};
    const View view = test::view_of(test::floor_points({-2, -2}, {2, 2}, 256, 256), 256);
    const std::vector<std::uint8_t> mask(view.size(), 1);
    std::vector<float> v(view.size());
    std::jthread canceller{[&] {
        while (control.progress() <= 0.0F) {
            std::this_thread::yield();
        }
        control.cancel();
    }};
    EXPECT_THROW(
        trace_visibility(ray_scene, scene, view, test::rectangle({0, 0, 2}, 0.5, 0.5), mask, rays(4096), v, control),
        Cancelled);
    EXPECT_LT(control.progress(), 0.5F);
}

}  // namespace
}  // namespace penumbra
