#include "passes/map_frustum.h"

#include <gtest/gtest.h>

#include <random>

#include "passes/made_view.h"
#include "support/scenes.h"

namespace penumbra {
namespace {

struct Fitted {
    Scene scene;
    LightSummary summary;
    MapFrustum frustum;
};

Fitted fit(const Light& light, double view_half_m, bool keep_everything = false,
           const glm::dvec3& caster_at = {0, 0, 1}) {
    Fitted f;
    f.scene.instances.push_back(scenes::place(scenes::sheet(-500, 500, -500, 500), "ground"));
    f.scene.instances.push_back(
        scenes::place(scenes::box({-0.2F, -0.2F, -0.2F}, {0.2F, 0.2F, 0.2F}), "box", caster_at));
    f.scene.lights.push_back(light);
    f.scene.camera = scenes::camera_from_above(view_half_m, 96, 64);
    validate(f.scene);
    std::vector<Bounds> bounds;
    for (const Instance& instance : f.scene.instances) {
        bounds.push_back(bounds_of(instance));
    }
    f.summary = summarise_light(f.scene, view_of_ground(f.scene.camera), f.scene.lights[0], bounds, keep_everything);
    f.frustum = fit_map_frustum(f.summary, light.position_ws, f.scene.lights[0].direction_ws, {.size_px = 512});
    return f;
}

/// Smallest distance of any receiver from the rim of the face that holds it, in texels; negative: in no face.
double least_margin_texels(const Fitted& f) {
    double least = 1e30;
    for (const glm::vec3& p_cr : f.summary.receiver_points_cr) {
        const glm::dvec3 p = f.summary.eye_ws + glm::dvec3{p_cr} - f.frustum.origin_ws;
        double best = -1.0;
        for (const MapFace& face : f.frustum.faces) {
            const glm::dvec3 ls = face.ls_from_world * p;
            if (!face.orthographic && ls.z <= 0.0) {
                continue;
            }
            const glm::dvec2 at = face.orthographic ? glm::dvec2{ls} : glm::dvec2{ls} / ls.z;
            const glm::dvec2 inside = glm::min(at - face.low, face.high - at) / (face.high - face.low) * 512.0;
            best = std::max(best, std::min(inside.x, inside.y));
        }
        least = std::min(least, best);
    }
    return least;
}

TEST(MapFrustum, OneFittedFrustumServesAnAreaLightAboveASmallView) {
    const Fitted f = fit(scenes::rectangle_light({0, 0, 5}, 1, 1), 2.0);
    ASSERT_EQ(f.frustum.faces.size(), 1U);
    EXPECT_EQ(f.frustum.faces[0].name, "front");
    EXPECT_GE(least_margin_texels(f), 1.99);
    EXPECT_LT(least_margin_texels(f), 3.0) << "the frustum is not fitted";
}

TEST(MapFrustum, ALampCloseToAWideGroundGetsTheCubeFacesThatHoldReceivers) {
    const Fitted f = fit(scenes::point_light({0, 0, 1}, 0.1), 20.0);
    EXPECT_EQ(f.frustum.faces.size(), 5U);  // down and four sides
    ASSERT_EQ(f.frustum.faces_without_receivers.size(), 1U);
    EXPECT_GE(least_margin_texels(f), 1.99);
}

TEST(MapFrustum, KeepEverythingKeepsAllSixFaces) {
    const Fitted f = fit(scenes::point_light({0, 0, 1}, 0.1), 20.0, true);
    EXPECT_EQ(f.frustum.faces.size(), 6U);
    EXPECT_TRUE(f.frustum.faces_without_receivers.empty());
}

TEST(MapFrustum, ASunGetsOneOrthographicMap) {
    const Fitted f = fit(scenes::sun_light({0.3, -0.2, -1}, 0.01), 20.0);
    ASSERT_EQ(f.frustum.faces.size(), 1U);
    EXPECT_TRUE(f.frustum.faces[0].orthographic);
    EXPECT_GE(least_margin_texels(f), 1.99);
}

TEST(MapFrustum, HoldsEveryReceiverWhereverTheLightIs) {
    std::mt19937 random{3};
    std::uniform_real_distribution<double> place{-15.0, 15.0}, height{0.05, 10.0};
    for (int round = 0; round < 100; ++round) {
        const Fitted f = fit(scenes::point_light({place(random), place(random), height(random)}, 0.0), 10.0);
        EXPECT_GE(least_margin_texels(f), 1.99) << "round " << round;
    }
}

TEST(MapFrustum, NearPlaneLiesBeforeCastersAndReceivers) {
    const Fitted f = fit(scenes::rectangle_light({0, 0, 5}, 1, 1), 2.0, false, {0, 0, 3});
    ASSERT_EQ(f.frustum.faces.size(), 1U);
    EXPECT_LT(f.frustum.faces[0].near_m, 5.0 - 3.2);
    EXPECT_GT(f.frustum.faces[0].near_m, 0.8 * (5.0 - 3.2)) << "nearer than the casters need";
}

TEST(MapFrustum, ScalesWithTheScene) {
    const Fitted f = fit(scenes::point_light({1, 2, 5}, 0.0), 2.0);
    for (const double scale : {1e-4, 1e4}) {
        Fitted g;
        g.scene = scenes::transformed(f.scene, scale, glm::dmat3{1.0}, {});
        validate(g.scene);
        std::vector<Bounds> bounds;
        for (const Instance& instance : g.scene.instances) {
            bounds.push_back(bounds_of(instance));
        }
        g.summary = summarise_light(g.scene, view_of_ground(g.scene.camera), g.scene.lights[0], bounds, false);
        g.frustum = fit_map_frustum(g.summary, g.scene.lights[0].position_ws, {0, 0, -1}, {.size_px = 512});
        ASSERT_EQ(g.frustum.faces.size(), f.frustum.faces.size());
        EXPECT_NEAR(g.frustum.faces[0].near_m / scale, f.frustum.faces[0].near_m, 1e-4 * f.frustum.faces[0].near_m);
        EXPECT_NEAR(glm::length(g.frustum.faces[0].high - f.frustum.faces[0].high), 0.0, 1e-4);
    }
}

TEST(MapFrustum, AReceiverAtTheLightPointMakesNoNaN) {
    const Fitted f = fit(scenes::point_light({0.0, 0.0, 0.0}, 0.5), 2.0);
    for (const MapFace& face : f.frustum.faces) {
        EXPECT_TRUE(std::isfinite(face.low.x) && std::isfinite(face.high.y) && std::isfinite(face.near_m));
        EXPECT_GT(face.near_m, 0.0);
        EXPECT_GT(face.high.x, face.low.x);
        EXPECT_GT(face.high.y, face.low.y);
    }
}

}  // namespace
}  // namespace penumbra
