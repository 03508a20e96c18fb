// Every rule that leaves work out, by its id: a scene on which it fires, one on which it must not, and the image with
// that rule alone and with everything kept. A rule of the table without a proof here fails.
#include <functional>
#include <map>
#include <set>

#include "techniques/renderer_fixture.h"

namespace penumbra {
namespace {

/// Small maps and few samples: what is proved holds of any.
Settings small(const std::string& technique, Settings wanted = {}) {
    static const std::map<std::string, SettingValue> few{{"map_size", 128}, {"mask_size", 128}, {"samples", 4},
                                                         {"rays", 16},      {"check_rays", 0},  {"lights", 1}};
    for (const TechniqueInfo& info : techniques()) {
        for (const SettingInfo& setting : info.settings) {
            const auto found = few.find(setting.id);
            if (info.id == technique && found != few.end() && setting.default_value.index() == 1) {
                wanted.try_emplace(setting.id, found->second);
            }
        }
    }
    return wanted;
}

Scene plain() {
    return scenes::straight_edge(scenes::rectangle_light({0, 0, 4}, 1, 1), 1.0, 0.0, 64);
}
Scene with(Scene scene, const std::shared_ptr<Mesh>& mesh, const glm::dvec3& at) {
    scene.instances.push_back(scenes::place(mesh, "more", at));
    return scene;
}
Scene with_box(const glm::dvec3& at, float half = 0.2F) {
    return with(plain(), scenes::box(glm::vec3{-half}, glm::vec3{half}), at);
}
Scene lit_by(const Light& light) {
    return scenes::straight_edge(light, 1.0, 0.0, 64);
}
/// A ball over a ground, by a perspective camera; no caster comes between eye and light.
Scene ball_in_perspective(const glm::dvec3& ball) {
    Scene scene = with(plain(), scenes::sphere(8, false), ball);
    scene.instances.erase(scene.instances.begin() + 1);
    scene.camera.orthographic = false;
    scene.camera.tan_half_width = 0.4;
    scene.camera.world_from_camera[3] = glm::dvec4{0, 0, 12, 1};
    scene.camera.height_px = 48;
    scene.camera.near_m = 0.1;
    scene.camera.far_m = 100.0;
    return scene;
}
Light line_light(double half_m) {
    Light light = scenes::rectangle_light({0, 0, 4}, 2.0 * half_m, 1);
    light.kind = LightKind::Line;
    light.half_v_ws = glm::dvec3{0.0};
    return light;
}

class Rules : public RendererGl, public testing::WithParamInterface<std::string> {
protected:
    VisibilityResult made(const Scene& scene, const Job& job, bool keep_everything = false) {
        renderer().set_scene(scene);
        return renderer().visibility(0, job, keep_everything, control_);
    }
    static bool fires(const Plan& plan, const std::string& rule) {
        return std::ranges::any_of(plan.steps, [&](const Step& step) { return !step.run && step.rule == rule; });
    }
};

/// What must be shown of a rule that plans tell of.
struct Proof {
    std::function<Scene()> fires, silent;
    Settings settings{};                   ///< of the technique, where the rule asks for some
    Settings silent_settings{};            ///< the same, for the scene on which it must not fire
    std::map<std::string, Proof> other{};  ///< techniques that need other scenes
    bool holds_always = false;             ///< what it leaves out is the artist's wish: nothing can keep it
};

const std::map<std::string, Proof>& proofs() {
    const auto point = [] { return lit_by(scenes::point_light({0, 0, 4}, 0.0)); };
    const auto tiny = [] { return lit_by(scenes::rectangle_light({0, 0, 4}, 1e-4, 1e-4)); };
    const auto floating_ground = [] {
        Scene scene = plain();
        scene.instances[0].casts = false;
        return scene;
    };
    const auto many_sides = [] {
        Scene scene = scenes::straight_edge(scenes::point_light({0, 0, 1}, 0.1), 0.5, 0.0, 64, 8.0);
        scene.camera = scenes::camera_from_above(8.0, 40, 40);
        return with(scene, scenes::sphere(6, false), {2.0, 0.0, 0.3});
    };
    // A line in the middle of a ball, whose inside is seen all around it from a hole in its wall.
    const auto inside_a_ball = [] {
        Scene scene = plain();
        scene.instances = {scenes::place(scenes::sphere(12, false), "room")};
        scene.instances[0].world_from_local = glm::dmat4{glm::dmat3{3.0}};
        scene.lights[0] = line_light(0.5);
        scene.lights[0].position_ws = glm::dvec3{0.0};
        scene.camera = ball_in_perspective({}).camera;
        scene.camera.tan_half_width = 5.0;
        scene.camera.width_px = scene.camera.height_px = 48;
        scene.camera.near_m = 1e-3;
        scene.camera.world_from_camera[3] = glm::dvec4{0.0, 0.0, 2.7, 1.0};
        return scene;
    };
    const auto envelope_off = [] { return lit_by(scenes::rectangle_light({0, 0, 4}, 1e-4, 1e-4)); };
    static const std::map<std::string, Proof> all{
        {"light-without-pixels",
         {.fires =
              [] {
                  Scene below = plain();
                  below.lights[0].position_ws.z = -4.0;
                  return below;
              },
          .silent = plain}},
        {"light-without-shadow",
         {.fires =
              [] {
                  Scene scene = plain();
                  scene.lights[0].casts_shadow = false;
                  return scene;
              },
          .silent = plain,
          .holds_always = true}},
        {"light-without-casters",
         {.fires =
              [] {
                  Scene scene = with_box({8, 0, 3});
                  scene.instances[0].casts = false;  // the ground itself is always in reach
                  scene.instances.erase(scene.instances.begin() + 1);
                  return scene;
              },
          .silent = plain}},
        {"light-without-extent", {.fires = point, .silent = plain}},
        {"caster-outside-hull",
         {.fires =
              [] {
                  return with_box({8, 0, 3});
              },
          .silent = plain}},
        {"caster-outside-face",
         // Before a part of the light, but beside all lines from its centre to what is seen.
         {.fires =
              [] {
                  return with_box({0.62, 0.0, 3.6}, 0.05F);
              },
          .silent = plain,
          .other = {{"plateaus",  // for a ground's own plane the ground is beside
                     {.fires =
                          [] {
                              return with_box({0.62, 0.0, 3.6}, 0.05F);
                          },
                      .silent = floating_ground}}}}},
        {"cube-face-without-receivers",
         {.fires = many_sides,
          .silent = plain,
          .other = {{"linear_light_maps", {.fires = many_sides, .silent = inside_a_ball}}}}},
        {"every-receiver-casts", {.fires = plain, .silent = floating_ground}},
        {"penumbra-under-half-a-texel", {.fires = tiny, .silent = plain}},
        {"skin-under-threshold",
         {.fires = [] { return lit_by(line_light(1e-4)); }, .silent = [] { return lit_by(line_light(0.5)); }}},
        {"every-receiver-on-a-plane",
         {.fires = plain,
          .silent =
              [] {
                  return with(plain(), scenes::sphere(8, false), {0.8, 0, 0.5});
              }}},
        {"silhouette-under-umbra", {.fires = plain, .silent = tiny}},
        {"slope-never-darkest", {.fires = plain, .silent = envelope_off}},
        {"texel-without-pixel", {.fires = plain, .silent = tiny}},
        {"eye-outside-volume",
         {.fires =
              [] {
                  return ball_in_perspective({1.0, 0.3, 1.2});
              },
          .silent =
              [] {
                  return with(plain(), scenes::sphere(8, false), {0.8, 0, 1.2});
              }}},
        {"smoothie-without-width",
         {.fires = plain,
          .silent = plain,
          .settings = {{"width", std::string{"fixed"}}, {"t", 0.0}},
          .silent_settings = {{"width", std::string{"fixed"}}, {"t", 0.05}}}},
        {"kernel-on-one-side",
         {.fires = plain, .silent = plain, .settings = {{"kernel", 31}}, .silent_settings = {{"kernel", 5}}}},
        {"mask-without-penumbra",
         {.fires = point,
          .silent = plain,
          .other = {{"light_samples",
                     {.fires = point,
                      .silent = plain,
                      .settings = {{"mask", true}},
                      .silent_settings = {{"mask", true}}}}}}},
        {"pixel-outside-mask",
         {.fires =
              [] {
                  Scene scene = with(plain(), scenes::sphere(8, false), {-1.0, 0, 2.4});  // parts of it face away
                  scene.instances[0] = scenes::place(scenes::sheet(-50, 0.5, -50, 50), "ground");
                  return scene;
              },
          .silent = plain}},
    };
    return all;
}

/// Rules that no plan of one frame can tell of; each has a test of its own, below, in kept_frames_gl_test.cpp or, for
/// what depends on the device, in hybrid_gl_test.cpp.
const std::set<std::string>& proved_apart() {
    static const std::set<std::string> all{"instance-without-effect", "frame-unchanged", "reference-pixel-decided",
                                           "device-without-depth-bounds"};
    return all;
}

std::vector<std::string> rule_ids() {
    std::vector<std::string> ids;
    for (const RuleInfo& rule : rules()) {
        ids.push_back(rule.id);
    }
    return ids;
}

INSTANTIATE_TEST_SUITE_P(Table, Rules, testing::ValuesIn(rule_ids()), [](const auto& made) {
    std::string name = made.param;
    std::ranges::replace(name, '-', '_');
    return name;
});

TEST_P(Rules, FiresWhereItShouldAndNowhereElseAndChangesNothing) {
    const RuleInfo& rule = *std::ranges::find(rules(), GetParam(), &RuleInfo::id);
    EXPECT_FALSE(rule.condition.empty());
    EXPECT_GE(rule.tolerance, 0.0);
    if (proved_apart().contains(rule.id)) {
        return;
    }
    const auto found = proofs().find(rule.id);
    ASSERT_NE(found, proofs().end()) << "a rule needs a scene on which it fires, and one on which it must not: add "
                                     << "them to proofs()";
    ASSERT_FALSE(rule.techniques.empty());
    for (const std::string& id : rule.techniques) {
        const auto other = found->second.other.find(id);
        const Proof& proof = other != found->second.other.end() ? other->second : found->second;
        const Scene scene = proof.fires();
        const Job job{id, small(id, proof.settings), false};
        Job kept_job = job;
        kept_job.keep_rules = {rule.id};
        const VisibilityResult planned = made(scene, job);
        EXPECT_TRUE(fires(planned.plan, rule.id)) << id;
        for (const Step& step : planned.plan.steps) {
            EXPECT_EQ(step.run, step.rule.empty()) << id;
            EXPECT_EQ(step.run, step.reason.empty()) << id;
        }
        const VisibilityResult kept = made(scene, kept_job);
        const VisibilityResult everything = made(scene, job, true);
        EXPECT_EQ(fires(kept.plan, rule.id), proof.holds_always) << id;
        EXPECT_EQ(fires(everything.plan, rule.id), proof.holds_always) << id;
        EXPECT_LE(largest_difference(planned.visibility, kept.visibility), rule.tolerance) << id;
        EXPECT_LE(largest_difference(planned.visibility, everything.visibility), rule.tolerance) << id;
        const Job silent{id, small(id, proof.silent_settings), false};
        EXPECT_FALSE(fires(made(proof.silent(), silent).plan, rule.id)) << id;
    }
}

TEST_P(Rules, FiresInNoTechniqueThatTheTableDoesNotName) {
    const RuleInfo& rule = *std::ranges::find(rules(), GetParam(), &RuleInfo::id);
    for (const std::string& id : rule.techniques) {
        EXPECT_TRUE(std::ranges::any_of(techniques(), [&](const TechniqueInfo& info) { return info.id == id; })) << id;
    }
    const auto found = proofs().find(rule.id);
    if (found == proofs().end()) {
        return;
    }
    for (const TechniqueInfo& info : techniques()) {
        const Plan plan = made(found->second.fires(), {info.id, small(info.id), false}).plan;
        for (const Step& step : plan.steps) {
            const auto other = std::ranges::find(rules(), step.rule, &RuleInfo::id);
            ASSERT_TRUE(step.run || other != rules().end()) << info.id << " " << step.rule;
            if (!step.run) {
                EXPECT_TRUE(std::ranges::count(other->techniques, info.id)) << info.id << " " << step.rule;
                EXPECT_EQ(step.tolerance, other->tolerance) << step.rule;
            }
        }
    }
}

TEST_F(Rules, ThereIsNoProofWithoutARule) {
    for (const auto& [id, proof] : proofs()) {
        EXPECT_TRUE(std::ranges::count(rules(), id, &RuleInfo::id)) << id;
        EXPECT_FALSE(proved_apart().contains(id)) << id;
    }
    for (const std::string& id : proved_apart()) {
        EXPECT_TRUE(std::ranges::count(rules(), id, &RuleInfo::id)) << id;
    }
}

TEST_F(Rules, ARuleThatIsNotThereCannotBeKept) {
    renderer().set_scene(plain());
    EXPECT_THROW(static_cast<void>(renderer().visibility(0, {"pcf", {}, false, {"no-such-rule"}}, false, control_)),
                 InvalidSettings);
}

TEST_F(Rules, AnInstanceThatNobodySeesAndThatCastsNothingIsNotSent) {
    Scene scene = with_box({0.5, 0, 2});
    const auto triangles_and_image = [&](const Scene& of) {
        const std::vector<float> image = visibility(of, "plateaus", small("plateaus"));
        return std::pair{renderer().work().triangles_sent, image};
    };
    const auto whole = triangles_and_image(scene);
    Scene more = scene;
    more.instances.insert(more.instances.begin() + 1, scenes::place(scenes::sphere(16, false), "ghost", {0.3, 0, 1}));
    more.instances[1].casts = more.instances[1].visible = false;
    for (const std::string id : {"plateaus", "shadow_volume", "hybrid"}) {  // adjacency and volumes count vertices
        EXPECT_EQ(visibility(more, id, small(id)), visibility(scene, id, small(id))) << id;
    }
    EXPECT_EQ(triangles_and_image(more), whole);
    more.instances[1].casts = true;
    EXPECT_GT(triangles_and_image(more).first, whole.first) << "it casts: it must be there";
    more.instances[1].casts = false;
    more.instances[1].visible = true;
    EXPECT_GT(triangles_and_image(more).first, whole.first) << "it is seen: it must be there";
}

// A kernel looks up texels beside the receivers', and finds casters there that shade no receiver at all.
TEST_F(Rules, ACasterBesideTheHullStaysWhereAKernelFindsIt) {
    const std::string rule = "caster-outside-hull";
    for (const Light& light : {scenes::rectangle_light({0, 0, 4}, 1, 1), scenes::point_light({0, 0, 4}, 0.3),
                               scenes::sun_light({0.0, 0.0, -1.0}, 0.05)}) {
        Scene scene = lit_by(light);
        scene.instances.erase(scene.instances.begin() + 1);  // the edge
        const double half_m = scene.camera.half_width_m;
        const double beside = light.kind == LightKind::Sun ? half_m + 0.5 : 0.75 * half_m + 0.6;
        scene = with(scene, scenes::box(glm::vec3{-0.1F}, glm::vec3{0.1F}), {beside + 0.1, 0.0, 1.0});
        const auto filtered = [&](int kernel, bool keep) {
            const Settings settings{{"map_size", 128}, {"kernel", kernel}};
            return made(scene, {"pcf", settings, false, keep ? std::vector{rule} : std::vector<std::string>{}});
        };
        const VisibilityResult planned = filtered(63, false);
        const VisibilityResult kept = filtered(63, true);
        EXPECT_LT(*std::ranges::min_element(kept.visibility), 1.0F) << "the kernel must reach the box";
        EXPECT_EQ(planned.visibility, kept.visibility) << static_cast<int>(light.kind);
        EXPECT_FALSE(fires(planned.plan, rule)) << static_cast<int>(light.kind);
        EXPECT_TRUE(fires(filtered(3, false).plan, rule)) << static_cast<int>(light.kind) << ": a narrow kernel";
        EXPECT_EQ(filtered(3, false).visibility, filtered(3, true).visibility);
        const Job again{"pcf", {{"map_size", 128}, {"kernel", 63}}, false, {}, true};
        EXPECT_FALSE(made(scene, again).kept);
        EXPECT_TRUE(made(scene, again).kept);
        scene.instances.back().world_from_local[3].x += 0.01;
        EXPECT_FALSE(made(scene, again).kept) << "a kept frame knows what lies beside the hull";
    }
}

TEST_F(Rules, TheReferenceLeavesOutOnlyRaysThatDecideNothing) {
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
    // Penumbra everywhere: no pixel is decided by its pilot rays, and every ray is cast.
    Scene soft = scenes::straight_edge(scenes::rectangle_light({0, 0, 4}, 30, 30), 3.0, 0.0, 32, 0.3);
    renderer().set_scene(soft);
    EXPECT_EQ(renderer().reference(0, {.standard_error = 0.02}, control_).pixels_skipped, 0U);
}

}  // namespace
}  // namespace penumbra
