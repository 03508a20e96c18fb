#include "reference/ray_batch.h"

#include <gtest/gtest.h>

#include "reference/sampling.h"
#include "test_scenes.h"

namespace penumbra {
namespace {

/// Adds `count` rays that fan out from (0, 0, -2) towards the scene.
void add_fan(RayBatch& batch, int count) {
    for (int first = 0; first < count; first += kRayLanes) {
        RayPacket& rays = batch.next();
        for (int i = 0; i < kRayLanes; ++i) {
            float a;
            float b;
            uniform_pair(7, static_cast<std::uint32_t>(first + i), a, b);
            rays.org_x[i] = 0.0F;
            rays.org_y[i] = 0.0F;
            rays.org_z[i] = -2.0F;
            rays.dir_x[i] = 2.0F * a - 1.0F;
            rays.dir_y[i] = 2.0F * b - 1.0F;
            rays.dir_z[i] = 1.0F;
            rays.tnear[i] = 0.0F;
            rays.tfar[i] = 10.0F;
        }
        batch.added(std::min(kRayLanes, count - first));
    }
}

TEST(RayBatch, GivesTheSameAnswersAsStreamsAndAsPackets) {
    // A mesh cast twice, so that both ways meet instances too.
    const auto mesh = test::sphere(0.3F, 12, 16);
    Scene scene;
    scene.instances = {test::place(mesh), test::place(mesh, test::moved({0.5, 0.4, 0.1})),
                       test::place(test::square(0.5F), test::moved({-0.6, 0, 0}))};
    Control control;
    const RayScene rays{scene, control};
    ASSERT_EQ(rays.instanced_count(), 2U);
    for (const int count : {1, 15, 16, 17, 100, 256}) {
        RayBatch packets{rays, false};
        add_fan(packets, count);
        packets.trace();
        EXPECT_EQ(packets.count(), 0);
        if (rays.has_streams()) {
            RayBatch stream{rays, true};
            add_fan(stream, count);
            stream.trace();
            int hidden = 0;
            for (int i = 0; i < count; ++i) {
                EXPECT_EQ(stream.seen(i), packets.seen(i)) << "ray " << i << " of " << count;
                hidden += stream.seen(i) == 0 ? 1 : 0;
            }
            if (count == 256) {
                EXPECT_GT(hidden, 20);
                EXPECT_LT(hidden, 236);
            }
        }
    }
}

TEST(RayBatch, OfAnEmptySceneLetsEverythingThrough) {
    Control control;
    const RayScene rays{Scene{}, control};
    for (const bool streams : {false, rays.has_streams()}) {
        RayBatch batch{rays, streams};
        add_fan(batch, 20);
        batch.trace();
        for (int i = 0; i < 20; ++i) {
            EXPECT_EQ(batch.seen(i), 1U);
        }
    }
}

}  // namespace
}  // namespace penumbra
