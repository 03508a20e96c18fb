#include "geometry/seen_surfaces.h"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "base/parallel.h"
#include "support/scenes.h"

namespace penumbra {
namespace {

using namespace scenes;

/// One triangle that fills the picture, seen at a slant from `distance_m`.
Scene slanted_triangle(double size_m, double distance_m, const glm::dvec3& move = {}) {
    Scene scene;
    const auto s = static_cast<float>(size_m);
    scene.instances.push_back(
        place(mesh("facet", {{-s, -s, 0}, {s, -s, 0.3F * s}, {0, s, -0.2F * s}}, {{0, 1, 2}}), "facet"));
    scene.instances[0].world_from_local[3] += glm::dvec4{move, 0.0};
    scene.camera = camera_from_above(0.2 * distance_m, 32, 16, distance_m);
    scene.camera.orthographic = false;
    scene.camera.tan_half_width = 0.2;
    scene.camera.world_from_camera[3] += glm::dvec4{move, 0.0};
    return scene;
}

View placed(const Scene& scene, std::uint32_t instance = 0, std::uint32_t triangle = 0) {
    Control control;
    const std::size_t pixels =
        static_cast<std::size_t>(scene.camera.width_px) * static_cast<std::size_t>(scene.camera.height_px);
    return place_surfaces(scene, std::vector<glm::uvec2>(pixels, {instance + 1, triangle}), control);
}

TEST(SeenSurfaces, LieOnThePixelsRayAndOnTheTrianglesPlane) {
    for (const glm::dvec3& move : {glm::dvec3{0.0}, glm::dvec3{1e6, -2e6, 3e6}}) {
        const Scene scene = slanted_triangle(100.0, 10.0, move);
        const View view = placed(scene);
        const std::vector<glm::vec3>& p = scene.instances[0].mesh->positions_local;
        const glm::dvec3 n = glm::normalize(glm::cross(glm::dvec3{p[1] - p[0]}, glm::dvec3{p[2] - p[0]}));
        for (int y = 0; y < view.height; ++y) {
            for (int x = 0; x < view.width; ++x) {
                const std::size_t i = static_cast<std::size_t>(y * view.width + x);
                const glm::dvec3 at{view.position_cr[i]};
                EXPECT_NEAR(at.x / -at.z, 0.2 * (2.0 * (x + 0.5) / view.width - 1.0), 1e-7);
                EXPECT_NEAR(at.y / -at.z, 0.1 * (2.0 * (y + 0.5) / view.height - 1.0), 1e-7);
                EXPECT_NEAR(glm::dot(n, at + glm::dvec3{0, 0, 10} - glm::dvec3{p[0]}), 0.0, 2e-6);
                EXPECT_GT(glm::dot(glm::dvec3{view.normal_ws[i]}, n), 1.0 - 1e-6);
            }
        }
    }
}

TEST(SeenSurfaces, AnEdgeOnTriangleKeepsItsPixelsInItsBox) {
    Scene scene = slanted_triangle(1.0, 10.0);
    scene.instances[0].mesh = mesh("upright", {{0, -1, -1}, {0, 1, -1}, {0, 0, 1}}, {{0, 1, 2}});
    scene.camera.width_px = 31;  // so that a column of rays lies in the triangle's plane
    for (const bool orthographic : {false, true}) {
        scene.camera.orthographic = orthographic;
        const View view = placed(scene);
        for (const glm::vec3& at : view.position_cr) {
            EXPECT_EQ(at.x, 0.0F);
            EXPECT_LE(std::abs(at.y), 1.0F);
            EXPECT_LE(std::abs(at.z + 10.0F), 1.0F);
        }
    }
}

TEST(SeenSurfaces, AreNoneWhereNothingOrATriangleWithoutAreaIsSeen) {
    Scene scene = slanted_triangle(1.0, 10.0);
    scene.instances[0].mesh = mesh("needle", {{-1, 0, 0}, {1, 0, 0}, {0, 0, 0}}, {{0, 1, 2}});
    for (const View& view : {placed(scene), placed(scene, ~0U)}) {
        for (std::size_t i = 0; i < view.size(); ++i) {
            EXPECT_FALSE(view.hit(i));
            EXPECT_EQ(view.triangle[i], -1);
            EXPECT_EQ(view.position_cr[i], glm::vec3{0.0F});
        }
    }
}

TEST(SeenSurfaces, AreShadedOnceWithTheTrianglesColourAndTheInterpolatedNormal) {
    Scene scene = slanted_triangle(100.0, 10.0);
    auto smooth = std::make_shared<Mesh>(*scene.instances[0].mesh);
    smooth->corner_normals_local = {{0, 0, 3}, {0, 0, -1}, {0, 0, 1}};  // of any length: 3 - 4 v - 2 w along z
    smooth->triangle_material = {1};
    scene.instances[0].mesh = smooth;
    scene.instances[0].albedo = {{0.1F, 0.2F, 0.3F}, {0.4F, 0.5F, 0.6F}};
    Control control;
    View view = placed(scene);
    EXPECT_TRUE(view.albedo.empty() && view.shading_normal_ws.empty()) << "V needs neither";
    shade_surfaces(scene, view, control);
    for (std::size_t i = 0; i < view.size(); ++i) {
        EXPECT_EQ(view.albedo[i], scene.instances[0].albedo[1]);
        EXPECT_NEAR(std::abs(view.shading_normal_ws[i].z), 1.0, 1e-6);
        EXPECT_GT(glm::dot(view.shading_normal_ws[i], view.normal_ws[i]), 0.0F) << "turned like the face";
    }
    const glm::vec3* kept = view.albedo.data();
    shade_surfaces(scene, view, control);
    EXPECT_EQ(view.albedo.data(), kept);
}

TEST(SeenSurfaces, DoNotDependOnTheNumberOfThreads) {
    const Scene scene = slanted_triangle(100.0, 10.0);
    set_thread_count(1);
    const View one = placed(scene);
    set_thread_count(5);
    const View five = placed(scene);
    set_thread_count(0);
    EXPECT_EQ(one.position_cr, five.position_cr);
}

TEST(SeenSurfaces, StopWhenTheyAreTold) {
    Control control;
    control.cancel();
    const Scene scene = slanted_triangle(100.0, 10.0);
    EXPECT_THROW(static_cast<void>(place_surfaces(scene, std::vector<glm::uvec2>(32 * 16, {1, 0}), control)),
                 Cancelled);
}

}  // namespace
}  // namespace penumbra
