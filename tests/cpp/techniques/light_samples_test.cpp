#include <gtest/gtest.h>

#include <set>

#include "support/scenes.h"
#include "techniques/light_samples/sample_points.h"

namespace penumbra {
namespace {

glm::dvec3 mean_of(const std::vector<LightSamplePoint>& points) {
    glm::dvec3 sum{0.0};
    for (const LightSamplePoint& point : points) {
        sum += point.position_ws;
    }
    return sum / static_cast<double>(points.size());
}

TEST(SamplePoints, OnePointForALightWithoutExtent) {
    EXPECT_EQ(sample_points(scenes::point_light({1, 2, 3}, 0.0), 64, "jittered", 1).size(), 1U);
}

TEST(SamplePoints, ASingleSampleIsTheCentre) {
    const auto points = sample_points(scenes::rectangle_light({1, 2, 3}, 2, 1), 1, "jittered", 1);
    ASSERT_EQ(points.size(), 1U);
    EXPECT_EQ(points[0].position_ws, (glm::dvec3{1, 2, 3}));
}

TEST(SamplePoints, AGridHasOnlyRootNValuesPerAxis) {
    const auto points = sample_points(scenes::rectangle_light({0, 0, 4}, 1, 1), 64, "grid", 1);
    std::set<long> columns;
    for (const LightSamplePoint& point : points) {
        columns.insert(std::lround(point.position_ws.x * 1e6));
    }
    EXPECT_EQ(columns.size(), 8U);
}

TEST(SamplePoints, JitterPutsOnePointIntoEachStratum) {
    const auto points = sample_points(scenes::rectangle_light({0, 0, 4}, 1, 1), 64, "jittered", 5);
    std::set<int> cells;
    for (const LightSamplePoint& point : points) {
        cells.insert(static_cast<int>((point.position_ws.x + 0.5) * 8) * 8 +
                     static_cast<int>((point.position_ws.y + 0.5) * 8));
    }
    EXPECT_EQ(cells.size(), 64U);
}

TEST(SamplePoints, MeanIsTheCentreOfEveryShape) {
    Light ellipse = scenes::rectangle_light({1, 2, 3}, 2, 1);
    ellipse.kind = LightKind::Ellipse;
    Light line = scenes::rectangle_light({1, 2, 3}, 2, 0);
    line.kind = LightKind::Line;
    Light triangle = scenes::rectangle_light({0, 0, 0}, 0, 0);
    triangle.kind = LightKind::Polygon;
    triangle.corners_ws = {{0, 0, 3}, {3, 0, 3}, {0, 6, 3}};
    for (const char* pattern : {"jittered", "grid", "r2"}) {
        for (const Light& light : {scenes::rectangle_light({1, 2, 3}, 2, 1), ellipse, line, triangle}) {
            EXPECT_LT(glm::length(mean_of(sample_points(light, 1024, pattern, 3)) - glm::dvec3{1, 2, 3}), 0.02)
                << pattern << " " << to_string(light.kind);
        }
    }
}

TEST(SamplePoints, EllipseSamplesFillItsAreaEvenly) {
    Light ellipse = scenes::rectangle_light({0, 0, 0}, 2, 2);
    ellipse.kind = LightKind::Ellipse;
    int inner = 0;
    for (const LightSamplePoint& point : sample_points(ellipse, 4096, "jittered", 3)) {
        const double r = glm::length(point.position_ws);
        EXPECT_LE(r, 1.0 + 1e-12);
        inner += r < std::sqrt(0.5) ? 1 : 0;
    }
    EXPECT_NEAR(inner / 4096.0, 0.5, 0.01);
}

TEST(SamplePoints, SphereSamplesLieOnTheCapAndFillItEvenly) {
    const SphereCap cap{glm::normalize(glm::dvec3{1, 1, 1}), -0.2};
    int upper = 0;
    for (const LightSamplePoint& point : sample_points(scenes::point_light({0, 0, 0}, 2.0), 4096, "jittered", 3, cap)) {
        EXPECT_NEAR(glm::length(point.position_ws), 2.0, 1e-12);
        const double cosine = glm::dot(point.normal_ws, cap.axis_ws);
        EXPECT_GE(cosine, -0.2 - 1e-12);
        upper += cosine > 0.4 ? 1 : 0;  // heights are uniform on a sphere: half of 1.2
    }
    EXPECT_NEAR(upper / 4096.0, 0.5, 0.01);
}

TEST(SamplePoints, SunSamplesStayWithinItsDisc) {
    const Light sun = scenes::sun_light({0.3, 0.2, -1}, 0.2);
    glm::dvec3 mean{0.0};
    for (const LightSamplePoint& point : sample_points(sun, 1024, "r2", 3)) {
        EXPECT_GE(glm::dot(point.direction_ws, sun.direction_ws), std::cos(0.1) - 1e-12);
        mean += point.direction_ws / 1024.0;
    }
    EXPECT_GT(glm::dot(glm::normalize(mean), sun.direction_ws), 1.0 - 1e-6);
}

}  // namespace
}  // namespace penumbra
