// Layers that lights share: one array for all of one size, contents that stay, layers that come back.
#include "passes/map_layers.h"

#include <gtest/gtest.h>

#include <vector>

#include "gl/framebuffer.h"
#include "gl/render_thread.h"
#include "support/skip.h"

namespace penumbra {
namespace {

class MapLayersGl : public testing::Test {
protected:
    void SetUp() override {
        try {
            thread_ = std::make_unique<RenderThread>();
        } catch (const DeviceError& error) {
            PENUMBRA_SKIP(error.what());
        }
    }
    /// Every layer of a lease its own value, through framebuffers.
    static void fill(MapLayers::Lease& lease, float first) {
        for (int layer = 0; layer < lease.texture().layers(); ++layer) {
            RenderTarget target{"filled"};
            target.attach_colour(0, lease.texture(), layer);
            target.bind();
            target.clear_colour(0, glm::vec4{first + static_cast<float>(layer)});
        }
    }
    static std::vector<float> corners(const MapLayers::Lease& lease) {
        const std::vector<float> all = lease.texture().read<float>();
        std::vector<float> values;
        for (int layer = 0; layer < lease.texture().layers(); ++layer) {
            values.push_back(all[static_cast<std::size_t>(layer) * 64 + 63]);
        }
        return values;
    }
    std::unique_ptr<RenderThread> thread_;
};

TEST_F(MapLayersGl, MapsOfOneFormatAndSizeShareOneArrayAndKeepTheirContentsWhenItGrows) {
    thread_->run([](Device&) {
        MapLayers pool;
        MapLayers::Lease a = pool.take(GL_R32F, 8, 1, "a");
        const unsigned before = a.generation();
        fill(a, 1.0F);
        MapLayers::Lease b = pool.take(GL_R32F, 8, 3, "b");
        fill(b, 10.0F);
        MapLayers::Lease c = pool.take(GL_R32F, 8, 1, "c");
        fill(c, 20.0F);
        EXPECT_EQ(corners(a), std::vector<float>({1.0F}));
        EXPECT_EQ(corners(b), std::vector<float>({10.0F, 11.0F, 12.0F}));
        EXPECT_EQ(corners(c), std::vector<float>({20.0F}));
        EXPECT_NE(a.generation(), before) << "its framebuffers must be told";
        EXPECT_EQ(pool.usage().arrays, 1);
        EXPECT_EQ(pool.usage().layers, 5);
        EXPECT_EQ(pool.usage().layers_used, 5);
        const MapLayers::Lease other_size = pool.take(GL_R32F, 16, 1, "d");
        const MapLayers::Lease other_format = pool.take(GL_DEPTH_COMPONENT32F, 8, 1, "e");
        EXPECT_EQ(pool.usage().arrays, 3);
    });
}

TEST_F(MapLayersGl, LayersThatAreGivenBackServeTheNextAndTheLastTakesTheArrayWithIt) {
    thread_->run([](Device&) {
        const long handles = live_handle_count();
        MapLayers pool;
        MapLayers::Lease a = pool.take(GL_R32F, 8, 2, "a");
        MapLayers::Lease b = pool.take(GL_R32F, 8, 3, "b");
        MapLayers::Lease c = pool.take(GL_R32F, 8, 1, "c");
        fill(a, 1.0F);
        fill(c, 20.0F);
        b = MapLayers::Lease{};
        EXPECT_EQ(pool.usage().layers_used, 3);
        MapLayers::Lease d = pool.take(GL_R32F, 8, 2, "d");
        MapLayers::Lease e = pool.take(GL_R32F, 8, 1, "e");
        fill(d, 30.0F);
        fill(e, 40.0F);
        EXPECT_EQ(pool.usage().layers, 6) << "both fit where b was";
        EXPECT_EQ(corners(a), std::vector<float>({1.0F, 2.0F}));
        EXPECT_EQ(corners(c), std::vector<float>({20.0F}));
        EXPECT_EQ(corners(d), std::vector<float>({30.0F, 31.0F}));
        a = MapLayers::Lease{};
        c = MapLayers::Lease{};
        d = std::move(e);
        EXPECT_EQ(pool.usage().layers_used, 1);
        d = MapLayers::Lease{};
        EXPECT_EQ(pool.usage().arrays, 0);
        EXPECT_EQ(live_handle_count(), handles);
    });
}

}  // namespace
}  // namespace penumbra
