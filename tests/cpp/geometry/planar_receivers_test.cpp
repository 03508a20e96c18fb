#include "geometry/planar_receivers.h"

#include <gtest/gtest.h>

#include "support/scenes.h"

namespace penumbra {
namespace {

/// A view made by hand: what() names instance and triangle of each pixel and where on it the pixel lies.
struct Made {
    Scene scene;
    View view;
    std::vector<std::uint8_t> mask;
};

/// Sees each triangle of each instance in `per_triangle` pixels, from `eye`.
Made see_all(std::vector<Instance> instances, int per_triangle, const glm::dvec3& eye) {
    Made made;
    made.scene.instances = std::move(instances);
    made.view.eye_ws = eye;
    for (std::size_t i = 0; i < made.scene.instances.size(); ++i) {
        const Instance& instance = made.scene.instances[i];
        for (std::size_t t = 0; t < instance.mesh->triangles.size(); ++t) {
            glm::dvec3 p[3];
            for (int k = 0; k < 3; ++k) {
                p[k] = glm::dvec3{instance.world_from_local *
                                  glm::dvec4{instance.mesh->positions_local[instance.mesh->triangles[t][k]], 1.0}};
            }
            const glm::dvec3 n = glm::normalize(glm::cross(p[1] - p[0], p[2] - p[0]));
            for (int j = 0; j < per_triangle; ++j) {
                const double u = j == 0 ? 0.0 : (j == 1 ? 1.0 : 0.3), v = j == 2 ? 0.6 : 0.0;
                const glm::dvec3 at = p[0] + u * (p[1] - p[0]) + v * (p[2] - p[0]);
                made.view.position_cr.emplace_back(at - eye);
                made.view.normal_ws.emplace_back(glm::dot(n, eye - at) > 0.0 ? n : -n);
                made.view.instance.push_back(static_cast<std::int32_t>(i));
                made.view.triangle.push_back(static_cast<std::int32_t>(t));
            }
        }
    }
    made.view.width = 1;  // points in no order: along a real row they run along a line
    made.view.height = static_cast<int>(made.view.instance.size());
    made.mask.assign(made.view.size(), 1);
    return made;
}

PlanarReceivers find(const Made& made, PlanarReceiverOptions options = {}) {
    options.tolerance_m = options.tolerance_m > 0.0 ? options.tolerance_m : 1e-4;
    return find_planar_receivers(made.scene, made.view, made.mask, options);
}

Instance turned(Instance instance, const glm::dmat3& turn, const glm::dvec3& move) {
    glm::dmat4 m{turn};
    m[3] = glm::dvec4{move, 1.0};
    instance.world_from_local = m * instance.world_from_local;
    return instance;
}

TEST(PlanarReceivers, ABoxSeenFromInsideHasSixPlanes) {
    for (const glm::dmat3& turn : {glm::dmat3{1.0}, scenes::odd_turn()}) {
        const glm::dvec3 move{1e5, -2e5, 3e5};
        const Made made = see_all({turned(scenes::place(scenes::box({-2, -2, 0}, {2, 2, 3}), "room"), turn, move)}, 8,
                                  move + turn * glm::dvec3{0, 0, 1});
        const PlanarReceivers found = find(made);
        EXPECT_EQ(found.planes.size(), 6U);
        EXPECT_EQ(found.pixels_on_none, 0U);
        for (const PlanarReceiver& plane : found.planes) {
            EXPECT_GT(plane.height(made.view.eye_ws), 0.0);  // the side that is seen
            EXPECT_NEAR(glm::dot(glm::cross(plane.axis_x, plane.axis_y), plane.normal), 1.0, 1e-12);
            EXPECT_EQ(plane.pixels, 16U);
        }
    }
}

TEST(PlanarReceivers, CoplanarInstancesAreOnePlaneNamedAfterTheLarger) {
    const Made made = see_all({scenes::place(scenes::sheet(0, 1, 0, 1), "small"),
                               scenes::place(scenes::sheet(2, 3, 0, 1), "tile", {0, 0, 5e-5}),
                               scenes::place(scenes::sheet(4, 5, 0, 1), "step", {0, 0, 0.01})},
                              6, {0, 0, 5});
    const PlanarReceivers found = find(made);
    ASSERT_EQ(found.planes.size(), 2U);
    EXPECT_EQ(found.planes[0].pixels, 24U);
    EXPECT_EQ(found.planes[1].name, "step");
}

TEST(PlanarReceivers, APixelLiesWithinItsPlanesRectangleAndTolerance) {
    const Made made = see_all({scenes::place(scenes::box({-1, -2, 0}, {1, 2, 3}), "room")}, 8, {0.1, 0.2, 1});
    const PlanarReceivers found = find(made);
    for (std::size_t i = 0; i < made.view.size(); ++i) {
        ASSERT_LT(found.plane_of_pixel[i], found.planes.size());
        const PlanarReceiver& plane = found.planes[found.plane_of_pixel[i]];
        const glm::dvec3 p = made.view.eye_ws + glm::dvec3{made.view.position_cr[i]} - plane.origin_ws;
        EXPECT_NEAR(glm::dot(p, plane.normal), 0.0, 1e-4);
        EXPECT_GE(glm::dot(p, plane.axis_x), plane.low_m.x - 1e-5);
        EXPECT_LE(glm::dot(p, plane.axis_y), plane.high_m.y + 1e-5);
    }
}

TEST(PlanarReceivers, CurvedAndSmallOnesAreLeftOut) {
    const Made made = see_all({scenes::place(scenes::sphere(24, false), "ball"),
                               scenes::place(scenes::sheet(-9, 9, -9, 9), "floor", {0, 0, -1})},
                              4, {0, 0, 20});
    EXPECT_EQ(find(made, {.most = 15, .least_share = 0.1, .only = {}}).planes.size(), 0U);
    const PlanarReceivers chosen = find(made, {.least_share = 0.0, .only = "floor"});
    ASSERT_EQ(chosen.planes.size(), 1U);
    EXPECT_EQ(chosen.planes[0].name, "floor");
    EXPECT_EQ(find(made, {.most = 3, .least_share = 0.0, .only = {}}).planes.size(), 3U);
}

TEST(PlanarReceivers, TheTwoSidesOfASheetAreTwoPlanes) {
    const Made above = see_all({scenes::place(scenes::sheet(-1, 1, -1, 1), "sheet")}, 4, {0, 0, 3});
    const Made below = see_all({scenes::place(scenes::sheet(-1, 1, -1, 1), "sheet")}, 4, {0, 0, -3});
    EXPECT_GT(find(above).planes.at(0).normal.z, 0.99);
    EXPECT_LT(find(below).planes.at(0).normal.z, -0.99);
}

TEST(PlanarReceivers, TheWholeOfAPlaneReachesBeyondWhatIsSeen) {
    Made made = see_all({scenes::place(scenes::sheet(-10, 10, -4, 4), "floor")}, 3, {0, 0, 3});
    for (glm::vec3& p : made.view.position_cr) {
        p = 0.01F * p + glm::vec3{0, 0, -2.97F};
    }
    const PlanarReceiver seen = find(made).planes.at(0);
    EXPECT_LT(seen.high_m.x - seen.low_m.x, 1.0);
    const PlanarReceiver whole = find(made, {.whole = true, .only = {}}).planes.at(0);
    EXPECT_NEAR((whole.high_m.x - whole.low_m.x) * (whole.high_m.y - whole.low_m.y), 160.0, 1e-3);
}

}  // namespace
}  // namespace penumbra
