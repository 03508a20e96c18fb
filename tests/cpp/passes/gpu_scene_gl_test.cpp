#include <gtest/gtest.h>

#include <optional>

#include "gl/render_thread.h"
#include "passes/gpu_scene.h"
#include "support/scenes.h"
#include "support/skip.h"

namespace penumbra {
namespace {

class GpuSceneGl : public testing::Test {
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

Scene two_boxes() {
    Scene scene;
    const auto box = scenes::box({-1, -1, -1}, {1, 1, 1});
    scene.instances.push_back(scenes::place(scenes::sheet(-5, 5, -5, 5), "ground"));
    scene.instances.push_back(scenes::place(box, "left", {-2, 0, 1}));
    scene.instances.push_back(scenes::place(box, "right", {2, 0, 1}));
    return scene;
}

TEST_F(GpuSceneGl, SendsGeometryForOtherMeshesAndForNothingElse) {
    thread_->run([](Device&) {
        Scene scene = two_boxes();
        GpuScene gpu_scene;
        EXPECT_TRUE(gpu_scene.update(scene)) << "the first time";
        EXPECT_FALSE(gpu_scene.update(scene)) << "nothing changed";
        const GLuint positions = gpu_scene.positions().name();
        scene.instances[1].world_from_local[3].x -= 1.0;
        scene.instances[2].albedo = {{1.0F, 0.0F, 0.0F}, {0.0F, 1.0F, 0.0F}};
        scene.camera.width_px = 77;
        EXPECT_FALSE(gpu_scene.update(scene)) << "a transform, colours, the picture's size";
        scene.instances.push_back(scenes::place(scene.instances[1].mesh, "third", {0, 3, 1}));
        EXPECT_FALSE(gpu_scene.update(scene)) << "one more of a mesh that is there";
        EXPECT_EQ(gpu_scene.positions().name(), positions);
        EXPECT_EQ(gpu_scene.instance_count(), 4U);
        scene.instances[2].mesh = scenes::box({-1, -1, -1}, {1, 1, 1});
        EXPECT_TRUE(gpu_scene.update(scene)) << "another mesh, though of equal content";
        scene.instances.resize(1);
        EXPECT_TRUE(gpu_scene.update(scene)) << "a mesh that nobody shows goes";
        EXPECT_EQ(gpu_scene.meshes().size(), 1U);
    });
}

TEST_F(GpuSceneGl, AnUpdateInPlaceLeavesWhatAFirstOneMakes) {
    thread_->run([](Device&) {
        Scene scene = two_boxes();
        GpuScene followed;
        followed.update(scene);
        scene.instances[1].world_from_local[0] = -scene.instances[1].world_from_local[0];
        scene.instances[1].world_from_local[3].z += 2.0;
        followed.update(scene);
        GpuScene fresh;
        fresh.update(scene);
        const glm::dvec3 origin{0.3, -0.2, 4.0};
        const auto a = followed.relative_to(origin);
        const auto b = fresh.relative_to(origin);
        ASSERT_EQ(a.size(), b.size());
        for (std::size_t i = 0; i < a.size(); ++i) {
            for (int row = 0; row < 3; ++row) {
                EXPECT_EQ(a[i].rows[row], b[i].rows[row]) << i;
            }
            EXPECT_EQ(followed.world_from_recentred(i), fresh.world_from_recentred(i)) << i;
            EXPECT_EQ(followed.mirrored(i), fresh.mirrored(i)) << i;
            EXPECT_EQ(followed.instance_bounds_ws()[i].low, fresh.instance_bounds_ws()[i].low) << i;
            EXPECT_EQ(followed.instance_bounds_ws()[i].high, fresh.instance_bounds_ws()[i].high) << i;
        }
        EXPECT_TRUE(followed.mirrored(1));
    });
}

}  // namespace
}  // namespace penumbra
