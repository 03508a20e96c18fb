#include <cmath>
#include <memory>
#include <string>
#include <vector>

#include "penumbra/technique.h"
#include "techniques/renderer_fixture.h"

namespace penumbra {
namespace {

/// Two renderers that differ in what finds the triangles of a view.
class TwoViews : public RendererGl {
protected:
    static Renderer& by_rays() {
        static std::unique_ptr<Renderer> renderer;
        if (!renderer) {
            RendererOptions options;
            options.view_by = ViewBy::Rays;
            renderer = std::make_unique<Renderer>(options);
        }
        return *renderer;
    }

    /// Spheres of one mesh and a box of its own over a ground, under a lamp; no edge runs along a row of samples.
    static Scene spheres() {
        Scene scene;
        scene.instances.push_back(scenes::place(scenes::sheet(-20, 20, -20, 20), "ground"));
        const auto ball = scenes::sphere(12, false);
        scene.instances.push_back(scenes::place(ball, "left", {-1.0, 0.1, 1.2}));
        scene.instances.push_back(scenes::place(ball, "right", {1.3, -0.2, 1.4}));
        scene.instances.push_back(scenes::place(scenes::box({-0.3F, -0.8F, 2.5F}, {0.4F, 0.9F, 2.7F}), "box"));
        scene.lights.push_back(scenes::rectangle_light({1.0, 0.5, 6.0}, 1.0, 1.0));
        scene.camera = scenes::camera_from_above(3.0, 96, 72);
        scene.camera.pixel_offset = {0.137, 0.271};
        return scene;
    }
    /// Views of the same triangles, but where a sample lies nearer to an edge than the rasteriser's grid of 1/256
    /// pixel.
    static void expect_like_views(const Scene& scene, Control& control) {
        shared()->set_scene(scene);
        by_rays().set_scene(scene);
        const auto drawn = shared()->view(control);
        const auto traced = by_rays().view(control);
        int other_instance = 0;
        int other_triangle = 0;
        for (std::size_t i = 0; i < drawn->size(); ++i) {
            if (drawn->instance[i] != traced->instance[i]) {
                ++other_instance;
            } else if (drawn->triangle[i] != traced->triangle[i]) {
                ++other_triangle;
            } else {
                ASSERT_EQ(drawn->position_cr[i], traced->position_cr[i]);
                ASSERT_EQ(drawn->normal_ws[i], traced->normal_ws[i]);
            }
        }
        EXPECT_LE(other_instance, 3);   // of 6,912; some 300 lie on an outline, each edge of which is 1/128 pixel wide
        EXPECT_LE(other_triangle, 12);  // some 1,000 on edges of the spheres
    }
    static VisibilityResult ask(Renderer& renderer, const std::string& id, Control& control) {
        const Settings settings = id == "plateaus" ? Settings{{"map_size", 128}} : Settings{};
        return renderer.visibility(0, {id, settings, false}, false, control);
    }
};

class EveryTechniqueViewBy : public TwoViews, public testing::WithParamInterface<std::string> {};

std::vector<std::string> all_ids() {
    std::vector<std::string> ids;
    for (const TechniqueInfo& info : techniques()) {
        ids.push_back(info.id);
    }
    return ids;
}
INSTANTIATE_TEST_SUITE_P(Registry, EveryTechniqueViewBy, testing::ValuesIn(all_ids()),
                         [](const auto& made) { return made.param; });

TEST_P(EveryTechniqueViewBy, RaysGivesTheSameVisibility) {
    // Also where it needs a drawn depth, which the view by rays has none of until then.
    const Scene scene = spheres();
    expect_like_views(scene, control_);
    if (!renderer().supports(0, GetParam()).empty()) {
        GTEST_SKIP() << renderer().supports(0, GetParam());
    }
    // Pixels with other triangles, and those around them that share their rays or their samples' noise.
    const auto drawn = ask(renderer(), GetParam(), control_).visibility;
    const auto traced = ask(by_rays(), GetParam(), control_).visibility;
    EXPECT_LE(share_that_differs(drawn, traced, 1e-3), 0.003);
}

TEST_F(TwoViews, RaysFollowsWhatMovesAndWhatIsHidden) {
    Scene scene = spheres();
    expect_like_views(scene, control_);
    scene.instances[1].world_from_local[3].x -= 0.313;
    expect_like_views(scene, control_);
    // What casts and what is seen are no longer the same: two trees.
    scene.instances[2].visible = false;
    scene.instances[3].casts = false;
    const std::uint64_t before = by_rays().work().ray_scenes;
    expect_like_views(scene, control_);
    EXPECT_EQ(by_rays().work().ray_scenes, before + 1);
    static_cast<void>(ask(by_rays(), "ray_traced", control_));
    EXPECT_EQ(by_rays().work().ray_scenes, before + 2);
    scene.camera.pixel_offset.x += 0.21;
    expect_like_views(scene, control_);
    EXPECT_EQ(by_rays().work().ray_scenes, before + 2) << "another camera needs no other tree";
    scene.instances[2].visible = true;
    expect_like_views(scene, control_);
}

TEST_F(TwoViews, RaysCompileNothingForTechniquesThatTraceThemselves) {
    RendererOptions options;
    options.view_by = ViewBy::Rays;
    Renderer own{options};
    EXPECT_EQ(own.environment().view_by, "rays");
    EXPECT_EQ(renderer().environment().view_by, "raster");
    own.set_scene(spheres());
    const Settings pilot{{"mask_by", std::string{"rays"}}};
    EXPECT_FALSE(own.visibility(0, {"masked_rays", pilot}, false, control_).visibility.empty());
    EXPECT_EQ(own.work().programs, 0U);
    EXPECT_EQ(own.work().ray_scenes, 1U) << "the camera's rays and the light's share a tree";
    static_cast<void>(own.visibility(0, {"shadow_map", {}}, false, control_));
    EXPECT_GT(own.work().programs, 0U);
}

TEST_F(TwoViews, MeasuringTellsTheTimeOfAViewByRays) {
    by_rays().set_scene(spheres());
    const std::vector<Job> jobs{{"ray_traced", {}}, {"hybrid", {}}};
    for (const Measurement& m : by_rays().measure(0, jobs, false, {.max_seconds = 0.2}, control_)) {
        EXPECT_GT(m.view.median, 0.0);
        EXPECT_GT(m.dynamic_frame.median, 0.0);
    }
}

}  // namespace
}  // namespace penumbra
