#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <limits>
#include <map>
#include <optional>
#include <random>

#include "passes/silhouette_pass.h"
#include "support/bare_frame.h"
#include "support/obj.h"
#include "support/scenes.h"
#include "support/skip.h"

namespace penumbra {
namespace {

using Source = SilhouettePass::Source;

/// One context for all tests; each makes its own scene and pass on it.
class SilhouetteGl : public testing::Test {
protected:
    struct Found {
        std::vector<gpu::SilhouetteRecord> records;
        std::uint32_t count = 0;
        std::uint64_t edge_count = 0;
    };

    void SetUp() override {
        if (!thread()) {
            try {
                thread() = std::make_unique<RenderThread>();
            } catch (const DeviceError& error) {
                PENUMBRA_SKIP(error.what());
            }
        }
    }
    static std::unique_ptr<RenderThread>& thread() {
        static std::unique_ptr<RenderThread> made;
        return made;
    }

    /// Runs work(bench) on the render thread with the scene sent.
    template <class F>
    auto with(const Scene& scene, F&& work) {
        return thread()->run([&](Device& device) {
            BareFrame frame{device, scene};
            return work(frame);
        });
    }

    static std::vector<std::uint32_t> all_of(const Scene& scene) {
        std::vector<std::uint32_t> instances(scene.instances.size());
        for (std::uint32_t i = 0; i < instances.size(); ++i) {
            instances[i] = i;
        }
        return instances;
    }

    Found extract(const Scene& scene, const glm::dvec4& light_ws, const glm::dvec3& origin_ws,
                  const SilhouettePass::Options& options = {}) {
        return with(scene, [&](BareFrame& frame) {
            SilhouettePass pass{options};
            pass.prepare(frame, frame.gpu_scene, frame->adjacency(), all_of(scene));
            pass.extract(frame, light_ws, origin_ws);
            return Found{pass.read(), pass.read_count(), pass.edge_count()};
        });
    }
};

Scene one(std::shared_ptr<const Mesh> mesh, const glm::dmat4& world_from_local = glm::dmat4{1.0}) {
    Scene scene;
    Instance instance;
    instance.name = "it";
    instance.mesh = std::move(mesh);
    instance.world_from_local = world_from_local;
    scene.instances.push_back(instance);
    return scene;
}

TEST_F(SilhouetteGl, ACubeFromAGenericPointHasOneLoopOfSix) {
    const Found found = extract(one(scenes::box(glm::vec3{-1}, glm::vec3{1})), {4.0, 5.0, 6.0, 1.0}, {4.0, 5.0, 6.0});
    ASSERT_EQ(found.count, 6U);
    EXPECT_EQ(found.edge_count, 18U);
    std::map<std::uint32_t, const gpu::SilhouetteRecord*> by_start;
    for (const auto& record : found.records) {
        by_start[record.ids.y] = &record;
        EXPECT_EQ(record.a_rel.w, 1.0F);
    }
    ASSERT_EQ(by_start.size(), 6U);
    std::uint32_t at = found.records[0].ids.y;
    for (int i = 0; i < 6; ++i) {
        const auto* record = by_start.at(at);
        EXPECT_EQ(by_start.at(record->ids.z)->ids.w, at);
        EXPECT_EQ(by_start.at(record->ids.z)->a_rel.x, record->b_rel.x);
        at = record->ids.z;
    }
    EXPECT_EQ(at, found.records[0].ids.y);
}

}  // namespace
}  // namespace penumbra
