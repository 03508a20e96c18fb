#include "passes/field_of_use.h"

#include <gtest/gtest.h>

#include "passes/made_view.h"
#include "support/scenes.h"

namespace penumbra {
namespace {

/// A box over a ground, seen from above.
Scene ground_and_box(const Light& light, const glm::dvec3& box_at, float half_m = 0.5F) {
    Scene scene;
    scene.instances.push_back(scenes::place(scenes::sheet(-50, 50, -50, 50), "ground"));
    scene.instances.push_back(scenes::place(scenes::box(glm::vec3{-half_m}, glm::vec3{half_m}), "box", box_at));
    scene.lights.push_back(light);
    scene.camera = scenes::camera_from_above(2.0, 64, 64);
    return scene;
}

/// Ids of what is warned of.
std::vector<std::string> warned(Scene scene, const FieldOfUse& field, std::string* sentence = nullptr) {
    validate(scene);
    const View view = view_of_ground(scene.camera);
    std::vector<Bounds> bounds;
    for (const Instance& instance : scene.instances) {
        bounds.push_back(bounds_of(instance));
    }
    const LightSummary summary = summarise_light(scene, view, scene.lights[0], bounds, false);
    std::vector<std::string> ids;
    for (const Warning& warning : outside_field(field, summary)) {
        ids.push_back(warning.id);
        EXPECT_FALSE(warning.reason.empty());
        if (sentence != nullptr) {
            *sentence = warning.reason;
        }
    }
    return ids;
}

using Ids = std::vector<std::string>;
const glm::dvec3 kAbove{0.0, 0.0, 1.0};

TEST(FieldOfUse, ATechniqueThatTakesNothingForGrantedWarnsOfNothing) {
    EXPECT_EQ(warned(ground_and_box(scenes::rectangle_light({0, 0, 1}, 9, 9), kAbove), {}), Ids{});
}

TEST(FieldOfUse, OnePointForALightIsSaidWhereTheLightHasAnExtent) {
    const FieldOfUse field{.needs_point_light = true};
    std::string sentence;
    EXPECT_EQ(warned(ground_and_box(scenes::rectangle_light({0, 0, 5}, 2, 1), kAbove), field, &sentence),
              Ids{"hard-shadow"});
    EXPECT_EQ(sentence, "the light is 2 x 1 m large and one point stands for it: no penumbra is drawn");
    EXPECT_EQ(warned(ground_and_box(scenes::sun_light({0, 0, -1}, 0.1), kAbove), field), Ids{"hard-shadow"});
    EXPECT_EQ(warned(ground_and_box(scenes::point_light({0, 0, 5}, 0.0), kAbove), field), Ids{});
}

TEST(FieldOfUse, AnUmbraThatEndsBeforeTheReceiversIsSaidWithItsLength) {
    // Box of half width 0.5 at 1 m, light at 5 m, so 4 m apart: with a light of radius R the umbra is 0.5 * 4 / (R -
    // 0.5) long, and the farthest receiver is 1 + 2 sqrt 2 = 3.8 m away. The limit is R = 1.02.
    const FieldOfUse field{.needs_small_light = true};
    std::string sentence;
    EXPECT_EQ(warned(ground_and_box(scenes::point_light({0, 0, 5}, 0.9), kAbove), field), Ids{});
    EXPECT_EQ(warned(ground_and_box(scenes::point_light({0, 0, 5}, 1.5), kAbove), field, &sentence),
              Ids{"umbra-never-ends"});
    EXPECT_EQ(sentence,
              "the light is 3 m wide, so that the umbra of \"box\" ends 2 m behind it, but is drawn black all the way");
    // A sun's narrows by tan(angle / 2): 0.5 / tan(0.1) = 5 m, 0.5 / tan(0.2) = 2.5 m.
    EXPECT_EQ(warned(ground_and_box(scenes::sun_light({0, 0, -1}, 0.2), kAbove), field), Ids{});
    EXPECT_EQ(warned(ground_and_box(scenes::sun_light({0, 0, -1}, 0.4), kAbove), field), Ids{"umbra-never-ends"});
}

TEST(FieldOfUse, ACasterAtTheLightIsToldFromARoomAroundIt) {
    const FieldOfUse field{.needs_clear_light = true};
    const Light light = scenes::rectangle_light({0, 0, 5}, 1, 1);
    EXPECT_EQ(warned(ground_and_box(light, {0, 0, 4.4}), field), Ids{});
    EXPECT_EQ(warned(ground_and_box(light, {0, 0, 4.5 - 1e-6}), field), Ids{"caster-at-light"});
    EXPECT_EQ(warned(ground_and_box(light, {0.9, 0, 5}), field), Ids{"caster-at-light"}) << "through the light";
    EXPECT_EQ(warned(ground_and_box(light, {0, 0, 5}, 3.0F), field), Ids{}) << "the light in the midst of a room";
}

TEST(FieldOfUse, CastersThatFloat32RaysMissAreSaid) {
    const FieldOfUse field{.needs_float32_rays = true};
    const Light light = scenes::rectangle_light({0, 0, 5}, 0.1, 0.1);
    EXPECT_EQ(warned(ground_and_box(light, {0, 0, 4.5 - 1e-5}), field), Ids{"caster-under-float32"});
    EXPECT_EQ(warned(ground_and_box(light, {0, 0, 4.49}), field), Ids{});
}

TEST(FieldOfUse, ALightUnderTheHorizonIsSaidOfAFewKindsAlike) {
    const FieldOfUse field{.needs_light_above_horizon = true};
    const glm::dvec3 beside{0.0, 0.0, 0.5};
    Light upright = scenes::rectangle_light({5, 0, 0.2}, 1, 1);
    upright.half_u_ws = {0, 0.5, 0};
    upright.half_v_ws = {0, 0, 0.5};
    upright.direction_ws = {-1, 0, 0};
    Light line = upright;
    line.kind = LightKind::Line;
    line.half_u_ws = upright.half_v_ws;
    line.half_v_ws = glm::dvec3{0.0};
    for (const Light& light :
         {upright, line, scenes::point_light({5, 0, 0.2}, 0.5), scenes::sun_light({-1, 0, -0.01}, 0.1)}) {
        EXPECT_EQ(warned(ground_and_box(light, beside), field), Ids{"light-under-horizon"}) << to_string(light.kind);
        Light higher = light;
        higher.position_ws.z = 3.0;
        higher.direction_ws = light.kind == LightKind::Sun ? glm::dvec3{-1, 0, -1} : light.direction_ws;
        EXPECT_EQ(warned(ground_and_box(higher, beside), field), Ids{}) << to_string(light.kind);
    }
}

TEST(FieldOfUse, ShapesThatADiscOrALineCannotStandForAreSaid) {
    const FieldOfUse disc{.needs_round_light = true};
    EXPECT_EQ(warned(ground_and_box(scenes::rectangle_light({0, 0, 5}, 3, 1), kAbove), disc), Ids{});
    EXPECT_EQ(warned(ground_and_box(scenes::rectangle_light({0, 0, 5}, 9, 1), kAbove), disc), Ids{"long-light"});
    const FieldOfUse line{.needs_line_light = true};
    EXPECT_EQ(warned(ground_and_box(scenes::rectangle_light({0, 0, 5}, 1, 1), kAbove), line), Ids{});
    EXPECT_EQ(warned(ground_and_box(scenes::point_light({0, 0, 5}, 0.5), kAbove), line), Ids{"line-for-round-light"});
}

TEST(FieldOfUse, WhereNothingIsAskedNothingIsWarnedOf) {
    FieldOfUse field{.needs_point_light = true, .needs_small_light = true, .needs_clear_light = true};
    Scene empty = ground_and_box(scenes::rectangle_light({0, 0, 5}, 1, 1), kAbove);
    empty.instances[0].casts = empty.instances[1].casts = false;
    EXPECT_EQ(warned(empty, field), Ids{});
    Scene unshadowed = ground_and_box(scenes::rectangle_light({0, 0, 5}, 1, 1), kAbove);
    unshadowed.lights[0].casts_shadow = false;
    EXPECT_EQ(warned(unshadowed, field), Ids{});
}

}  // namespace
}  // namespace penumbra
