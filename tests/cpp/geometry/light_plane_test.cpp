#include "geometry/light_plane.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <random>

namespace penumbra {
namespace {

using Parts = std::array<PlaneTriangle, CentralProjection::kMostParts>;

Light square(double height) {
    Light light;
    light.kind = LightKind::Rectangle;
    light.position_ws = {0.0, 0.0, height};
    light.half_u_ws = {1.0, 0.0, 0.0};
    light.half_v_ws = {0.0, 1.0, 0.0};
    return light;
}

TEST(LightPlane, FrameOfAPolygonPutsItsCornersBack) {
    Light light;
    light.kind = LightKind::Polygon;
    light.corners_ws = {{1e3, 2, 3}, {1e3 + 4, 2, 3.5}, {1e3 + 5, 5, 3.5}, {1e3 + 3, 8, 3.1}, {1e3 - 2, 6, 2.5}};
    for (glm::dvec3& corner : light.corners_ws) {
        corner.z = 0.1 * (corner.x - 1e3) + 0.2 * corner.y;  // planar
    }
    const glm::dvec3 anchor{1e3, 0.0, 0.0};
    const auto plane = light_plane(light, anchor);
    ASSERT_TRUE(plane.has_value());
    for (std::size_t i = 0; i < light.corners_ws.size(); ++i) {
        const glm::dvec2 c = plane->corners[i];
        EXPECT_LE(std::max(std::abs(c.x), std::abs(c.y)), 1.0);
        const glm::dvec3 back = anchor + plane->origin_m + c.x * plane->u_m + c.y * plane->v_m;
        EXPECT_LT(glm::length(back - light.corners_ws[i]), 1e-12);
    }
}

TEST(LightPlane, LightsWithoutAreaOrPolygonHaveNone) {
    Light light = square(1.0);
    light.half_v_ws = {0.5, 0.0, 0.0};
    EXPECT_FALSE(light_plane(light, glm::dvec3{0.0}).has_value());
    light.kind = LightKind::Point;
    EXPECT_FALSE(light_plane(light, glm::dvec3{0.0}).has_value());
    light.kind = LightKind::Polygon;
    light.corners_ws = {{0, 0, 0}, {1, 1, 1}, {2, 2, 2}};
    EXPECT_FALSE(light_plane(light, glm::dvec3{0.0}).has_value());
    light.corners_ws.clear();
    EXPECT_FALSE(light_plane(light, glm::dvec3{0.0}).has_value());
}

TEST(CentralProjection, PointsOnTheWayToAFrameCoordinateProjectToIt) {
    const auto plane = light_plane(square(2.0), glm::dvec3{0.0});
    const glm::dvec3 x{0.3, -0.7, 0.25};
    const CentralProjection projection{*plane, x};
    ASSERT_TRUE(projection.valid());
    const auto on_way = [&](double u, double v, double share) {
        return share * (glm::dvec3{u, v, 2.0} - x);  // relative to the receiver
    };
    Parts out;
    ASSERT_EQ(projection.project(on_way(0.5, 0.25, 0.1), on_way(-0.75, 0.5, 0.9), on_way(0.0, -1.0, 0.5), out), 1U);
    EXPECT_LT(glm::length(out[0].corner[0] - glm::dvec2(0.5, 0.25)), 1e-15);
    EXPECT_LT(glm::length(out[0].corner[1] - glm::dvec2(-0.75, 0.5)), 1e-15);
    EXPECT_LT(glm::length(out[0].corner[2] - glm::dvec2(0.0, -1.0)), 1e-15);
}

TEST(CentralProjection, SharedVerticesProjectToTheSameBits) {
    const auto plane = light_plane(square(2.0), glm::dvec3{0.0});
    const CentralProjection projection{*plane, {0.3, -0.7, 0.25}};
    const glm::dvec3 a{0.1, 0.2, 0.7};
    const glm::dvec3 b{0.3, 0.1, 0.9};
    Parts first;
    Parts second;
    ASSERT_EQ(projection.project(a, b, {0.2, 0.8, 0.8}, first), 1U);
    ASSERT_EQ(projection.project(b, a, {0.1, -0.1, 1.2}, second), 1U);
    EXPECT_EQ(first[0].corner[0], second[0].corner[1]);
    EXPECT_EQ(first[0].corner[1], second[0].corner[0]);
}

TEST(CentralProjection, AllThatComesOutLiesInTheFrame) {
    const auto plane = light_plane(square(1.0), glm::dvec3{0.0});
    const CentralProjection projection{*plane, glm::dvec3{0.0}};
    std::mt19937 random{5};
    std::uniform_real_distribution<double> in{-1.0, 1.0};
    std::uniform_real_distribution<double> decade{-9.0, 3.0};
    int some = 0;
    for (int i = 0; i < 50000; ++i) {
        const auto p = [&] { return std::pow(10.0, decade(random)) * glm::dvec3{in(random), in(random), in(random)}; };
        Parts out;
        const std::size_t count = projection.project(p(), p(), p(), out);
        ASSERT_LE(count, out.size());
        for (std::size_t k = 0; k < count; ++k) {
            for (const glm::dvec2& corner : out[k].corner) {
                ASSERT_TRUE(std::abs(corner.x) <= 2.0 && std::abs(corner.y) <= 2.0);
            }
        }
        some += count > 0 ? 1 : 0;
    }
    EXPECT_GT(some, 1000);
}

TEST(CentralProjection, IsInvalidInTheLightPlaneOnly) {
    const auto plane = light_plane(square(1.0), glm::dvec3{0.0});
    EXPECT_FALSE(CentralProjection(*plane, {3.0, 0.0, 1.0}).valid());
    EXPECT_FALSE(CentralProjection(*plane, {0.0, 0.0, 1.0}).valid());
    EXPECT_TRUE(CentralProjection(*plane, {3.0, 0.0, 1.0 + 1e-9}).valid());
    EXPECT_GT(CentralProjection(*plane, {0.0, 0.0, 0.0}).orientation(), 0.0);
    EXPECT_LT(CentralProjection(*plane, {0.0, 0.0, 2.0}).orientation(), 0.0);
}

}  // namespace
}  // namespace penumbra
