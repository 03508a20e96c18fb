// What a second frame does not do again: rule frame-unchanged, and what is kept of a scene that changed in part.
#include "techniques/renderer_fixture.h"

namespace penumbra {
namespace {

class KeptFramesGl : public RendererGl, public testing::WithParamInterface<std::string> {
protected:
    static Settings small(const std::string& id) {
        Settings settings;
        for (const TechniqueInfo& info : techniques()) {
            for (const SettingInfo& setting : info.settings) {
                if (info.id == id && setting.id == "map_size") {
                    settings["map_size"] = 128;
                } else if (info.id == id && (setting.id == "samples" || setting.id == "rays") &&
                           setting.default_value.index() == 1) {
                    settings[setting.id] = 8;
                }
            }
        }
        return settings;
    }
    VisibilityResult ask(const std::string& id, std::size_t light = 0, bool keep_everything = false) {
        Job job{id, small(id), false};
        job.reuse = true;
        return renderer().visibility(light, job, keep_everything, control_);
    }
    std::vector<float> fresh(const std::string& id, std::size_t light = 0) {
        return renderer().visibility(light, {id, small(id), false}, false, control_).visibility;
    }
    static int steps_run(const Plan& plan) {
        return static_cast<int>(std::ranges::count_if(plan.steps, [](const Step& step) { return step.run; }));
    }
    /// Two lights, a caster before the first and one far from everything that is seen.
    static Scene two_lights() {
        Scene scene = scenes::straight_edge(scenes::rectangle_light({0, 0, 4}, 1, 1), 1.0, 0.0, 64);
        scene.instances.push_back(scenes::place(scenes::sphere(8, false), "ball", {0.8, 0, 0.6}));
        scene.instances.push_back(scenes::place(scenes::sphere(8, false), "far", {30, 0, 1}));
        scene.lights.push_back(scenes::sun_light({0.3, 0.1, -1}, 0.02));
        static int made = 0;  // no test is handed a frame of another
        scene.lights[0].half_u_ws *= 1.0 + 1e-3 * ++made;
        return scene;
    }
};

std::vector<std::string> ids() {
    std::vector<std::string> all;
    for (const TechniqueInfo& info : techniques()) {
        all.push_back(info.id);
    }
    return all;
}
INSTANTIATE_TEST_SUITE_P(Registry, KeptFramesGl, testing::ValuesIn(ids()), [](const auto& made) { return made.param; });

TEST_P(KeptFramesGl, ASecondFrameOfAnUnchangedSceneRunsNoStep) {
    const std::string& id = GetParam();
    const Scene scene = two_lights();
    renderer().set_scene(scene);
    const VisibilityResult first = ask(id);
    const WorkDone before = renderer().work();
    renderer().set_scene(scene);
    const VisibilityResult second = ask(id);
    const WorkDone after = renderer().work();
    EXPECT_GT(steps_run(first.plan), 0);
    EXPECT_FALSE(first.kept);
    EXPECT_TRUE(second.kept);
    EXPECT_EQ(steps_run(second.plan), 0);
    ASSERT_EQ(second.plan.steps.size(), first.plan.steps.size());
    for (std::size_t i = 0; i < first.plan.steps.size(); ++i) {
        EXPECT_EQ(second.plan.steps[i].name, first.plan.steps[i].name);
        EXPECT_EQ(second.plan.steps[i].rule, first.plan.steps[i].run ? "frame-unchanged" : first.plan.steps[i].rule);
        EXPECT_EQ(second.plan.steps[i].time_ms, 0.0);
    }
    EXPECT_EQ(after.views, before.views);
    EXPECT_EQ(after.programs, before.programs);
    EXPECT_EQ(after.summaries, before.summaries);
    EXPECT_EQ(after.ray_scenes, before.ray_scenes);
    EXPECT_EQ(after.geometries, before.geometries);
    EXPECT_EQ(after.frames, before.frames);
    EXPECT_EQ(after.frames_kept, before.frames_kept + 1);
    EXPECT_EQ(second.visibility, first.visibility);
    EXPECT_EQ(second.visibility, fresh(id)) << "a kept frame is the frame that would be made";
}

TEST_P(KeptFramesGl, AnotherLightOrAColourOrACasterOutOfReachChangesNothingForThisLight) {
    const std::string& id = GetParam();
    Scene scene = two_lights();
    renderer().set_scene(scene);
    const VisibilityResult first = ask(id);
    scene.lights[1].direction_ws = glm::normalize(glm::dvec3{-0.2, 0.3, -1.0});
    scene.instances[2].albedo = {{0.1F, 0.2F, 0.3F}};
    renderer().set_scene(scene);
    EXPECT_TRUE(ask(id).kept) << "another light and a colour";
    scene.instances[3].world_from_local[3].x += 1.0;
    renderer().set_scene(scene);
    const VisibilityResult moved = ask(id);
    // Rays are traced in a frame that is fitted to all casters, so that any caster that moves may round them otherwise.
    const bool traces = id == "ray_traced" || id == "masked_rays";
    EXPECT_EQ(moved.kept, !traces) << "a caster outside the hull of light and receivers";
    EXPECT_EQ(moved.visibility, fresh(id));
}

TEST_P(KeptFramesGl, WhateverCountsMakesTheFrameAnew) {
    const std::string& id = GetParam();
    const Scene scene = two_lights();
    const auto changed = [&](const auto& change) {
        renderer().set_scene(scene);
        static_cast<void>(ask(id));
        Scene other = scene;
        change(other);
        renderer().set_scene(other);
        return !ask(id).kept;
    };
    EXPECT_TRUE(changed([](Scene& s) { s.instances[2].world_from_local[3].x += 0.01; })) << "a caster";
    EXPECT_TRUE(changed([](Scene& s) { s.lights[0].half_u_ws *= 1.01; })) << "the light";
    EXPECT_TRUE(changed([](Scene& s) { s.camera.pixel_offset.x += 0.25; })) << "the camera";
    EXPECT_TRUE(changed([](Scene& s) { s.instances[0].receives = false; })) << "what receives";
    EXPECT_TRUE(changed([](Scene& s) { s.instances[2].mesh = scenes::sphere(9, false); })) << "a mesh";
    renderer().set_scene(scene);
    EXPECT_TRUE(ask(id).kept);
    EXPECT_FALSE(ask(id, 0, true).kept) << "everything is kept there, which is another frame";
    EXPECT_FALSE(renderer().visibility(0, {id, small(id), false}, false, control_).kept) << "nobody asked for reuse";
}

TEST_P(KeptFramesGl, NothingIsCompiledOrHeldForALightThatNeedsNothing) {
    const std::string& id = GetParam();
    Scene scene = two_lights();
    scene.lights[0].casts_shadow = false;
    Renderer own;  // one that has compiled nothing yet
    own.set_scene(scene);
    static_cast<void>(own.view(control_));
    const WorkDone before = own.work();
    const VisibilityResult made = own.visibility(0, {id, small(id), false}, false, control_);
    EXPECT_EQ(own.work().programs, before.programs);
    EXPECT_EQ(own.work().ray_scenes, 0U);
    EXPECT_EQ(made.memory_bytes, 0U);
    EXPECT_EQ(steps_run(made.plan), 0);
    const VisibilityResult sun = own.visibility(1, {id, small(id), false}, false, control_);
    EXPECT_GT(steps_run(sun.plan), 0);
    EXPECT_GT(own.work().programs + own.work().ray_scenes, before.programs);
}

TEST_F(KeptFramesGl, WhatIsKeptStaysWithinItsBytesAndTheOldestGoes) {
    const Scene scene = two_lights();
    renderer().set_scene(scene);
    const std::size_t frame = fresh("shadow_map").size() * sizeof(float);
    RendererOptions options;
    options.most_kept_bytes = frame + frame / 2;
    Renderer tight{options};
    tight.set_scene(scene);
    Job job{"shadow_map", small("shadow_map"), false};
    job.reuse = true;
    const auto kept = [&](std::size_t light) { return tight.visibility(light, job, false, control_).kept; };
    EXPECT_FALSE(kept(0));
    EXPECT_TRUE(kept(0));
    EXPECT_FALSE(kept(1));
    EXPECT_TRUE(kept(1));
    EXPECT_FALSE(kept(0)) << "there is room for one frame";
}

TEST_F(KeptFramesGl, APointLightCompilesNoProgramOfPenumbrae) {
    for (const std::string id : {"smoothies", "penumbra_maps", "plateaus"}) {
        const auto compiled = [&](double radius_m) {
            Scene scene = two_lights();
            scene.lights[0] = scenes::point_light({0, 0, 4}, radius_m);
            Renderer own;
            own.set_scene(scene);
            static_cast<void>(own.view(control_));
            const std::uint64_t before = own.work().programs;
            static_cast<void>(own.visibility(0, {id, small(id), false}, false, control_));
            return own.work().programs - before;
        };
        EXPECT_LT(compiled(0.0), compiled(0.3)) << id;
    }
}

TEST_F(KeptFramesGl, AMovedCameraKeepsGeometryAndRaySceneAndDrawsTheViewAlone) {
    Scene scene = two_lights();
    renderer().set_scene(scene);
    static_cast<void>(ask("ray_traced"));
    const WorkDone before = renderer().work();
    scene.camera.world_from_camera[3].x += 0.05;
    renderer().set_scene(scene);
    const VisibilityResult moved = ask("ray_traced");
    const WorkDone after = renderer().work();
    EXPECT_FALSE(moved.kept);
    EXPECT_EQ(after.views, before.views + 1);
    EXPECT_EQ(after.ray_scenes, before.ray_scenes) << "no caster moved";
    EXPECT_EQ(after.geometries, before.geometries);
    EXPECT_EQ(moved.visibility, fresh("ray_traced"));
    scene.instances[2].world_from_local[3].x += 0.05;
    renderer().set_scene(scene);
    EXPECT_EQ(ask("ray_traced").visibility, fresh("ray_traced"));
    EXPECT_EQ(renderer().work().ray_scenes, after.ray_scenes + 1);
}

}  // namespace
}  // namespace penumbra
