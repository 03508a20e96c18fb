// Each rule that leaves work out: a scene on which it fires, one on which it must not, and the same image without it.
#include "techniques/renderer_fixture.h"

namespace penumbra {
namespace {

class PlanGl : public RendererGl {
protected:
    Plan plan_of(const Scene& scene, const std::string& technique, bool keep_everything = false) {
        renderer().set_scene(scene);
        return renderer().visibility(0, {technique, {}}, keep_everything, control_).plan;
    }
    static bool fires(const Plan& plan, const std::string& rule) {
        return std::any_of(plan.steps.begin(), plan.steps.end(),
                           [&](const Step& step) { return !step.run && step.rule == rule; });
    }
    void expect_fires(const std::string& rule, const Scene& scene, const std::vector<std::string>& ids) {
        for (const std::string& id : ids) {
            EXPECT_TRUE(fires(plan_of(scene, id), rule)) << id << " " << rule;
            EXPECT_FALSE(fires(plan_of(scene, id, true), rule)) << id << ": keep_everything must keep";
            EXPECT_EQ(visibility(scene, id, {}, false), visibility(scene, id, {}, true)) << id << " " << rule;
        }
    }
    void expect_silent(const std::string& rule, const Scene& scene, const std::vector<std::string>& ids) {
        for (const std::string& id : ids) {
            EXPECT_FALSE(fires(plan_of(scene, id), rule)) << id << " " << rule;
        }
    }
    static Scene plain() { return scenes::straight_edge(scenes::rectangle_light({0, 0, 4}, 1, 1), 1.0); }
    static Scene with_box_at(const glm::dvec3& at) {
        Scene scene = plain();
        scene.instances.push_back(scenes::place(scenes::box({-0.2F, -0.2F, -0.2F}, {0.2F, 0.2F, 0.2F}), "box", at));
        return scene;
    }
    const std::vector<std::string> all_{"shadow_map", "pcf", "light_samples", "ray_traced"};
    const std::vector<std::string> maps_{"shadow_map", "pcf", "light_samples"};
};

TEST_F(PlanGl, ALightThatLightsNoVisiblePixelIsLeftOut) {
    Scene below = plain();
    below.lights[0].position_ws.z = -4.0;
    expect_fires("light-without-pixels", below, all_);
    expect_silent("light-without-pixels", plain(), all_);
}

TEST_F(PlanGl, ALightWithoutShadowIsLeftOut) {
    Scene scene = plain();
    scene.lights[0].casts_shadow = false;
    // Here the image would change: the switch is the artist's wish, no saving. So V is 1 with and without the rule.
    for (const std::string& id : all_) {
        EXPECT_TRUE(fires(plan_of(scene, id), "light-without-shadow"));
        for (const bool keep : {false, true}) {
            for (const float v : visibility(scene, id, {}, keep)) {
                ASSERT_EQ(v, 1.0F) << id;
            }
        }
    }
    expect_silent("light-without-shadow", plain(), all_);
}

TEST_F(PlanGl, ALightWithoutCastersInReachIsLeftOut) {
    Scene scene = with_box_at({8, 0, 3});
    scene.instances[0].casts = false;  // the ground itself is always in reach
    scene.instances.erase(scene.instances.begin() + 1);
    expect_fires("light-without-casters", scene, all_);
    expect_silent("light-without-casters", plain(), all_);
}

TEST_F(PlanGl, CastersOutsideTheHullAreLeftOut) {
    expect_fires("caster-outside-hull", with_box_at({8, 0, 3}), maps_);
    expect_silent("caster-outside-hull", with_box_at({0.5, 0, 2}), maps_);
}

TEST_F(PlanGl, CubeFacesWithoutReceiversAreLeftOut) {
    Scene wide = scenes::straight_edge(scenes::point_light({0, 0, 1}, 0.1), 0.5, 0.0, 128, 8.0);
    wide.camera = scenes::camera_from_above(8.0, 128, 128);
    expect_fires("cube-face-without-receivers", wide, {"shadow_map", "pcf"});
    expect_silent("cube-face-without-receivers", plain(), {"shadow_map", "pcf"});
}

TEST_F(PlanGl, OneSampleServesALightWithoutExtent) {
    const Scene point = scenes::straight_edge(scenes::point_light({0, 0, 4}, 0.0), 1.0);
    for (const std::string id : {"light_samples", "ray_traced"}) {
        EXPECT_TRUE(fires(plan_of(point, id), "light-without-extent")) << id;
        EXPECT_EQ(visibility(point, id, {}, false), visibility(point, id, {}, true)) << id;
    }
    expect_silent("light-without-extent", plain(), {"light_samples", "ray_traced"});
}

TEST_F(PlanGl, PixelsOutsideTheMaskGetNoRays) {
    Scene scene = plain();
    scene.instances[0] = scenes::place(scenes::sheet(-50, 0.5, -50, 50), "ground");
    expect_fires("pixel-outside-mask", scene, {"ray_traced"});
    expect_silent("pixel-outside-mask", plain(), {"ray_traced"});
}

TEST_F(PlanGl, EveryRuleThatFiresIsListed) {
    for (const RuleInfo& rule : rules()) {
        EXPECT_FALSE(rule.id.empty());
        EXPECT_FALSE(rule.condition.empty());
        EXPECT_GE(rule.tolerance, 0.0);
    }
    const Plan plan = plan_of(with_box_at({8, 0, 3}), "shadow_map");
    for (const Step& step : plan.steps) {
        if (!step.run) {
            EXPECT_TRUE(std::any_of(rules().begin(), rules().end(), [&](const RuleInfo& r) {
                return r.id == step.rule;
            })) << step.rule;
            EXPECT_FALSE(step.reason.empty());
        }
    }
}

TEST_F(PlanGl, TheReferenceLeavesOutOnlyRaysThatDecideNothing) {
    Scene scene = scenes::straight_edge(scenes::rectangle_light({0, 0, 4}, 1, 1), 1.0, 0.0, 64, 2.0);
    renderer().set_scene(scene);
    const Reference planned = renderer().reference(0, {.standard_error = 0.01}, control_);
    const Reference everything = renderer().reference(0, {.standard_error = 0.01, .keep_everything = true}, control_);
    EXPECT_LT(planned.rays, everything.rays / 2);
    std::size_t beyond = 0;
    for (std::size_t i = 0; i < planned.area.size(); ++i) {
        const double se = std::hypot(planned.standard_error[i], everything.standard_error[i]);
        beyond += std::abs(planned.area[i] - everything.area[i]) > 4.0 * std::max(se, 1e-4) ? 1 : 0;
    }
    EXPECT_LE(beyond, planned.area.size() / 1000);
}

}  // namespace
}  // namespace penumbra
