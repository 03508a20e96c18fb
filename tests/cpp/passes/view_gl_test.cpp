#include <gtest/gtest.h>

#include <optional>

#include "geometry/seen_surfaces.h"
#include "passes/view_pass.h"
#include "support/scenes.h"
#include "support/skip.h"

namespace penumbra {
namespace {

class ViewGl : public testing::Test {
protected:
    void SetUp() override {
        try {
            thread_.emplace();
        } catch (const DeviceError& error) {
            PENUMBRA_SKIP(error.what());
        }
    }
    View render(Scene scene) {
        validate(scene);
        return thread_->run([&](Device& device) {
            GpuScene gpu_scene;
            gpu_scene.update(scene);
            ViewPass pass;
            Control control;
            View view = pass.render(device, gpu_scene, scene, control);
            shade_surfaces(scene, view, control);
            return view;
        });
    }
    std::optional<RenderThread> thread_;
};

Scene ground_from_above() {
    Scene scene;
    scene.instances.push_back(scenes::place(scenes::sheet(-100, 100, -100, 100), "ground"));
    scene.camera = scenes::camera_from_above(2.0, 40, 24, 10.0);
    return scene;
}

double pixel_world_error(const View& view, const Camera& camera) {
    double worst = 0.0;
    const double aspect = static_cast<double>(view.height) / view.width;
    for (int y = 0; y < view.height; ++y) {
        for (int x = 0; x < view.width; ++x) {
            const std::size_t i = static_cast<std::size_t>(y) * view.width + x;
            const glm::dvec3 expected{camera.half_width_m * (2.0 * (x + 0.5) / view.width - 1.0),
                                      camera.half_width_m * aspect * (2.0 * (y + 0.5) / view.height - 1.0), -10.0};
            worst = std::max(worst, glm::length(glm::dvec3{view.position_cr[i]} - expected));
        }
    }
    return worst;
}

TEST_F(ViewGl, OrthographicPositionsAreThoseOfThePixelCentres) {
    const Scene scene = ground_from_above();
    EXPECT_LT(pixel_world_error(render(scene), scene.camera), 2e-6);
}

TEST_F(ViewGl, PerspectivePositionsAreThoseOfThePixelCentres) {
    Scene scene = ground_from_above();
    scene.camera.orthographic = false;
    scene.camera.tan_half_width = 0.2;  // 2 m at 10 m
    EXPECT_LT(pixel_world_error(render(scene), scene.camera), 2e-6);
}

TEST_F(ViewGl, AHugeTriangleCostsNoPrecision) {
    Scene scene = ground_from_above();
    scene.instances[0] = scenes::place(scenes::sheet(-1e6, 1e6, -1e6, 1e6), "plain");
    scene.camera.orthographic = false;
    scene.camera.tan_half_width = 0.2;
    EXPECT_LT(pixel_world_error(render(scene), scene.camera), 4e-6);
}

TEST_F(ViewGl, ASceneFarFromTheOriginKeepsItsPrecision) {
    Scene scene = scenes::transformed(ground_from_above(), 1.0, glm::dmat3{1.0}, {1e6, -2e6, 3e6});
    EXPECT_LT(pixel_world_error(render(scene), scene.camera), 2e-6);
}

TEST_F(ViewGl, AMeshWhoseVerticesLieFarFromItsOriginKeepsItsPrecision) {
    Scene scene = ground_from_above();
    scene.instances[0] =
        scenes::place(scenes::sheet(1048576.0 - 64, 1048576.0 + 64, -64, 64), "ground", {-1048576.0, 0, 0});
    EXPECT_LT(pixel_world_error(render(scene), scene.camera), 2e-6);
}

TEST_F(ViewGl, ShiftMovesTheWindowByImageWidths) {
    Scene scene = ground_from_above();
    scene.camera.shift = {0.25, 0.1};
    const View view = render(scene);
    const glm::vec3 first = view.position_cr[0];
    EXPECT_NEAR(first.x, -2.0 + 0.05 + 0.25 * 4.0, 1e-5);
    EXPECT_NEAR(first.y, -1.2 + 0.05 + 0.1 * 4.0, 1e-5);
}

TEST_F(ViewGl, PixelOffsetMovesTheSampleAndNotTheImage) {
    Scene scene = ground_from_above();
    scene.camera.pixel_offset = {0.5, -0.25};
    const View view = render(scene);
    EXPECT_NEAR(view.position_cr[0].x, -2.0 + 0.1, 1e-5);
    EXPECT_NEAR(view.position_cr[0].y, -1.2 + 0.025, 1e-5);
}

TEST_F(ViewGl, NothingSeenIsMarked) {
    Scene scene = ground_from_above();
    scene.instances[0] = scenes::place(scenes::sheet(0, 100, -100, 100), "half");
    const View view = render(scene);
    for (int x = 0; x < view.width; ++x) {
        EXPECT_EQ(view.hit(static_cast<std::size_t>(x)), x >= view.width / 2) << x;
    }
}

TEST_F(ViewGl, AnEmptySceneShowsNothing) {
    Scene scene = ground_from_above();
    scene.instances.clear();
    const View view = render(scene);
    for (std::size_t i = 0; i < view.size(); ++i) {
        EXPECT_FALSE(view.hit(i));
    }
}

TEST_F(ViewGl, TheNearestInstanceAndItsTriangleAreSeen) {
    Scene scene = ground_from_above();
    scene.instances.push_back(scenes::place(scenes::sheet(0, 2, -2, 2), "upper", {0, 0, 1}));
    const View view = render(scene);
    const std::size_t left = 5, right = static_cast<std::size_t>(view.width) - 5;
    EXPECT_EQ(view.instance[left], 0);
    EXPECT_EQ(view.instance[right], 1);
    EXPECT_NEAR(view.position_cr[right].z, -9.0, 1e-6);
    const glm::uvec3 t = scene.instances[1].mesh->triangles[static_cast<std::size_t>(view.triangle[right])];
    EXPECT_EQ(t, (glm::uvec3{0, 1, 2})) << "the lower right triangle";
}

TEST_F(ViewGl, InstancesInvisibleToTheCameraAreNotSeen) {
    Scene scene = ground_from_above();
    scene.instances.push_back(scenes::place(scenes::sheet(-2, 2, -2, 2), "upper", {0, 0, 1}));
    scene.instances[1].visible = false;
    for (const std::int32_t seen : render(scene).instance) {
        EXPECT_EQ(seen, 0);
    }
}

TEST_F(ViewGl, GeometricNormalsTurnToTheCameraAlsoOnMirroredInstances) {
    for (const double sign : {1.0, -1.0}) {
        Scene scene = ground_from_above();
        scene.instances[0].world_from_local[0][0] = sign;
        const View view = render(scene);
        EXPECT_NEAR(view.normal_ws[100].z, 1.0, 1e-6) << sign;
        EXPECT_NEAR(view.shading_normal_ws[100].z, 1.0, 1e-6) << sign;
    }
}

TEST_F(ViewGl, SmoothNormalsOfAShearedSphereAreThoseOfTheEllipsoid) {
    Scene scene;
    scene.instances.push_back(scenes::place(scenes::sphere(48, true), "egg"));
    glm::dmat4& m = scene.instances[0].world_from_local;
    m = glm::dmat4{{1.0, 0.0, 0.0, 0.0}, {0.4, 0.8, 0.0, 0.0}, {0.0, 0.0, 0.6, 0.0}, {0.0, 0.0, 0.0, 1.0}};
    scene.camera = scenes::camera_from_above(1.5, 64, 64, 10.0);
    const View view = render(scene);
    const glm::dmat3 inverse = glm::inverse(glm::dmat3{m});
    int compared = 0;
    for (std::size_t i = 0; i < view.size(); ++i) {
        if (!view.hit(i)) {
            continue;
        }
        const glm::dvec3 on_sphere = inverse * (view.eye_ws + glm::dvec3{view.position_cr[i]});
        const glm::dvec3 expected = glm::normalize(glm::transpose(inverse) * on_sphere);
        if (expected.z > 0.3) {
            EXPECT_GT(glm::dot(expected, glm::dvec3{view.shading_normal_ws[i]}), 0.9995);
            ++compared;
        }
    }
    EXPECT_GT(compared, 500);
}

TEST_F(ViewGl, AlbedoFollowsTheMaterialSlotOfEachTriangle) {
    Scene scene = ground_from_above();
    auto mesh = std::make_shared<Mesh>(*scene.instances[0].mesh);
    mesh->triangle_material = {0, 7};
    scene.instances[0].mesh = mesh;
    scene.instances[0].albedo = {{0.1F, 0.2F, 0.3F}, {0.9F, 0.8F, 0.7F}};
    const View view = render(scene);
    const std::size_t lower_right = static_cast<std::size_t>(view.width) - 1;
    const std::size_t upper_left = static_cast<std::size_t>(view.width) * (static_cast<std::size_t>(view.height) - 1);
    EXPECT_NEAR(view.albedo[lower_right].y, 0.2, 1e-6);
    EXPECT_NEAR(view.albedo[upper_left].y, 0.8, 1e-6) << "slot 7 does not exist: the last one serves";
}

TEST_F(ViewGl, ClippingHidesWhatIsTooNearOrTooFar) {
    Scene scene = ground_from_above();
    scene.instances.push_back(scenes::place(scenes::sheet(-5, 5, -5, 5), "near", {0, 0, 9.5}));
    scene.camera.near_m = 1.0;
    EXPECT_EQ(render(scene).instance[10], 0);
    scene.camera.far_m = 9.0;
    EXPECT_EQ(render(scene).instance[10], -1);
}

TEST_F(ViewGl, AZeroAreaTriangleIsNoSurface) {
    Scene scene = ground_from_above();
    scene.instances.push_back(
        scenes::place(scenes::mesh("needle", {{-2, 0, 1}, {2, 0, 1}, {0, 0, 1}}, {{0, 1, 2}, {1, 1, 2}}), "needle"));
    const View view = render(scene);
    for (std::size_t i = 0; i < view.size(); ++i) {
        EXPECT_TRUE(std::isfinite(view.position_cr[i].x) && std::isfinite(view.normal_ws[i].z));
    }
}

TEST_F(ViewGl, UpdatingOnlyATransformSendsNoGeometry) {
    Scene scene = ground_from_above();
    validate(scene);
    const auto [first, second, moved_z] = thread_->run([&](Device& device) {
        GpuScene gpu_scene;
        const bool sent = gpu_scene.update(scene);
        scene.instances[0].world_from_local[3].z = 1.0;
        const bool again = gpu_scene.update(scene);
        ViewPass pass;
        Control control;
        return std::tuple{sent, again, pass.render(device, gpu_scene, scene, control).position_cr[0].z};
    });
    EXPECT_TRUE(first);
    EXPECT_FALSE(second);
    EXPECT_NEAR(moved_z, -9.0, 1e-6);
}

}  // namespace
}  // namespace penumbra
