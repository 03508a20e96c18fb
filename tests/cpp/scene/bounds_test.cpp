#include "scene/bounds.h"

#include <glm/gtc/matrix_transform.hpp>
#include <random>

#include "scenes.h"

namespace penumbra {
namespace {

using test::expect_near;
using test::instance_of;
using test::light_of;
using test::square_mesh;

TEST(Bounds, AreEmptyForAnEmptyMeshAndScene) {
    EXPECT_TRUE(bounds_of(Mesh{}).empty());
    EXPECT_TRUE(bounds_of(Scene{}).empty());
    EXPECT_TRUE(transformed(Bounds{}, glm::dmat4{1.0}).empty());
    EXPECT_EQ(Bounds{}.radius(), 0.0);
    expect_near(Bounds{}.centre(), glm::dvec3{0.0}, 0.0);
}

TEST(Bounds, LeaveLooseVerticesOut) {
    Mesh mesh = square_mesh();
    mesh.positions_local.emplace_back(100.0F, 0.0F, 0.0F);
    expect_near(bounds_of(mesh).high, {1, 1, 0}, 0.0);
}

TEST(Bounds, ContainEveryVertexUnderAnyTransform) {
    std::mt19937 random{7};
    std::uniform_real_distribution<double> number{-1.0, 1.0};
    for (int round = 0; round < 1000; ++round) {
        Mesh mesh;
        for (int i = 0; i < 3; ++i) {
            mesh.positions_local.emplace_back(number(random), number(random), number(random));
        }
        mesh.triangles = {{0, 1, 2}};
        Instance instance = instance_of(mesh);
        for (int column = 0; column < 4; ++column) {
            for (int row = 0; row < 3; ++row) {
                instance.world_from_local[column][row] = number(random) * (column == 3 ? 1e6 : 1e-3);
            }
        }
        const Bounds bounds = bounds_of(instance);
        for (const glm::vec3& position : mesh.positions_local) {
            const glm::dvec3 world{instance.world_from_local * glm::dvec4{glm::dvec3{position}, 1.0}};
            ASSERT_TRUE(glm::all(glm::lessThanEqual(bounds.low, world)));
            ASSERT_TRUE(glm::all(glm::lessThanEqual(world, bounds.high)));
        }
    }
}

TEST(Bounds, AreTightUnderScaleAndTranslation) {
    Instance instance = instance_of(square_mesh());
    instance.world_from_local = glm::scale(glm::translate(glm::dmat4{1.0}, {10, 20, 30}), {-2, 3, 1});
    const Bounds bounds = bounds_of(instance);
    expect_near(bounds.low, {8, 20, 30}, 1e-12);
    expect_near(bounds.high, {10, 23, 30}, 1e-12);
}

TEST(Bounds, OfASceneCoverAllInstances) {
    Scene scene;
    scene.instances = {instance_of(square_mesh()), instance_of(square_mesh())};
    scene.instances[1].world_from_local[3] = {-5, 0, 7, 1};
    scene.instances[1].visible = false;
    const Bounds bounds = bounds_of(scene);
    expect_near(bounds.low, {-5, 0, 0}, 1e-12);
    expect_near(bounds.high, {1, 1, 7}, 1e-12);
}

TEST(LightBounds, FollowTheShapeOfEachKind) {
    Light light = light_of(LightKind::Point);
    light.position_ws = {1, 2, 3};
    light.radius_m = 0.5;
    expect_near(bounds_of(light).high, {1.5, 2.5, 3.5}, 0.0);
    light.half_u_ws = {3, 4, 0};
    light.half_v_ws = {-4, 3, 0};
    light.kind = LightKind::Rectangle;
    expect_near(bounds_of(light).half_size(), {7, 7, 0}, 1e-15);
    light.kind = LightKind::Ellipse;
    expect_near(bounds_of(light).half_size(), {5, 5, 0}, 1e-15);
    light.kind = LightKind::Line;
    expect_near(bounds_of(light).half_size(), {3, 4, 0}, 1e-15);
    light.kind = LightKind::Polygon;
    light.corners_ws = {{0, 0, 1}, {2, 0, 1}, {0, 4, 1}};
    expect_near(bounds_of(light).centre(), {1, 2, 1}, 1e-15);
    light.kind = LightKind::Sun;
    EXPECT_TRUE(bounds_of(light).empty());
}

}  // namespace
}  // namespace penumbra
