#include <functional>

#include "techniques/renderer_fixture.h"

namespace penumbra {
namespace {

/// One change after another, each made to the scene as the one before left it.
struct Change {
    const char* what;
    std::function<void(Scene&)> make;
};

Scene furnished() {
    Scene scene;
    scene.instances.push_back(scenes::place(scenes::sheet(-6, 6, -6, 6), "ground"));
    const auto ball = scenes::sphere(8, true);
    for (int i = 0; i < 3; ++i) {
        scene.instances.push_back(scenes::place(ball, "ball " + std::to_string(i), {1.1 * i - 1.0, 0.3 * i, 1.5}));
        scene.instances.back().world_from_local *= glm::dmat4{glm::dmat3{0.4}};
    }
    scene.instances.push_back(scenes::place(scenes::box({-0.3, -0.3, 0}, {0.3, 0.3, 1}), "box", {0.5, -1.2, 0}));
    scene.lights.push_back(scenes::rectangle_light({0.5, 0.3, 4}, 1.0, 0.7));
    scene.camera = scenes::camera_from_above(2.5, 48, 32);
    return scene;
}

const std::vector<Change>& changes() {
    static const std::vector<Change> all{
        {"nothing", [](Scene&) {}},
        {"an instance moves", [](Scene& s) { s.instances[2].world_from_local[3].z += 0.4; }},
        {"the light moves", [](Scene& s) { s.lights[0].position_ws.x -= 0.6; }},
        {"the camera moves", [](Scene& s) { s.camera.world_from_camera[3].x += 0.2; }},
        {"the sample within the pixel moves",
         [](Scene& s) {
             s.camera.pixel_offset = {0.25, -0.3};
         }},
        {"the picture's size changes", [](Scene& s) { s.camera.width_px = 56; }},
        {"an albedo changes",
         [](Scene& s) {
             s.instances[0].albedo = {{0.2F, 0.5F, 0.7F}};
         }},
        {"an instance gets a second colour",
         [](Scene& s) {
             s.instances[1].albedo = {{0.9F, 0.1F, 0.1F}, {0.1F, 0.9F, 0.1F}};
         }},
        {"an instance stops casting", [](Scene& s) { s.instances[1].casts = false; }},
        {"an instance becomes invisible", [](Scene& s) { s.instances[3].visible = false; }},
        {"an instance is mirrored",
         [](Scene& s) { s.instances[4].world_from_local[0] = -s.instances[4].world_from_local[0]; }},
        {"an instance of a known mesh arrives",
         [](Scene& s) {
             s.instances.push_back(scenes::place(s.instances[4].mesh, "second box", {-1.5, 1, 0}));
         }},
        {"an instance of a new mesh arrives",
         [](Scene& s) {
             s.instances.push_back(scenes::place(scenes::sphere(5, false), "gem", {1.2, 1.2, 1.1}));
         }},
        {"two instances change places", [](Scene& s) { std::swap(s.instances[1], s.instances[4]); }},
        {"an instance gets another mesh", [](Scene& s) { s.instances[2].mesh = scenes::sphere(6, false); }},
        {"the last instance goes", [](Scene& s) { s.instances.pop_back(); }},
        {"a light arrives",
         [](Scene& s) {
             s.lights.push_back(scenes::point_light({-1, -1, 5}, 0.2));
         }},
        {"all instances but the ground go", [](Scene& s) { s.instances.resize(1); }},
        {"everything goes", [](Scene& s) { s.instances.clear(); }},
        {"everything is back", [](Scene& s) { s = furnished(); }},
    };
    return all;
}

class Following : public RendererGl {
protected:
    struct Images {
        std::vector<glm::vec3> positions, albedo;
        std::vector<std::int32_t> instances;
        std::vector<std::vector<float>> visibility;
        std::vector<std::string> plans;
        friend bool operator==(const Images&, const Images&) = default;
    };
    Images images(Renderer& from, std::size_t lights) {
        Images made;
        const auto view = from.view(control_);
        made.positions = view->position_cr;
        made.albedo = view->albedo;
        made.instances = view->instance;
        // With maps, silhouettes, volumes and rays: all that is kept on the device and off it.
        const std::vector<Job> jobs{{"shadow_map", {{"map_size", 64}}, true},
                                    {"shadow_volume", {}, true},
                                    {"penumbra_maps", {{"map_size", 64}}, true},
                                    {"ray_traced", {{"rays", 4}}, true}};
        for (std::size_t light = 0; light < lights; ++light) {
            for (const Job& job : jobs) {
                const VisibilityResult result = from.visibility(light, job, false, control_);
                made.visibility.push_back(result.visibility);
                std::string plan;
                for (const Step& step : result.plan.steps) {
                    plan += step.name + (step.run ? " run; " : " left out; ") + step.reason;
                }
                made.plans.push_back(plan);
            }
            made.visibility.push_back(from.reference(light, {.standard_error = 0.1}, control_).area);
        }
        return made;
    }
};

TEST_F(Following, AfterEachChangeTheImagesAreThoseOfARendererThatKnowsNothingElse) {
    Scene scene = furnished();
    renderer().set_scene(scene);
    static_cast<void>(images(renderer(), scene.lights.size()));
    for (const Change& change : changes()) {
        change.make(scene);
        renderer().set_scene(scene);
        const Images followed = images(renderer(), scene.lights.size());
        Renderer fresh;
        fresh.set_scene(scene);
        EXPECT_TRUE(followed == images(fresh, scene.lights.size())) << "after this: " << change.what;
    }
}

TEST_F(Following, ChangesThatNobodyLookedAtBetweenAddUp) {
    Scene scene = furnished();
    renderer().set_scene(scene);
    for (const Change& change : changes()) {
        change.make(scene);
        renderer().set_scene(scene);
    }
    Renderer fresh;
    fresh.set_scene(scene);
    EXPECT_TRUE(images(renderer(), scene.lights.size()) == images(fresh, scene.lights.size()));
}

TEST_F(Following, ARefusedSceneBetweenTwoChangesLeavesNoTrace) {
    Scene scene = furnished();
    renderer().set_scene(scene);
    static_cast<void>(images(renderer(), 1));
    Scene broken = scene;
    broken.instances[1].mesh = scenes::sphere(4, true);
    broken.instances[2].world_from_local[3].x = std::nan("");
    EXPECT_THROW(renderer().set_scene(broken), InvalidScene);
    scene.instances[3].world_from_local[3].y -= 0.5;
    renderer().set_scene(scene);
    Renderer fresh;
    fresh.set_scene(scene);
    EXPECT_TRUE(images(renderer(), 1) == images(fresh, 1));
}

TEST_F(Following, TheViewIsMadeAnewForAnotherCameraOrInstanceAndForNothingElse) {
    Scene scene = furnished();
    renderer().set_scene(scene);
    const auto first = renderer().view(control_);
    scene.lights[0].position_ws.x += 1.0;
    scene.lights.push_back(scenes::sun_light({0, 0, -1}, 0.1));
    renderer().set_scene(scene);
    EXPECT_EQ(renderer().view(control_), first) << "lights are not in the view";
    scene.camera.pixel_offset.x = 0.5;
    renderer().set_scene(scene);
    const auto second = renderer().view(control_);
    EXPECT_NE(second, first);
    scene.instances[1].world_from_local[3].z += 0.1;
    renderer().set_scene(scene);
    EXPECT_NE(renderer().view(control_), second);
}

}  // namespace
}  // namespace penumbra
