// How lights with an area become linear lights.
#include "geometry/linear_rods.h"

#include <gtest/gtest.h>

#include <cmath>

#include "support/scenes.h"

namespace penumbra {
namespace {

const RodSurroundings kBelow{.towards_ws = {0.0, 0.0, -4.0}, .upright_ws = {0.0, 1.0, 0.0}};

double total_weight(const std::vector<LinearRod>& rods) {
    double sum = 0.0;
    for (const LinearRod& rod : rods) {
        sum += rod.weight;
    }
    return sum;
}

/// Mean and covariance along `axis` of the rods together, each a uniform segment.
double variance_of(const std::vector<LinearRod>& rods, const glm::dvec3& axis) {
    double mean = 0.0;
    double square = 0.0;
    for (const LinearRod& rod : rods) {
        const double c = glm::dot(rod.centre_ws, axis);
        const double h = glm::dot(rod.half_ws, axis);
        mean += rod.weight * c;
        square += rod.weight * (c * c + h * h / 3.0);
    }
    return square - mean * mean;
}

TEST(LinearRods, ALineIsItselfAndAPointHasNoLength) {
    Light line = scenes::rectangle_light({1, 2, 3}, 2.0, 1.0);
    line.kind = LightKind::Line;
    line.half_v_ws = glm::dvec3{0.0};
    const auto rods = linear_rods(line, RodLayout::Auto, 0, {});
    ASSERT_EQ(rods.size(), 1U);
    EXPECT_EQ(rods[0].half_ws, line.half_u_ws);
    EXPECT_EQ(rods[0].weight, 1.0);
    const auto point = linear_rods(scenes::point_light({1, 2, 3}, 0.0), RodLayout::Auto, 7, {});
    ASSERT_EQ(point.size(), 1U);
    EXPECT_EQ(point[0].half_ws, glm::dvec3{0.0});
}

TEST(LinearRods, OneStripHasTheLightsOwnVarianceAlongItsLongestAxis) {
    Light light = scenes::rectangle_light({0, 0, 4}, 1.0, 3.0);
    auto rods = linear_rods(light, RodLayout::Strips, 1, {});
    ASSERT_EQ(rods.size(), 1U);
    EXPECT_NEAR(glm::length(rods[0].half_ws), 1.5, 1e-12);  // a rectangle is a stack of its own longer side
    EXPECT_NEAR(std::abs(rods[0].half_ws.y), 1.5, 1e-12);
    light.kind = LightKind::Ellipse;
    rods = linear_rods(light, RodLayout::Auto, 0, {});
    ASSERT_EQ(rods.size(), 1U);
    EXPECT_NEAR(glm::length(rods[0].half_ws), 1.5 * std::sqrt(3.0) / 2.0, 2e-4);
    EXPECT_NEAR(variance_of(rods, {0, 1, 0}), 1.5 * 1.5 / 4.0, 2e-4);
}

TEST(LinearRods, ASphereIsTheSegmentOfItsOutlineAcrossWhatStandsUpright) {
    const auto rods = linear_rods(scenes::point_light({0, 0, 4}, 0.5), RodLayout::Auto, 0, kBelow);
    ASSERT_EQ(rods.size(), 1U);
    const double outline = 0.5 * std::sqrt(1.0 - 0.125 * 0.125);
    EXPECT_NEAR(glm::length(rods[0].half_ws), outline * std::sqrt(3.0) / 2.0, 1e-4);
    EXPECT_NEAR(std::abs(rods[0].half_ws.x), glm::length(rods[0].half_ws), 1e-12);
    EXPECT_NEAR(rods[0].centre_ws.z, 4.0 - 0.5 * 0.125, 1e-12);  // where the tangents touch
}

TEST(LinearRods, ASunIsASegmentOfDirections) {
    const Light sun = scenes::sun_light({0, 0, -1}, 0.2);
    const auto rods = linear_rods(sun, RodLayout::Auto, 0, kBelow);
    ASSERT_EQ(rods.size(), 1U);
    EXPECT_NEAR(glm::dot(rods[0].half_ws, sun.direction_ws), 0.0, 1e-12);
    EXPECT_NEAR(glm::length(rods[0].half_ws), std::tan(0.1) * std::sqrt(3.0) / 2.0, 1e-4);
}

TEST(LinearRods, StripsAddUpToTheLight) {
    Light triangle = scenes::rectangle_light({0, 0, 4}, 1.0, 1.0);
    triangle.kind = LightKind::Polygon;
    triangle.corners_ws = {{-1, -0.5, 4}, {2, -0.5, 4}, {-1, 1.0, 4}};
    triangle.position_ws = {0, 0, 4};
    Light disc = scenes::rectangle_light({0, 0, 4}, 2.0, 2.0);
    disc.kind = LightKind::Ellipse;
    const Light square = scenes::rectangle_light({0, 0, 4}, 2.0, 2.0);
    struct Row {
        Light light;
        double xx, yy;  // variances
    };
    for (const auto& [light, xx, yy] :
         {Row{triangle, 0.5, 0.125}, Row{disc, 0.25, 0.25}, Row{square, 1.0 / 3.0, 1.0 / 3.0}}) {
        for (const int strips : {1, 4, 16}) {
            const auto rods = linear_rods(light, RodLayout::Strips, strips, {});
            ASSERT_EQ(rods.size(), static_cast<std::size_t>(strips));
            EXPECT_NEAR(total_weight(rods), 1.0, 1e-12);
            const double both = variance_of(rods, {1, 0, 0}) + variance_of(rods, {0, 1, 0});
            // What lies across a strip is lost: its share of the variance falls with the square of their number.
            EXPECT_LE(both, xx + yy + 1e-4);
            EXPECT_GE(both, (xx + yy) * (1.0 - 0.55 / strips));
            for (const LinearRod& rod : rods) {
                EXPECT_NEAR(rod.centre_ws.z, 4.0, 1e-12);
                EXPECT_NEAR(rod.half_ws.z, 0.0, 1e-12);
            }
        }
    }
}

TEST(LinearRods, ATriangleIsItsThreeSidesOfAThirdEach) {
    Light triangle = scenes::rectangle_light({0, 0, 4}, 1.0, 1.0);
    triangle.kind = LightKind::Polygon;
    triangle.corners_ws = {{-1, -0.5, 4}, {2, -0.5, 4}, {-1, 1.0, 4}};
    const auto rods = linear_rods(triangle, RodLayout::Auto, 0, {});
    ASSERT_EQ(rods.size(), 3U);
    for (std::size_t i = 0; i < 3; ++i) {
        EXPECT_DOUBLE_EQ(rods[i].weight, 1.0 / 3.0);
        EXPECT_NEAR(glm::length(rods[i].centre_ws - rods[i].half_ws - triangle.corners_ws[i]), 0.0, 1e-12);
        EXPECT_NEAR(glm::length(rods[i].centre_ws + rods[i].half_ws - triangle.corners_ws[(i + 1) % 3]), 0.0, 1e-12);
    }
}

TEST(LinearRods, SquaresGetFourStripsAndLongLightsFewer) {
    for (const auto& [length, strips] : {std::pair{1.0, 4U}, {2.0, 2U}, {4.0, 1U}, {9.0, 1U}}) {
        EXPECT_EQ(linear_rods(scenes::rectangle_light({0, 0, 4}, length, 1.0), RodLayout::Auto, 0, {}).size(), strips);
        EXPECT_EQ(linear_rods(scenes::rectangle_light({0, 0, 4}, 1.0, length), RodLayout::Auto, 0, {}).size(), strips);
    }
}

TEST(LinearRods, AnAreaLightWithoutWidthIsALine) {
    Light flat = scenes::rectangle_light({0, 0, 4}, 2.0, 0.0);
    const auto rods = linear_rods(flat, RodLayout::Auto, 5, {});
    ASSERT_EQ(rods.size(), 1U);
    EXPECT_NEAR(glm::length(rods[0].half_ws), 1.0, 1e-12);
}

}  // namespace
}  // namespace penumbra
