#include "geometry/cone_base.h"

#include <gtest/gtest.h>

#include <cmath>

#include "support/scenes.h"

namespace penumbra {
namespace {

const glm::dmat3 kDown{{1, 0, 0}, {0, -1, 0}, {0, 0, -1}};  // a map that looks down, x to the right

TEST(ConeBase, DiscsHaveTheLightsArea) {
    const Light rectangle = scenes::rectangle_light({0, 0, 4}, 0.6, 0.2);
    const ConeBase base = cone_base(rectangle, ConeShape::Disc, kDown);
    EXPECT_EQ(base.kind, ConeBase::Kind::Ellipse);
    EXPECT_NEAR(scenes::kPi * base.reach * base.reach, 0.12, 1e-12);
    EXPECT_NEAR(disc_radius(scenes::sun_light({0, 0, -1}, 0.3)), std::tan(0.15), 1e-12);
    EXPECT_LT(disc_radius(scenes::sun_light({0, 0, -1}, scenes::kPi)), 12.0);
}

TEST(ConeBase, OwnShapesReachAsFarAsTheLightInEveryDirection) {
    const Light rectangle = scenes::rectangle_light({0, 0, 4}, 0.6, 0.2);
    const ConeBase square = cone_base(rectangle, ConeShape::Light, kDown);
    ASSERT_EQ(square.corners.size(), 4U);
    EXPECT_NEAR(square.support({1, 0}), 0.3, 1e-12);
    EXPECT_NEAR(square.support({0, 1}), 0.1, 1e-12);
    Light ellipse = rectangle;
    ellipse.kind = LightKind::Ellipse;
    const ConeBase round = cone_base(ellipse, ConeShape::Light, kDown);
    EXPECT_GT(glm::determinant(round.ip_from_unit), 0.0);
    for (const double angle : {0.0, 0.3, 1.2, 2.0}) {
        const glm::dvec2 n{std::cos(angle), std::sin(angle)};
        EXPECT_NEAR(round.support(n), std::hypot(0.3 * n.x, 0.1 * n.y), 1e-12);
    }
    EXPECT_NEAR(round.reach, 0.3, 1e-12);
}

TEST(ConeBase, APolygonRunsCounterClockwiseHoweverItWasGiven) {
    Light light = scenes::rectangle_light({0, 0, 4}, 1, 1);
    light.kind = LightKind::Polygon;
    for (const bool reversed : {false, true}) {
        light.corners_ws = {{-1, -1, 4}, {1, -1, 4}, {0, 2, 4}};
        if (reversed) {
            std::swap(light.corners_ws[0], light.corners_ws[1]);
        }
        const ConeBase base = cone_base(light, ConeShape::Light, kDown);
        double area = 0.0;
        for (std::size_t i = 0; i < 3; ++i) {
            const glm::dvec2 a = base.corners[i];
            const glm::dvec2 b = base.corners[(i + 1) % 3];
            area += 0.5 * (a.x * b.y - a.y * b.x);
        }
        EXPECT_NEAR(area, 3.0, 1e-12);
    }
}

TEST(ConeBase, ALightSeenEdgeOnBecomesADisc) {
    const glm::dmat3 sideways{{0, 0, 1}, {1, 0, 0}, {0, 1, 0}};  // columns: images of the world's axes
    const ConeBase base = cone_base(scenes::rectangle_light({0, 0, 4}, 0.6, 0.2), ConeShape::Light, sideways);
    EXPECT_EQ(base.kind, ConeBase::Kind::Ellipse);
    EXPECT_GT(base.reach, 0.0);
}

// Table 3.2 of the specification.
TEST(PenumbraRamps, FollowThePublishedTable) {
    EXPECT_NEAR(published_intensity(0.25, 1.25), 0.2105, 1e-4);
    EXPECT_NEAR(published_intensity(0.5, 4.0), 0.2, 1e-12);
    EXPECT_NEAR(smoothstep_falloff(published_intensity(0.75, 2.0)), 0.6480, 1e-4);
    EXPECT_NEAR(disc_fraction(-0.75), 0.0721, 1e-4);
    EXPECT_NEAR(disc_fraction(0.25), 0.6575, 1e-4);
    EXPECT_EQ(disc_fraction(-1.0), 0.0);
    EXPECT_EQ(disc_fraction(1.0), 1.0);
}

}  // namespace
}  // namespace penumbra
