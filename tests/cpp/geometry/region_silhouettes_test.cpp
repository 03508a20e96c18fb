#include "geometry/region_silhouettes.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>

#include "geometry/silhouettes.h"
#include "support/scenes.h"

namespace penumbra {
namespace {

using scenes::kPi;

Light lamp(LightKind kind) {
    Light light = scenes::rectangle_light({0.4, -0.3, 3.0}, 1.2, 0.5);
    light.kind = kind;
    if (kind == LightKind::Point) {
        light.radius_m = 0.4;
    } else if (kind == LightKind::Sun) {
        light = scenes::sun_light({0.3, 0.2, -1.0}, 0.3);
    } else if (kind == LightKind::Line) {
        light.half_v_ws = glm::dvec3{0.0};
    } else if (kind == LightKind::Polygon) {
        light.corners_ws = {{-0.2, -0.5, 3.0}, {0.3, 0.6, 3.0}, {1.1, -0.2, 3.0}};
        light.position_ws = (light.corners_ws[0] + light.corners_ws[1] + light.corners_ws[2]) / 3.0;
    }
    return light;
}

/// A point of the light, w = 1, or a direction towards it.
glm::dvec4 point_of(const Light& light, double u, double v) {
    const double a = 2.0 * u - 1.0;
    const double b = 2.0 * v - 1.0;
    const double ring = std::sqrt(u);
    const double c = ring * std::cos(2.0 * kPi * v);
    const double s = ring * std::sin(2.0 * kPi * v);
    switch (light.kind) {
        case LightKind::Point: {
            const double z = 1.0 - 2.0 * u;
            const double r = std::sqrt(1.0 - z * z);
            return {light.position_ws +
                        light.radius_m * glm::dvec3{r * std::cos(2.0 * kPi * v), r * std::sin(2.0 * kPi * v), z},
                    1.0};
        }
        case LightKind::Sun: {
            const LightRegion region = light_region(light);
            return {glm::dvec3{region.centre} + c * region.half[0] + s * region.half[1], 0.0};
        }
        case LightKind::Ellipse:
            return {light.position_ws + c * light.half_u_ws + s * light.half_v_ws, 1.0};
        case LightKind::Polygon: {
            const double w = 1.0 - ring;
            return {w * light.corners_ws[0] + ring * (1.0 - v) * light.corners_ws[1] + ring * v * light.corners_ws[2],
                    1.0};
        }
        default:
            return {light.position_ws + a * light.half_u_ws + b * light.half_v_ws, 1.0};
    }
}

std::shared_ptr<Mesh> soup() {
    std::mt19937 random{7};
    std::uniform_real_distribution<float> uniform{-1.0F, 1.0F};
    auto made = std::make_shared<Mesh>();
    for (int i = 0; i < 24; ++i) {
        made->positions_local.emplace_back(uniform(random), uniform(random), 0.5F * uniform(random));
    }
    std::uniform_int_distribution<unsigned> pick{0, 23};
    for (int i = 0; i < 60; ++i) {
        made->triangles.emplace_back(pick(random), pick(random), pick(random));
    }
    return made;
}

class RegionSilhouettes : public testing::TestWithParam<LightKind> {};
INSTANTIATE_TEST_SUITE_P(Kinds, RegionSilhouettes,
                         testing::Values(LightKind::Point, LightKind::Sun, LightKind::Rectangle, LightKind::Ellipse,
                                         LightKind::Line, LightKind::Polygon),
                         [](const testing::TestParamInfo<LightKind>& kind) {
                             return std::string{to_string(kind.param)};
                         });

TEST_P(RegionSilhouettes, HoldTheSilhouettesOfEveryPointOfTheLight) {
    const Light light = lamp(GetParam());
    std::mt19937 random{3};
    std::uniform_real_distribution<double> uniform{0.0, 1.0};
    for (const auto& mesh : {scenes::sphere(12, false), scenes::box({-0.5F, -0.5F, 0.0F}, {0.5F, 0.5F, 1.0F}), soup(),
                             scenes::sheet(-1, 1, -1, 1)}) {
        const Adjacency adjacency = make_adjacency(*mesh);
        std::vector<std::uint32_t> region;
        find_region_silhouettes(*mesh, adjacency, light_region(light), region);
        std::vector<std::uint8_t> in(adjacency.edges.size(), 0);
        for (const std::uint32_t e : region) {
            in[e] = 1;
        }
        for (int i = 0; i < 200; ++i) {
            const glm::dvec4 point = point_of(light, uniform(random), uniform(random));
            for (const SilhouetteEdge& edge : find_silhouettes(*mesh, adjacency, point, false)) {
                const auto found = std::ranges::find_if(adjacency.edges, [&](const Adjacency::Edge& e) {
                    return e.v0 == std::min(edge.a, edge.b) && e.v1 == std::max(edge.a, edge.b);
                });
                ASSERT_NE(found, adjacency.edges.end());
                EXPECT_TRUE(in[static_cast<std::size_t>(found - adjacency.edges.begin())]) << edge.a << " " << edge.b;
            }
        }
    }
}

TEST_P(RegionSilhouettes, OfAPointAreThoseOfThePoint) {
    Light light = lamp(GetParam());
    light.half_u_ws = light.half_v_ws = glm::dvec3{0.0};
    light.radius_m = light.sun_angle_rad = 0.0;
    for (glm::dvec3& corner : light.corners_ws) {
        corner = light.position_ws;
    }
    const auto mesh = scenes::sphere(12, false);
    const Adjacency adjacency = make_adjacency(*mesh);
    std::vector<std::uint32_t> region;
    find_region_silhouettes(*mesh, adjacency, light_region(light), region);
    EXPECT_EQ(region.size(), find_silhouettes(*mesh, adjacency, light_region(light).centre, false).size());
}

TEST(RegionSilhouettes, OfABallAreABandAsWideAsTheLight) {
    const auto mesh = scenes::sphere(64, false);
    const Adjacency adjacency = make_adjacency(*mesh);
    std::size_t before = 0;
    for (const double angle : {0.0, 0.1, 0.2, 0.4}) {
        std::vector<std::uint32_t> region;
        find_region_silhouettes(*mesh, adjacency, light_region(scenes::sun_light({0.1, 0.2, -1}, angle)), region);
        EXPECT_GT(region.size(), before);
        // Triangles whose normals lie within half the angle of the terminator: a band of that share of the area, and an
        // edge in either of its triangles counts.
        const double share = static_cast<double>(region.size()) / static_cast<double>(adjacency.edges.size());
        EXPECT_LT(share, std::sin(0.5 * angle) + 0.08) << angle;
        before = region.size();
    }
}

TEST(LightRegion, ReachesAsFarAsTheLightDoes) {
    const glm::dvec3 axis{0.3, -0.5, 0.9};
    for (const LightKind kind : {LightKind::Point, LightKind::Rectangle, LightKind::Ellipse, LightKind::Line}) {
        const Light light = lamp(kind);
        const LightRegion region = light_region(light);
        double most = 0.0;
        for (int i = 0; i <= 200; ++i) {
            for (int j = 0; j <= 200; ++j) {
                const glm::dvec4 p = point_of(light, i / 200.0, j / 200.0);
                most = std::max(most, glm::dot(axis, glm::dvec3{p - region.centre}));
                EXPECT_LE(glm::length(glm::dvec3{p - region.centre}), region.radius() * (1.0 + 1e-12));
            }
        }
        EXPECT_LE(most, region.reach(axis) * (1.0 + 1e-12));
        EXPECT_GT(most, 0.999 * region.reach(axis)) << to_string(kind);
    }
}

TEST(LightRegion, OfAPolygonHoldsItsCorners) {
    const Light light = lamp(LightKind::Polygon);
    const LightRegion region = light_region(light);
    for (const glm::dvec3& corner : light.corners_ws) {
        for (const glm::dvec3& half : region.half) {
            const double length = glm::length(half);
            if (length > 0.0) {
                EXPECT_LE(std::abs(glm::dot(corner - glm::dvec3{region.centre}, half / length)),
                          length * (1.0 + 1e-12));
            }
        }
    }
}

}  // namespace
}  // namespace penumbra
