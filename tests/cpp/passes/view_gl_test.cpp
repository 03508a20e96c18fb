#include <gtest/gtest.h>

#include <algorithm>
#include <optional>
#include <string>
#include <vector>

#include "geometry/seen_surfaces.h"
#include "passes/view_pass.h"
#include "reference/seen_triangles.h"
#include "support/scenes.h"
#include "support/skip.h"

namespace penumbra {
namespace {

std::vector<glm::uvec2> seen_by_rays(const Scene& scene, Control& control) {
    const Camera& camera = scene.camera;
    std::vector<glm::uvec2> seen(static_cast<std::size_t>(camera.width_px) * static_cast<std::size_t>(camera.height_px),
                                 glm::uvec2{7U});
    find_seen(RayScene{scene, control, RayTargets::Visible}, camera, seen, control);
    return seen;
}

class ViewPassGl : public testing::Test {
protected:
    void SetUp() override {
        try {
            thread_.emplace();
        } catch (const DeviceError& error) {
            PENUMBRA_SKIP(error.what());
        }
    }
    std::optional<RenderThread> thread_;
};

/// What finds the triangles: a rasteriser or rays.
enum class By { Raster, Rays };

class ViewGl : public ViewPassGl, public testing::WithParamInterface<By> {
protected:
    View render(Scene scene) {
        validate(scene);
        return thread_->run([&](Device& device) {
            ViewPass pass;
            Control control;
            View view;
            if (GetParam() == By::Raster) {
                GpuScene gpu_scene;
                gpu_scene.update(scene);
                view = pass.render(device, gpu_scene, scene, control);
            } else {
                view = pass.place(scene, seen_by_rays(scene, control), control);
            }
            shade_surfaces(scene, view, control);
            return view;
        });
    }
};

INSTANTIATE_TEST_SUITE_P(By, ViewGl, testing::Values(By::Raster, By::Rays),
                         [](const auto& by) { return std::string{by.param == By::Raster ? "Raster" : "Rays"}; });

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

TEST_P(ViewGl, OrthographicPositionsAreThoseOfThePixelCentres) {
    const Scene scene = ground_from_above();
    EXPECT_LT(pixel_world_error(render(scene), scene.camera), 2e-6);
}

TEST_P(ViewGl, PerspectivePositionsAreThoseOfThePixelCentres) {
    Scene scene = ground_from_above();
    scene.camera.orthographic = false;
    scene.camera.tan_half_width = 0.2;  // 2 m at 10 m
    EXPECT_LT(pixel_world_error(render(scene), scene.camera), 2e-6);
}

TEST_P(ViewGl, AHugeTriangleCostsNoPrecision) {
    Scene scene = ground_from_above();
    scene.instances[0] = scenes::place(scenes::sheet(-1e6, 1e6, -1e6, 1e6), "plain");
    scene.camera.orthographic = false;
    scene.camera.tan_half_width = 0.2;
    EXPECT_LT(pixel_world_error(render(scene), scene.camera), 4e-6);
}

TEST_P(ViewGl, ASceneFarFromTheOriginKeepsItsPrecision) {
    Scene scene = scenes::transformed(ground_from_above(), 1.0, glm::dmat3{1.0}, {1e6, -2e6, 3e6});
    EXPECT_LT(pixel_world_error(render(scene), scene.camera), 2e-6);
}

TEST_P(ViewGl, AMeshWhoseVerticesLieFarFromItsOriginKeepsItsPrecision) {
    Scene scene = ground_from_above();
    scene.instances[0] =
        scenes::place(scenes::sheet(1048576.0 - 64, 1048576.0 + 64, -64, 64), "ground", {-1048576.0, 0, 0});
    EXPECT_LT(pixel_world_error(render(scene), scene.camera), 2e-6);
}

TEST_P(ViewGl, ShiftMovesTheWindowByImageWidths) {
    Scene scene = ground_from_above();
    scene.camera.shift = {0.25, 0.1};
    const View view = render(scene);
    const glm::vec3 first = view.position_cr[0];
    EXPECT_NEAR(first.x, -2.0 + 0.05 + 0.25 * 4.0, 1e-5);
    EXPECT_NEAR(first.y, -1.2 + 0.05 + 0.1 * 4.0, 1e-5);
}

TEST_P(ViewGl, PixelOffsetMovesTheSampleAndNotTheImage) {
    Scene scene = ground_from_above();
    scene.camera.pixel_offset = {0.5, -0.25};
    const View view = render(scene);
    EXPECT_NEAR(view.position_cr[0].x, -2.0 + 0.1, 1e-5);
    EXPECT_NEAR(view.position_cr[0].y, -1.2 + 0.025, 1e-5);
}

TEST_P(ViewGl, NothingSeenIsMarked) {
    Scene scene = ground_from_above();
    scene.instances[0] = scenes::place(scenes::sheet(0, 100, -100, 100), "half");
    const View view = render(scene);
    for (int x = 0; x < view.width; ++x) {
        EXPECT_EQ(view.hit(static_cast<std::size_t>(x)), x >= view.width / 2) << x;
    }
}

TEST_P(ViewGl, AnEmptySceneShowsNothing) {
    Scene scene = ground_from_above();
    scene.instances.clear();
    const View view = render(scene);
    for (std::size_t i = 0; i < view.size(); ++i) {
        EXPECT_FALSE(view.hit(i));
    }
}

TEST_P(ViewGl, TheNearestInstanceAndItsTriangleAreSeen) {
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

TEST_P(ViewGl, InstancesInvisibleToTheCameraAreNotSeen) {
    Scene scene = ground_from_above();
    scene.instances.push_back(scenes::place(scenes::sheet(-2, 2, -2, 2), "upper", {0, 0, 1}));
    scene.instances[1].visible = false;
    for (const std::int32_t seen : render(scene).instance) {
        EXPECT_EQ(seen, 0);
    }
}

TEST_P(ViewGl, GeometricNormalsTurnToTheCameraAlsoOnMirroredInstances) {
    for (const double sign : {1.0, -1.0}) {
        Scene scene = ground_from_above();
        scene.instances[0].world_from_local[0][0] = sign;
        const View view = render(scene);
        EXPECT_NEAR(view.normal_ws[100].z, 1.0, 1e-6) << sign;
        EXPECT_NEAR(view.shading_normal_ws[100].z, 1.0, 1e-6) << sign;
    }
}

TEST_P(ViewGl, SmoothNormalsOfAShearedSphereAreThoseOfTheEllipsoid) {
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

TEST_P(ViewGl, AlbedoFollowsTheMaterialSlotOfEachTriangle) {
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

TEST_P(ViewGl, ClippingHidesWhatIsTooNearOrTooFar) {
    Scene scene = ground_from_above();
    scene.instances.push_back(scenes::place(scenes::sheet(-5, 5, -5, 5), "near", {0, 0, 9.5}));
    scene.camera.near_m = 1.0;
    EXPECT_EQ(render(scene).instance[10], 0);
    scene.camera.far_m = 9.0;
    EXPECT_EQ(render(scene).instance[10], -1);
}

TEST_P(ViewGl, AZeroAreaTriangleIsNoSurface) {
    Scene scene = ground_from_above();
    scene.instances.push_back(
        scenes::place(scenes::mesh("needle", {{-2, 0, 1}, {2, 0, 1}, {0, 0, 1}}, {{0, 1, 2}, {1, 1, 2}}), "needle"));
    const View view = render(scene);
    for (std::size_t i = 0; i < view.size(); ++i) {
        EXPECT_TRUE(std::isfinite(view.position_cr[i].x) && std::isfinite(view.normal_ws[i].z));
    }
}

TEST_F(ViewPassGl, UpdatingOnlyATransformSendsNoGeometry) {
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

TEST_F(ViewPassGl, TheReceiverTextureIsMadeWhenItIsFirstAskedForAndWithTheViewFromThenOn) {
    Scene scene = ground_from_above();
    validate(scene);
    thread_->run([&](Device& device) {
        GpuScene gpu_scene;
        gpu_scene.update(scene);
        ViewPass pass;
        Control control;
        View view = pass.render(device, gpu_scene, scene, control);
        const std::size_t without = pass.memory_bytes();
        const auto at_first_pixel = [&] {
            return glm::uintBitsToFloat(pass.receiver(view, control).read<glm::uvec4>()[0].z);
        };
        EXPECT_EQ(at_first_pixel(), -10.0F);
        EXPECT_EQ(pass.memory_bytes(), without + view.size() * sizeof(glm::uvec4));
        scene.instances[0].world_from_local[3].z = 1.0;
        gpu_scene.update(scene);
        view = pass.render(device, gpu_scene, scene, control, std::move(view));
        EXPECT_EQ(at_first_pixel(), -9.0F) << "the texture of the view before";
        pass.forget_readers();
        scene.instances[0].world_from_local[3].z = 2.0;
        gpu_scene.update(scene);
        view = pass.render(device, gpu_scene, scene, control, std::move(view));
        EXPECT_EQ(at_first_pixel(), -8.0F) << "nobody was known to read it, but somebody does";
        scene.camera.width_px = 24;
        view = pass.render(device, gpu_scene, scene, control, std::move(view));
        EXPECT_EQ(pass.receiver(view, control).width(), 24);
    });
}

TEST_F(ViewPassGl, TheMemoryOfAnotherViewLeavesNothingOfItBehind) {
    Scene full = ground_from_above();
    Scene half = ground_from_above();
    half.instances[0] = scenes::place(scenes::sheet(0, 100, -100, 100), "half");
    half.camera.width_px = 24;
    validate(full);
    validate(half);
    thread_->run([&](Device& /*device*/) {
        Control control;
        ViewPass pass;
        View spare = pass.place(full, seen_by_rays(full, control), control);
        shade_surfaces(full, spare, control);
        const View fresh = pass.place(half, seen_by_rays(half, control), control);
        const View again = pass.place(half, seen_by_rays(half, control), control, std::move(spare));
        EXPECT_EQ(again.width, 24);
        EXPECT_EQ(again.position_cr, fresh.position_cr);
        EXPECT_EQ(again.normal_ws, fresh.normal_ws);
        EXPECT_EQ(again.instance, fresh.instance);
        EXPECT_EQ(again.triangle, fresh.triangle);
        EXPECT_TRUE(again.albedo.empty() && again.shading_normal_ws.empty());
    });
}

TEST_F(ViewPassGl, TheDepthOfAViewByRaysIsDrawnWhenItIsAskedForAndIsTheDrawnViews) {
    Scene scene = ground_from_above();
    scene.instances.push_back(scenes::place(scenes::sphere(24, false), "ball", {0, 0, 1}));
    validate(scene);
    thread_->run([&](Device& device) {
        GpuScene gpu_scene;
        gpu_scene.update(scene);
        Control control;
        ViewPass drawn;
        static_cast<void>(drawn.render(device, gpu_scene, scene, control));
        ViewPass placed;
        static_cast<void>(placed.place(scene, seen_by_rays(scene, control), control));
        EXPECT_EQ(placed.memory_bytes(), 0U) << "nothing was drawn";
        const auto depth = [&](ViewPass& pass) { return pass.depth_stencil(device, gpu_scene, scene).read<float>(); };
        EXPECT_EQ(depth(placed), depth(drawn));
    });
}

// --- by rays alone -----------------------------------------------------------------------------------------------

TEST(SeenTriangles, AreThoseOfInstancesThatShareAMeshAndOfThoseThatDoNot) {
    // Three balls of one mesh, which Embree gets as instances, between meshes of their own; the last casts alone.
    Scene scene = ground_from_above();
    const auto ball = scenes::sphere(12, false);
    for (const double x : {-1.2, 0.0, 1.2}) {
        scene.instances.push_back(scenes::place(ball, "ball", {x, 0, 1}));
    }
    scene.instances.push_back(scenes::place(scenes::sheet(-0.1, 0.1, -1, 1), "roof", {0, 0, 4}));
    scene.instances.push_back(scenes::place(scenes::sheet(-5, 5, -5, 5), "unseen", {0, 0, 6}));
    scene.instances.back().visible = false;
    validate(scene);
    Control control;
    const RayScene rays{scene, control, RayTargets::Visible};
    EXPECT_EQ(rays.instanced_count(), 3U);
    const std::vector<glm::uvec2> seen = seen_by_rays(scene, control);
    const auto at = [&](double x, double y) {
        const auto column = static_cast<std::size_t>((x / 2.0 + 1.0) * 20.0);
        const auto row = static_cast<std::size_t>((y / 1.2 + 1.0) * 12.0);
        return seen[row * 40 + column];
    };
    EXPECT_EQ(at(-1.3, 0.3).x, 2U);
    EXPECT_EQ(at(0.3, 0.3).x, 3U);
    EXPECT_EQ(at(1.3, 0.3).x, 4U);
    EXPECT_EQ(at(0.05, 0.05).x, 5U);
    EXPECT_EQ(at(0.05, 1.1).x, 1U);
    // The triangle is the ball's own: its plane passes near the sphere where the pixel is.
    const glm::uvec3 t = ball->triangles[at(0.3, 0.3).y];
    const glm::vec3 middle =
        (ball->positions_local[t.x] + ball->positions_local[t.y] + ball->positions_local[t.z]) / 3.F;
    EXPECT_LT(glm::length(glm::vec2{middle} - glm::vec2{0.3F, 0.3F}), 0.35F);
    EXPECT_GT(middle.z, 0.5F);
}

TEST(SeenTriangles, DoNotDependOnHowFarTheCameraIsNorHowLargeTheSceneIs) {
    // The same picture from ever farther away through an ever longer lens; float32 from the eye itself would be off by
    // more than a pixel from 1e5 m on.
    Scene scene;
    scene.instances.push_back(scenes::place(scenes::sphere(24, false), "ball"));
    scene.instances.push_back(scenes::place(scenes::sheet(-2, 2, -2, 2), "ground", {0, 0, -1}));
    scene.camera = scenes::camera_from_above(2.0, 64, 64, 10.0);
    scene.camera.pixel_offset = {0.137, 0.271};  // so that no edge of the meshes runs through many samples
    const auto seen_from = [&](double height, double scale) {
        Scene moved = scene;
        for (Instance& instance : moved.instances) {
            instance.world_from_local = glm::dmat4{glm::dmat3{scale}} * instance.world_from_local;
        }
        moved.camera.orthographic = false;
        // From the side: an eye on an axis of the scene would round in its depth alone.
        const glm::dvec3 back = glm::normalize(glm::dvec3{3, 2, 5});
        const glm::dvec3 right = glm::normalize(glm::cross(glm::dvec3{0, 0, 1}, back));
        const glm::dvec3 up = glm::cross(back, right);
        moved.camera.world_from_camera = glm::dmat4{glm::dvec4{right, 0}, glm::dvec4{up, 0}, glm::dvec4{back, 0},
                                                    glm::dvec4{back * (height * scale), 1}};
        moved.camera.tan_half_width = 2.0 / height;
        moved.camera.near_m = 0.1 * scale;
        moved.camera.far_m = 2.0 * height * scale;
        validate(moved);
        Control control;
        return seen_by_rays(moved, control);
    };
    const auto differ = [](const std::vector<glm::uvec2>& a, const std::vector<glm::uvec2>& b) {
        int count = 0;
        for (std::size_t i = 0; i < a.size(); ++i) {
            count += a[i] != b[i] ? 1 : 0;
        }
        return count;
    };
    const std::vector<glm::uvec2> far = seen_from(1e5, 1.0);
    EXPECT_GT(std::ranges::count_if(far, [](const glm::uvec2& s) { return s.x == 1; }), 700);
    EXPECT_LE(differ(far, seen_from(1.5e6, 1.0)), 4);  // of 4,096: the views themselves differ by 1e-5 of their size
    for (const double scale : {0x1p-20, 0x1p20}) {
        EXPECT_EQ(differ(far, seen_from(1e5, scale)), 0) << scale;
    }
}

TEST(SeenTriangles, OfWhatLiesBehindTheEyeAreNone) {
    Scene scene = ground_from_above();
    scene.camera.world_from_camera[3].z = -3.0;  // looks down from under the ground
    validate(scene);
    Control control;
    for (const glm::uvec2& s : seen_by_rays(scene, control)) {
        EXPECT_EQ(s, glm::uvec2{0U});
    }
}

TEST(SeenTriangles, StopWhenCancelled) {
    Scene scene = ground_from_above();
    validate(scene);
    Control control;
    const RayScene rays{scene, control, RayTargets::Visible};
    std::vector<glm::uvec2> seen(40 * 24);
    control.cancel();
    EXPECT_THROW(find_seen(rays, scene.camera, seen, control), Cancelled);
}

}  // namespace
}  // namespace penumbra
