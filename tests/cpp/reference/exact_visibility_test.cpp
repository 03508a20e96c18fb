#include "reference/exact_visibility.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <numbers>
#include <random>

namespace penumbra {
namespace {

constexpr double kPi = std::numbers::pi;

struct Shape {
    std::vector<glm::vec3> positions;
    std::vector<glm::uvec3> triangles;

    void triangle(const glm::vec3& a, const glm::vec3& b, const glm::vec3& c) {
        const auto first = static_cast<std::uint32_t>(positions.size());
        positions.insert(positions.end(), {a, b, c});
        triangles.emplace_back(first, first + 1, first + 2);
    }
    void quad(const glm::vec3& a, const glm::vec3& b, const glm::vec3& c, const glm::vec3& d) {
        triangle(a, b, c);
        triangle(a, c, d);
    }
};

Instance instance_of(const Shape& shape, const glm::dmat4& world_from_local = glm::dmat4{1.0}) {
    auto mesh = std::make_shared<Mesh>();
    mesh->name = "shape";
    mesh->positions_local = shape.positions;
    mesh->triangles = shape.triangles;
    Instance instance;
    instance.name = "shape";
    instance.mesh = mesh;
    instance.world_from_local = world_from_local;
    return instance;
}

Scene scene_of(const Shape& shape, const glm::dmat4& world_from_local = glm::dmat4{1.0}) {
    Scene scene;
    scene.instances.push_back(instance_of(shape, world_from_local));
    return scene;
}

/// Square of half width 1 at height 2, shining down.
Light ceiling(double height = 2.0, double half = 1.0) {
    Light light;
    light.name = "ceiling";
    light.kind = LightKind::Rectangle;
    light.position_ws = {0.0, 0.0, height};
    light.direction_ws = {0.0, 0.0, -1.0};
    light.half_u_ws = {half, 0.0, 0.0};
    light.half_v_ws = {0.0, half, 0.0};
    return light;
}

ExactResult exact(const Scene& scene, const Light& light, const std::vector<glm::dvec3>& points,
                  const glm::dvec3& normal = {0.0, 0.0, 1.0}) {
    Control control;
    const std::vector<glm::dvec3> normals(points.size(), normal);
    return exact_visibility(scene, light, points, normals, control);
}

double area(const Scene& scene, const Light& light, const glm::dvec3& point) {
    return exact(scene, light, {point}).area[0];
}

/// V and irradiance ratio by a fine midpoint grid over a rectangle light and float64 ray-triangle tests.
ExactPoint::Result brute_force(const Shape& shape, const Light& light, const glm::dvec3& x, const glm::dvec3& n,
                               int grid) {
    double seen = 0.0;
    double weight_seen = 0.0;
    double weight = 0.0;
    for (int i = 0; i < grid; ++i) {
        for (int j = 0; j < grid; ++j) {
            const glm::dvec3 q = light.position_ws + (2.0 * (i + 0.5) / grid - 1.0) * light.half_u_ws +
                                 (2.0 * (j + 0.5) / grid - 1.0) * light.half_v_ws;
            const glm::dvec3 d = q - x;
            bool blocked = false;
            for (const glm::uvec3& t : shape.triangles) {
                const glm::dvec3 a = glm::dvec3{shape.positions[t.x]} - x;
                const glm::dvec3 b = glm::dvec3{shape.positions[t.y]} - x;
                const glm::dvec3 c = glm::dvec3{shape.positions[t.z]} - x;
                const double u = glm::dot(d, glm::cross(a, b));
                const double v = glm::dot(d, glm::cross(b, c));
                const double w = glm::dot(d, glm::cross(c, a));
                if ((u >= 0 && v >= 0 && w >= 0) || (u <= 0 && v <= 0 && w <= 0)) {
                    const glm::dvec3 normal = glm::cross(b - a, c - a);
                    const double distance = glm::dot(normal, a) / glm::dot(normal, d);
                    blocked = blocked || (distance > 1e-9 && distance < 1.0 - 1e-9);
                }
            }
            const double r2 = glm::dot(d, d);
            const double k =
                std::max(0.0, glm::dot(n, d)) * std::max(0.0, -glm::dot(light.direction_ws, d)) / (r2 * r2);
            weight += k;
            seen += blocked ? 0.0 : 1.0;
            weight_seen += blocked ? 0.0 : k;
        }
    }
    return {seen / (grid * grid), weight > 0.0 ? weight_seen / weight : 1.0};
}

TEST(ExactVisibility, EmptySceneIsFullyLit) {
    const ExactResult result = exact(Scene{}, ceiling(), {{0.0, 0.0, 0.0}, {5.0, 1.0, 1.0}});
    for (int i = 0; i < 2; ++i) {
        EXPECT_EQ(result.area[i], 1.0);
        EXPECT_EQ(result.irradiance[i], 1.0);
    }
}

TEST(ExactVisibility, HalfPlaneGivesALinearRampOfWidthLhOverHMinusH) {
    // Edge at x = 0, height h; light of width L = 2 at H: the ramp is L h / (H - h) wide around the edge.
    Shape shape;
    shape.quad({0.0F, -64.0F, 0.5F}, {64.0F, -64.0F, 0.5F}, {64.0F, 64.0F, 0.5F}, {0.0F, 64.0F, 0.5F});
    const Scene scene = scene_of(shape);
    const double width = 2.0 * 0.5 / (2.0 - 0.5);
    std::vector<glm::dvec3> points;
    for (int i = -60; i <= 60; ++i) {
        points.emplace_back(i / 100.0, 0.3, 0.0);
    }
    const ExactResult result = exact(scene, ceiling(), points);
    for (std::size_t i = 0; i < points.size(); ++i) {
        EXPECT_NEAR(result.area[i], std::clamp(0.5 - points[i].x / width, 0.0, 1.0), 1e-12) << points[i].x;
    }
}

TEST(ExactVisibility, TurnedHalfPlaneCutsTheSquareAtAnAngle) {
    // At 45 degrees the ramp is parabola, line, parabola; here at its ends and middle in closed form.
    Shape shape;
    shape.quad({-64.0F, 64.0F, 0.5F}, {64.0F, -64.0F, 0.5F}, {64.0F, 64.0F, 0.5F}, {63.0F, 64.0F, 0.5F});
    const Scene scene = scene_of(shape);
    for (int i = -20; i <= 20; ++i) {
        const double s = i / 20.0 * 2.2;  // the projected edge is u + v = s on the light
        // Blocker x + y >= 0 at height 1/4 of the way: the light point seen at the edge is x + (0 - x) * 4.
        const double sum = -s / 3.0;
        const double hidden = s >= 2.0    ? 0.0
                              : s <= -2.0 ? 4.0
                              : s >= 0.0  ? 0.5 * (2.0 - s) * (2.0 - s)
                                          : 4.0 - 0.5 * (2.0 + s) * (2.0 + s);
        EXPECT_NEAR(area(scene, ceiling(), {0.5 * sum, 0.5 * sum, 0.0}), 1.0 - hidden / 4.0, 1e-12) << s;
    }
}

TEST(ExactVisibility, CrossedHalfPlanesAtDifferentHeightsFuse) {
    Shape shape;
    shape.quad({0.0F, -64.0F, 0.5F}, {64.0F, -64.0F, 0.5F}, {64.0F, 64.0F, 0.5F}, {0.0F, 64.0F, 0.5F});
    shape.quad({-64.0F, 0.0F, 1.0F}, {64.0F, 0.0F, 1.0F}, {64.0F, 64.0F, 1.0F}, {-64.0F, 64.0F, 1.0F});
    const Scene scene = scene_of(shape);
    for (int i = -10; i <= 10; ++i) {
        for (int j = -10; j <= 10; ++j) {
            const glm::dvec3 x{i * 0.04, j * 0.11, 0.0};
            const double u = std::clamp(0.5 - x.x / (2.0 * 0.5 / 1.5), 0.0, 1.0);
            const double v = std::clamp(0.5 - x.y / (2.0 * 1.0 / 1.0), 0.0, 1.0);
            EXPECT_NEAR(area(scene, ceiling(), x), u * v, 1e-12);
        }
    }
}

TEST(ExactVisibility, FenceOfSlatsHidesTheSumOfItsSlats) {
    Shape shape;
    for (int i = 0; i < 32; ++i) {
        const auto from = static_cast<float>(-1.0 + i / 16.0);
        const float to = from + 0.0234375F;  // 3/8 of the pitch
        shape.quad({from, -8.0F, 1.0F}, {to, -8.0F, 1.0F}, {to, 8.0F, 1.0F}, {from, 8.0F, 1.0F});
    }
    const Scene scene = scene_of(shape);
    // Half way up the light's width 2 projects to 1 = 16 pitches, wherever the point is.
    for (int i = -5; i <= 5; ++i) {
        EXPECT_NEAR(area(scene, ceiling(), {i * 0.0371, 0.1 * i, 0.0}), 0.625, 1e-12);
    }
}

TEST(ExactVisibility, AxisParallelRectangleHidesItsProjectedOverlap) {
    Shape shape;
    shape.quad({-0.25F, -0.5F, 0.5F}, {0.5F, -0.5F, 0.5F}, {0.5F, 0.125F, 0.5F}, {-0.25F, 0.125F, 0.5F});
    const Scene scene = scene_of(shape);
    std::mt19937 random{3};
    std::uniform_real_distribution<double> in{-1.0, 1.0};
    for (int i = 0; i < 300; ++i) {
        const glm::dvec3 x{in(random), in(random), 0.0};
        const auto project = [](double blocker, double receiver) { return receiver + 4.0 * (blocker - receiver); };
        const double u = std::min(1.0, project(0.5, x.x)) - std::max(-1.0, project(-0.25, x.x));
        const double v = std::min(1.0, project(0.125, x.y)) - std::max(-1.0, project(-0.5, x.y));
        EXPECT_NEAR(area(scene, ceiling(), x), 1.0 - std::max(0.0, u) * std::max(0.0, v) / 4.0, 1e-12);
    }
}

TEST(ExactVisibility, PointsOnAMeshAreNotHiddenByTheirOwnTriangles) {
    // A turned and scaled icosahedron-like blob: points in float64 on its float32 triangles, light above.
    Shape shape;
    std::mt19937 random{5};
    const int rings = 12;
    const int segments = 24;
    const auto at = [&](int r, int s) {
        const double theta = kPi * r / rings;
        const double phi = 2.0 * kPi * s / segments;
        return glm::vec3{std::sin(theta) * std::cos(phi), std::sin(theta) * std::sin(phi), std::cos(theta)};
    };
    for (int r = 0; r < rings; ++r) {
        for (int s = 0; s < segments; ++s) {
            shape.quad(at(r, s), at(r + 1, s), at(r + 1, s + 1), at(r, s + 1));
        }
    }
    glm::dmat4 world{1.0};
    world[0] = {0.36, 0.48, -0.8, 0.0};
    world[1] = {-0.8, 0.6, 0.0, 0.0};
    world[2] = {0.48, 0.64, 0.6, 0.0};
    world[3] = {1e3, -2e3, 37.0, 1.0};
    const Scene scene = scene_of(shape, world);
    Light light = ceiling(39.5, 0.3);
    light.position_ws += glm::dvec3{1e3, -2e3, 0.0};
    std::uniform_real_distribution<double> share{0.0, 1.0};
    int tested = 0;
    for (const glm::uvec3& t : shape.triangles) {
        const auto corner = [&](std::uint32_t i) {
            return glm::dvec3{world * glm::dvec4{glm::dvec3{shape.positions[i]}, 1.0}};
        };
        const glm::dvec3 a = corner(t.x);
        const glm::dvec3 cross = glm::cross(corner(t.y) - a, corner(t.z) - a);
        if (!(glm::length(cross) > 1e-6)) {
            continue;
        }
        const glm::dvec3 normal = glm::normalize(cross);
        const double s = share(random);
        const double q = share(random) * (1.0 - s);
        const glm::dvec3 x = a + s * (corner(t.y) - a) + q * (corner(t.z) - a);
        // A convex body hides nothing from points that have the whole light above their plane.
        bool above = true;
        for (int k = 0; k < 4; ++k) {
            const glm::dvec3 q_ws =
                light.position_ws + (k % 2 ? 1.0 : -1.0) * light.half_u_ws + (k / 2 ? 1.0 : -1.0) * light.half_v_ws;
            above = above && glm::dot(normal, q_ws - x) > 0.0;
        }
        if (above) {
            const ExactResult result = exact(scene, light, {x}, normal);
            EXPECT_EQ(result.area[0], 1.0);
            EXPECT_EQ(result.irradiance[0], 1.0);
            ++tested;
        }
    }
    EXPECT_GT(tested, 50);
}

TEST(ExactVisibility, BlockerTouchingTheReceiverSplitsAtItsFoot) {
    // A wall standing on the floor along x = 0; its foot is the limit of a penumbra of width 0.
    Shape shape;
    shape.quad({0.0F, -64.0F, 0.0F}, {0.0F, 64.0F, 0.0F}, {0.0F, 64.0F, 64.0F}, {0.0F, -64.0F, 64.0F});
    Light light = ceiling();
    light.position_ws.x = 3.0;
    for (const double distance : {1.0, 1e-3, 1e-6, 1e-7}) {
        EXPECT_NEAR(area(scene_of(shape), light, {distance, 0.0, 0.0}), 1.0, 1e-12) << distance;
        EXPECT_NEAR(area(scene_of(shape), light, {-distance, 0.0, 0.0}), 0.0, 1e-12) << distance;
    }
    EXPECT_EQ(area(scene_of(shape), light, {0.0, 0.0, 0.0}), 1.0) << "the wall's plane holds the point";
}

TEST(ExactVisibility, BlockersAtAndBeyondTheLightHideNothing) {
    Shape shape;
    shape.quad({-4.0F, -4.0F, 2.0F}, {4.0F, -4.0F, 2.0F}, {4.0F, 4.0F, 2.0F}, {-4.0F, 4.0F, 2.0F});
    shape.quad({-4.0F, -4.0F, 3.0F}, {4.0F, -4.0F, 3.0F}, {4.0F, 4.0F, 3.0F}, {-4.0F, 4.0F, 3.0F});
    shape.quad({-4.0F, -4.0F, -1.0F}, {4.0F, -4.0F, -1.0F}, {4.0F, 4.0F, -1.0F}, {-4.0F, 4.0F, -1.0F});
    EXPECT_EQ(area(scene_of(shape), ceiling(), {0.1, 0.2, 0.0}), 1.0);
}

TEST(ExactVisibility, BlockerThroughTheLightPlaneHidesWhatIsBehindIt) {
    // An upright wall at x = 0 through the light's middle, from below to above it.
    Shape shape;
    shape.quad({0.0F, -64.0F, 1.0F}, {0.0F, 64.0F, 1.0F}, {0.0F, 64.0F, 3.0F}, {0.0F, -64.0F, 3.0F});
    // From x > 0 the wall hides the light's other half, from (x, 0) past the wall's foot at height 1.
    for (const double x : {0.2, 0.5, 0.9}) {
        const double foot = x + 2.0 * (0.0 - x);  // where the foot projects to
        EXPECT_NEAR(area(scene_of(shape), ceiling(), {x, 0.0, 0.0}), 1.0 - (0.0 - std::max(-1.0, foot)) / 2.0, 1e-8);
    }
}

TEST(ExactVisibility, ReceiverInTheLightPlaneSeesAllByDefinition) {
    Shape shape;
    shape.quad({1.5F, -4.0F, 0.0F}, {1.5F, 4.0F, 0.0F}, {1.5F, 4.0F, 4.0F}, {1.5F, -4.0F, 4.0F});
    const ExactResult result = exact(scene_of(shape), ceiling(), {{2.0, 0.0, 2.0}, {0.0, 0.0, 2.0}});
    EXPECT_EQ(result.area[0], 1.0);
    EXPECT_EQ(result.area[1], 1.0);
    EXPECT_EQ(result.irradiance[0], 1.0);
}

TEST(ExactVisibility, BehindTheLightVIsGeometricAndTheIrradianceRatioOne) {
    Shape shape;
    shape.quad({0.0F, -64.0F, 3.0F}, {64.0F, -64.0F, 3.0F}, {64.0F, 64.0F, 3.0F}, {0.0F, 64.0F, 3.0F});
    const ExactResult result = exact(scene_of(shape), ceiling(), {{0.0, 0.0, 4.0}}, {0.0, 0.0, -1.0});
    EXPECT_NEAR(result.area[0], 0.5, 1e-15);
    EXPECT_EQ(result.irradiance[0], 1.0);
}

TEST(ExactVisibility, LightWithoutShadowIsFullyVisible) {
    Shape shape;
    shape.quad({-4.0F, -4.0F, 1.0F}, {4.0F, -4.0F, 1.0F}, {4.0F, 4.0F, 1.0F}, {-4.0F, 4.0F, 1.0F});
    Light light = ceiling();
    EXPECT_EQ(area(scene_of(shape), light, {0.0, 0.0, 0.0}), 0.0);
    light.casts_shadow = false;
    EXPECT_EQ(area(scene_of(shape), light, {0.0, 0.0, 0.0}), 1.0);
}

TEST(ExactVisibility, AgreesWithBruteForceInAreaAndIrradiance) {
    std::mt19937 random{17};
    std::uniform_real_distribution<float> in{-1.0F, 1.0F};
    double worst_area = 0.0;
    double worst_irradiance = 0.0;
    for (int round = 0; round < 40; ++round) {
        Shape shape;
        for (int i = 0; i < 12; ++i) {
            const glm::vec3 at{in(random), in(random), 1.0F + 0.9F * in(random)};
            const auto near = [&] { return at + 0.4F * glm::vec3{in(random), in(random), in(random)}; };
            shape.triangle(near(), near(), near());
        }
        const Light light = ceiling();
        const glm::dvec3 x{in(random), in(random), -0.1};
        const glm::dvec3 normal = glm::normalize(glm::dvec3{in(random), in(random), in(random)});
        const ExactResult ours = exact(scene_of(shape), light, {x}, normal);
        const ExactPoint::Result brute = brute_force(shape, light, x, normal, 100);
        worst_area = std::max(worst_area, std::abs(ours.area[0] - brute.area));
        worst_irradiance = std::max(worst_irradiance, std::abs(ours.irradiance[0] - brute.irradiance));
    }
    // A midpoint grid of 100^2 errs by about perimeter / 100^1.5 in V, more where few cells lie above the horizon.
    EXPECT_LT(worst_area, 5e-3);
    EXPECT_LT(worst_irradiance, 3e-2);
}

TEST(ExactVisibility, PolygonEqualsRectangleOfTheSameCorners) {
    Shape shape;
    std::mt19937 random{19};
    std::uniform_real_distribution<float> in{-1.0F, 1.0F};
    for (int i = 0; i < 30; ++i) {
        const glm::vec3 at{in(random), in(random), 1.0F + 0.5F * in(random)};
        shape.triangle(at, at + 0.3F * glm::vec3{in(random), in(random), in(random)},
                       at + 0.3F * glm::vec3{in(random), in(random), in(random)});
    }
    const Light rectangle = ceiling();
    Light polygon = rectangle;
    polygon.kind = LightKind::Polygon;
    // Seen from below, with a corner in the middle of one side.
    polygon.corners_ws = {{-1.0, -1.0, 2.0}, {-1.0, 0.25, 2.0}, {-1.0, 1.0, 2.0}, {1.0, 1.0, 2.0}, {1.0, -1.0, 2.0}};
    std::vector<glm::dvec3> points;
    for (int i = 0; i < 100; ++i) {
        points.emplace_back(in(random), in(random), 0.0);
    }
    const glm::dvec3 normal = glm::normalize(glm::dvec3{0.9, 0.3, 0.2});  // its horizon cuts the light
    const ExactResult a = exact(scene_of(shape), rectangle, points, normal);
    const ExactResult b = exact(scene_of(shape), polygon, points, normal);
    for (std::size_t i = 0; i < points.size(); ++i) {
        EXPECT_NEAR(a.area[i], b.area[i], 1e-12);
        EXPECT_NEAR(a.irradiance[i], b.irradiance[i], 1e-12);
    }
}

TEST(ExactVisibility, ScaleAndPlaceOfTheSceneDoNotMatter) {
    Shape shape;
    std::mt19937 random{23};
    std::uniform_real_distribution<float> in{-1.0F, 1.0F};
    for (int i = 0; i < 30; ++i) {
        const glm::vec3 at{in(random), in(random), 1.0F + 0.5F * in(random)};
        shape.triangle(at, at + 0.3F * glm::vec3{in(random), in(random), in(random)},
                       at + 0.3F * glm::vec3{in(random), in(random), in(random)});
    }
    std::vector<glm::dvec3> points;
    for (int i = 0; i < 50; ++i) {
        points.emplace_back(in(random), in(random), 0.0);
    }
    const glm::dvec3 normal = glm::normalize(glm::dvec3{0.9, 0.3, 0.2});
    const ExactResult plain = exact(scene_of(shape), ceiling(), points, normal);
    for (const double scale : {1e-4, 1e-2, 1.0, 1e4}) {
        for (const double offset : {0.0, 1e6}) {
            glm::dmat4 world{scale};
            world[3] = {offset, -offset, offset, 1.0};
            Light light = ceiling();
            const glm::dvec3 move{world[3]};
            light.position_ws = light.position_ws * scale + move;
            light.half_u_ws *= scale;
            light.half_v_ws *= scale;
            std::vector<glm::dvec3> moved;
            for (const glm::dvec3& point : points) {
                moved.push_back(point * scale + move);
            }
            const ExactResult result = exact(scene_of(shape, world), light, moved, normal);
            // At 1e6 a float64 world coordinate has steps of 1.2e-10 m; the bound is that over the light's size.
            const double bound = std::max(1e-12, 40.0 * 1.2e-10 * (offset / 1e6) / scale);
            for (std::size_t i = 0; i < points.size(); ++i) {
                EXPECT_NEAR(result.area[i], plain.area[i], bound) << scale << ' ' << offset;
                EXPECT_NEAR(result.irradiance[i], plain.irradiance[i], bound) << scale << ' ' << offset;
            }
        }
    }
}

TEST(ExactVisibility, OrderOfTrianglesDoesNotMatter) {
    Shape shape;
    std::mt19937 random{29};
    std::uniform_real_distribution<float> in{-1.0F, 1.0F};
    for (int i = 0; i < 100; ++i) {
        const glm::vec3 at{in(random), in(random), 1.0F + 0.5F * in(random)};
        shape.triangle(at, at + 0.3F * glm::vec3{in(random), in(random), in(random)},
                       at + 0.3F * glm::vec3{in(random), in(random), in(random)});
    }
    std::vector<glm::dvec3> points;
    for (int i = 0; i < 50; ++i) {
        points.emplace_back(in(random), in(random), 0.0);
    }
    const ExactResult plain = exact(scene_of(shape), ceiling(), points);
    std::shuffle(shape.triangles.begin(), shape.triangles.end(), random);
    const ExactResult shuffled = exact(scene_of(shape), ceiling(), points);
    for (std::size_t i = 0; i < points.size(); ++i) {
        EXPECT_NEAR(plain.area[i], shuffled.area[i], 1e-12);
        EXPECT_NEAR(plain.irradiance[i], shuffled.irradiance[i], 1e-12);
    }
}

TEST(ExactVisibility, FarAndTinyLightsKeepTheirIrradianceRatio) {
    // Half of the light hidden along its middle: the ratio tends to one half as the light shrinks.
    for (const double half : {1.0, 1e-2, 1e-4, 1e-6}) {
        Shape shape;
        shape.quad({0.0F, -64.0F, 1.0F}, {64.0F, -64.0F, 1.0F}, {64.0F, 64.0F, 1.0F}, {0.0F, 64.0F, 1.0F});
        const ExactResult result =
            exact(scene_of(shape), ceiling(2.0, half), {{0.0, 0.0, 0.0}}, glm::normalize(glm::dvec3{0.0, 0.2, 1.0}));
        EXPECT_NEAR(result.area[0], 0.5, 1e-15 / half);
        EXPECT_NEAR(result.irradiance[0], 0.5, 4e-15 / half);
    }
}

TEST(ExactVisibility, StiffScenesNeverGiveNanOrLeaveZeroToOne) {
    std::mt19937 random{31};
    std::uniform_real_distribution<float> in{-1.0F, 1.0F};
    std::uniform_int_distribution<int> grid{-2, 2};
    const auto coarse = [&] { return glm::vec3{grid(random), grid(random), grid(random)}; };
    for (int round = 0; round < 400; ++round) {
        Shape shape;
        for (int i = 0; i < 12; ++i) {
            shape.triangle(coarse(), coarse(), coarse());  // many without area, in the light's plane, through x
            const glm::vec3 a = coarse();
            const glm::vec3 b = coarse();
            shape.triangle(a, b, 0.5F * (a + b) + 1e-7F * glm::vec3{in(random), in(random), in(random)});
        }
        std::vector<glm::dvec3> points;
        for (int i = 0; i < 8; ++i) {
            points.emplace_back(coarse());
            points.emplace_back(in(random), in(random), 2.0 + 1e-10 * in(random));
        }
        const ExactResult result = exact(scene_of(shape), ceiling(), points,
                                         glm::normalize(glm::dvec3{in(random), in(random), 1.0 + in(random)}));
        for (std::size_t i = 0; i < points.size(); ++i) {
            ASSERT_TRUE(result.area[i] >= 0.0 && result.area[i] <= 1.0);
            ASSERT_TRUE(result.irradiance[i] >= 0.0 && result.irradiance[i] <= 1.0);
        }
    }
}

TEST(ExactVisibility, EllipseAsPolygonIsWithin1e4OfTheLens) {
    // Disc blocker of radius 0.5 at half height under a disc light of radius 1: projected radius 1 at distance D.
    Shape shape;
    const int corners = 1024;
    for (int i = 0; i < corners; ++i) {
        const auto at = [&](int k) {
            const double phi = 2.0 * kPi * k / corners;
            return glm::vec3{0.25 * std::cos(phi), 0.25 * std::sin(phi), 1.0};
        };
        shape.triangle({0.0F, 0.0F, 1.0F}, at(i), at(i + 1));
    }
    Light light = ceiling();
    light.kind = LightKind::Ellipse;
    const double big = 1.0;
    const double small = 0.5;
    Control control;
    for (int i = 0; i <= 40; ++i) {
        const double distance = i * 0.05;
        double lens = 0.0;
        if (distance <= big - small) {
            lens = kPi * small * small;
        } else if (distance < big + small) {
            const double d2 = distance * distance;
            lens = small * small * std::acos((d2 + small * small - big * big) / (2.0 * distance * small)) +
                   big * big * std::acos((d2 + big * big - small * small) / (2.0 * distance * big)) -
                   0.5 * std::sqrt((-distance + small + big) * (distance + small - big) * (distance - small + big) *
                                   (distance + small + big));
        }
        // The blocker's centre projects to -x.
        const std::vector<glm::dvec3> x{{distance, 0.0, 0.0}};
        const std::vector<glm::dvec3> n{{0.0, 0.0, 1.0}};
        const ExactResult result = nearly_exact_visibility(scene_of(shape), light, x, n, control);
        EXPECT_NEAR(result.area[0], 1.0 - lens / kPi, 1e-4) << distance;
    }
}

TEST(ExactVisibility, ThrowsForLightsWithoutPolygonAndForBadPoints) {
    Light light = ceiling();
    light.kind = LightKind::Ellipse;
    EXPECT_THROW(static_cast<void>(exact(Scene{}, light, {{0.0, 0.0, 0.0}})), InvalidScene);
    light = ceiling();
    light.half_v_ws = glm::dvec3{0.0};
    EXPECT_THROW(static_cast<void>(exact(Scene{}, light, {{0.0, 0.0, 0.0}})), InvalidScene);
    EXPECT_THROW(static_cast<void>(exact(Scene{}, ceiling(), {{0.0, NAN, 0.0}})), InvalidScene);
    EXPECT_THROW(static_cast<void>(exact(Scene{}, ceiling(), {{0.0, 0.0, 0.0}}, glm::dvec3{0.0})), InvalidScene);
    Control control;
    const std::vector<glm::dvec3> two(2, glm::dvec3{0.0});
    const std::vector<glm::dvec3> one(1, glm::dvec3{0.0, 0.0, 1.0});
    EXPECT_THROW(static_cast<void>(exact_visibility(Scene{}, ceiling(), two, one, control)), InvalidScene);
}

TEST(ExactVisibility, StopsWhenCancelled) {
    Shape shape;
    shape.quad({-4.0F, -4.0F, 1.0F}, {4.0F, -4.0F, 1.0F}, {4.0F, 4.0F, 1.0F}, {-4.0F, 4.0F, 1.0F});
    Control control;
    control.cancel();
    const std::vector<glm::dvec3> points(100, glm::dvec3{0.0});
    const std::vector<glm::dvec3> normals(100, glm::dvec3{0.0, 0.0, 1.0});
    EXPECT_THROW(static_cast<void>(exact_visibility(scene_of(shape), ceiling(), points, normals, control)), Cancelled);
}

}  // namespace
}  // namespace penumbra
