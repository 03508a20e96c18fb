#include "passes/light_summary.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>

#include "passes/made_view.h"
#include "support/scenes.h"

namespace penumbra {
namespace {

std::vector<Bounds> instance_bounds(const Scene& scene) {
    std::vector<Bounds> bounds;
    for (const Instance& instance : scene.instances) {
        bounds.push_back(bounds_of(instance));
    }
    return bounds;
}

LightSummary summarise(Scene& scene, bool keep_everything = false) {
    validate(scene);
    return summarise_light(scene, view_of_ground(scene.camera), scene.lights[0], instance_bounds(scene),
                           keep_everything);
}

Scene ground_and_box(const Light& light, const glm::dvec3& box_at) {
    Scene scene;
    scene.instances.push_back(scenes::place(scenes::sheet(-50, 50, -50, 50), "ground"));
    scene.instances.push_back(scenes::place(scenes::box({-0.5F, -0.5F, -0.5F}, {0.5F, 0.5F, 0.5F}), "box", box_at));
    scene.lights.push_back(light);
    scene.camera = scenes::camera_from_above(2.0, 64, 64);
    return scene;
}

bool keeps_box(const LightSummary& summary) {
    return std::find(summary.casters.begin(), summary.casters.end(), 1U) != summary.casters.end();
}

TEST(LightSummary, CountsEveryPixelOfTheMask) {
    Scene scene = ground_and_box(scenes::rectangle_light({0, 0, 5}, 1, 1), {0, 0, 2});
    const LightSummary summary = summarise(scene);
    EXPECT_EQ(summary.lit_pixels, 64U * 64U);
    EXPECT_EQ(summary.receiver_points_cr.size(), 64U * 64U);
    std::size_t in_tiles = 0;
    for (const ReceiverTile& tile : summary.tiles) {
        for (std::uint32_t k = 0; k < tile.pixel_count; ++k) {
            const glm::vec3& p = summary.receiver_points_cr[tile.first_pixel + k];
            EXPECT_TRUE(glm::all(glm::lessThanEqual(tile.low_cr, p)));
            EXPECT_TRUE(glm::all(glm::greaterThanEqual(tile.high_cr, p)));
        }
        in_tiles += tile.pixel_count;
    }
    EXPECT_EQ(in_tiles, 64U * 64U);
}

TEST(LightSummary, KeepsACasterBetweenLightAndReceivers) {
    Scene scene = ground_and_box(scenes::rectangle_light({0, 0, 5}, 1, 1), {0, 0, 2});
    EXPECT_TRUE(keeps_box(summarise(scene)));
}

TEST(LightSummary, LeavesOutACasterBesideTheHull) {
    Scene scene = ground_and_box(scenes::rectangle_light({0, 0, 5}, 1, 1), {4.0, 0, 3});
    const LightSummary summary = summarise(scene);
    EXPECT_FALSE(keeps_box(summary));
    EXPECT_EQ(summary.casters_outside, 1U);
}

TEST(LightSummary, LeavesOutACasterAboveTheLight) {
    Scene scene = ground_and_box(scenes::rectangle_light({0, 0, 5}, 1, 1), {0, 0, 7});
    EXPECT_FALSE(keeps_box(summarise(scene)));
}

TEST(LightSummary, LeavesOutACasterBelowTheGround) {
    Scene scene = ground_and_box(scenes::point_light({0, 0, 5}, 0.2), {0, 0, -2});
    EXPECT_FALSE(keeps_box(summarise(scene)));
}

TEST(LightSummary, ASunSeesCastersAtAnyDistanceUpstream) {
    Scene near_by = ground_and_box(scenes::sun_light({0, 0, -1}, 0.01), {0, 0, 2});
    Scene far_away = ground_and_box(scenes::sun_light({0, 0, -1}, 0.01), {0, 0, 1e5});
    Scene beside = ground_and_box(scenes::sun_light({0, 0, -1}, 0.01), {40, 0, 2});
    EXPECT_TRUE(keeps_box(summarise(near_by)));
    EXPECT_TRUE(keeps_box(summarise(far_away)));
    EXPECT_FALSE(keeps_box(summarise(beside)));
}

TEST(LightSummary, KeepEverythingKeepsWhatIsOutside) {
    Scene scene = ground_and_box(scenes::rectangle_light({0, 0, 5}, 1, 1), {4.0, 0, 3});
    const LightSummary summary = summarise(scene, true);
    EXPECT_TRUE(keeps_box(summary));
    EXPECT_EQ(summary.caster_needed.back(), 0);
    EXPECT_TRUE(summary.trivial().reason.empty());
}

TEST(LightSummary, SaysWhyALightNeedsNoWork) {
    Scene below = ground_and_box(scenes::rectangle_light({0, 0, -5}, 1, 1), {0, 0, 2});
    EXPECT_EQ(summarise(below).trivial().rule, "light-without-pixels");
    Scene shadowless = ground_and_box(scenes::rectangle_light({0, 0, 5}, 1, 1), {0, 0, 2});
    shadowless.lights[0].casts_shadow = false;
    EXPECT_EQ(summarise(shadowless).trivial().rule, "light-without-shadow");
    Scene alone = ground_and_box(scenes::rectangle_light({0, 0, 5}, 1, 1), {0, 0, 2});
    for (Instance& instance : alone.instances) {
        instance.casts = false;
    }
    EXPECT_EQ(summarise(alone).trivial().rule, "light-without-casters");
}

// The rule is exact: whatever it leaves out, no segment from a point of the light to a receiver meets its box.
TEST(LightSummary, NeverLeavesOutACasterThatASegmentMeets) {
    std::mt19937 random{7};
    std::uniform_real_distribution<double> place{-6.0, 6.0}, unit{-1.0, 1.0};
    int left_out = 0;
    for (int round = 0; round < 400; ++round) {
        Light light = round % 2 == 0 ? scenes::rectangle_light({place(random), place(random), 4.0}, 2, 1)
                                     : scenes::point_light({place(random), place(random), 4.0}, 0.5);
        Scene scene = ground_and_box(light, {place(random), place(random), 0.5 * place(random) + 2.0});
        scene.camera.width_px = scene.camera.height_px = 16;
        const LightSummary summary = summarise(scene);
        if (keeps_box(summary)) {
            continue;
        }
        ++left_out;
        const Bounds box = bounds_of(scene.instances[1]);
        for (int k = 0; k < 200; ++k) {
            const std::size_t i = random() % summary.receiver_points_cr.size();
            const glm::dvec3 p = summary.eye_ws + glm::dvec3{summary.receiver_points_cr[i]};
            glm::dvec3 y = light.position_ws;
            y += light.kind == LightKind::Rectangle
                     ? unit(random) * light.half_u_ws + unit(random) * light.half_v_ws
                     : light.radius_m * glm::normalize(glm::dvec3{unit(random), unit(random), unit(random) + 1e-9});
            double enter = 0.0, leave = 1.0;
            for (int a = 0; a < 3; ++a) {
                const double d = y[a] - p[a];
                double t0 = (box.low[a] - p[a]) / d, t1 = (box.high[a] - p[a]) / d;
                if (t0 > t1) {
                    std::swap(t0, t1);
                }
                enter = std::max(enter, t0);
                leave = std::min(leave, t1);
            }
            EXPECT_GT(enter, leave) << "round " << round;
        }
    }
    EXPECT_GT(left_out, 50);
}

}  // namespace
}  // namespace penumbra
