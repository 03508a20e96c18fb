#include "reference/light_mask.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "test_scenes.h"

namespace penumbra {
namespace {

const glm::dvec3 kOrigin{0.0};
const glm::dvec3 kUp{0, 0, 1};

TEST(FacesLight, ASphereCountsAsSoonAsItsTopIsAboveTheTangentPlane) {
    EXPECT_TRUE(faces_light(test::point_light({3, 0, -0.99}, 1.0), kOrigin, kUp));
    EXPECT_FALSE(faces_light(test::point_light({3, 0, -1.01}, 1.0), kOrigin, kUp));
    EXPECT_FALSE(faces_light(test::point_light({3, 0, 0}, 0.0), kOrigin, kUp));
    EXPECT_TRUE(faces_light(test::point_light({0, 0, -0.5}, 1.0), kOrigin, kUp)) << "inside the sphere";
}

TEST(FacesLight, ASunCountsAsSoonAsPartOfItsDiscIsAboveTheHorizon) {
    const double half = 0.1;
    const auto at_altitude = [&](double altitude) {
        return test::sun({-std::cos(altitude), 0, -std::sin(altitude)}, 2.0 * half);
    };
    EXPECT_TRUE(faces_light(at_altitude(-half + 1e-6), kOrigin, kUp));
    EXPECT_FALSE(faces_light(at_altitude(-half - 1e-6), kOrigin, kUp));
}

TEST(FacesLight, AFlatLightCountsOnItsLitSideOnly) {
    for (const Light& light : {test::rectangle({0, 0, 2}, 1, 1), test::ellipse({0, 0, 2}, 1, 1),
                               test::polygon({{0, 0, 2}, {0, 1, 2}, {1, 0, 2}})}) {
        EXPECT_TRUE(faces_light(light, kOrigin, kUp)) << light.name;
        EXPECT_FALSE(faces_light(light, kOrigin, -kUp)) << light.name;
        EXPECT_FALSE(faces_light(light, {0, 0, 3}, kUp)) << light.name;
        EXPECT_FALSE(faces_light(light, {0, 0, 3}, -kUp)) << light.name << " from behind";
        EXPECT_FALSE(faces_light(light, {5, 0, 2}, glm::dvec3(-1, 0, 0))) << light.name << " edge on";
    }
}

TEST(FacesLight, AFlatLightCountsWhileItsHighestPointIsAboveTheTangentPlane) {
    // A receiver at the origin with its tangent plane turned about y: the light's far end sinks below it.
    const Light box = test::rectangle({0, 0, 1}, 2, 1);
    const auto normal = [](double angle) { return glm::dvec3(std::sin(angle), 0, std::cos(angle)); };
    const double limit = test::kPi - std::atan2(1.0, 2.0);  // the corner (2, y, 1) is then in the plane
    EXPECT_TRUE(faces_light(box, kOrigin, normal(limit - 1e-6)));
    EXPECT_FALSE(faces_light(box, kOrigin, normal(limit + 1e-6)));
    // The ellipse's extreme point along the tilt axis is its half axis: the same limit; turned by 45 degrees it is
    // sqrt((4 + 1) / 2) where the rectangle's corner would still be up.
    EXPECT_TRUE(faces_light(test::ellipse({0, 0, 1}, 2, 1), kOrigin, normal(limit - 1e-6)));
    EXPECT_FALSE(faces_light(test::ellipse({0, 0, 1}, 2, 1), kOrigin, normal(limit + 1e-6)));
    const glm::dvec3 tilt = glm::normalize(glm::dvec3(1, 1, -1.6));
    EXPECT_TRUE(faces_light(box, kOrigin, tilt));
    EXPECT_TRUE(faces_light(test::ellipse({0, 0, 1}, 2, 1), kOrigin, tilt));
    const glm::dvec3 more = glm::normalize(glm::dvec3(1, 1, -2.5));
    EXPECT_TRUE(faces_light(box, kOrigin, more));
    EXPECT_FALSE(faces_light(test::ellipse({0, 0, 1}, 2, 1), kOrigin, more));
}

TEST(FacesLight, ALineCountsWhileAnEndIsAboveTheTangentPlane) {
    EXPECT_TRUE(faces_light(test::line({3, 0, 0}, {0, 0, 1}), kOrigin, kUp));
    EXPECT_FALSE(faces_light(test::line({3, 0, -2}, {0, 0, 1}), kOrigin, kUp));
}

TEST(FacesLight, ASpotCountsInsideItsStretchedConeOnly) {
    Light light = test::point_light({0, 0, 2}, 0.1);
    light.kind = LightKind::Spot;
    light.direction_ws = {0, 0, -1};
    light.half_u_ws = {1, 0, 0};
    light.spot_angle_rad = test::kPi / 2.0;  // at height 2 a disc of radius 2
    EXPECT_TRUE(faces_light(light, {1.99, 0, 0}, kUp));
    EXPECT_FALSE(faces_light(light, {2.01, 0, 0}, kUp));
    EXPECT_TRUE(faces_light(light, {0, 1.99, 0}, kUp));
    EXPECT_FALSE(faces_light(light, {0, 0, 3}, -kUp)) << "behind the spot";
    light.spot_stretch = {2.0, 0.5};
    EXPECT_TRUE(faces_light(light, {3.99, 0, 0}, kUp));
    EXPECT_FALSE(faces_light(light, {4.01, 0, 0}, kUp));
    EXPECT_TRUE(faces_light(light, {0, 0.99, 0}, kUp));
    EXPECT_FALSE(faces_light(light, {0, 1.01, 0}, kUp));
}

TEST(LightMask, HoldsReceivingGeometryOnly) {
    Scene scene;
    scene.instances = {test::place(test::square(1)), test::place(test::square(1))};
    scene.instances[1].receives = false;
    View view = test::view_of({{{0, 0, 0}}, {{0.5, 0, 0}, kUp, 1}, {{0.2, 0, 0}, -kUp}, {{0.1, 0, 0}}});
    view.instance[3] = -1;
    Light light = test::point_light({0, 0, 2}, 0.1);
    EXPECT_EQ(light_mask(scene, view, light), (std::vector<std::uint8_t>{1, 0, 0, 0}));
    light.casts_shadow = false;
    EXPECT_EQ(light_mask(scene, view, light), (std::vector<std::uint8_t>{1, 0, 0, 0}));
}

TEST(LightMask, LeavesACeilingDarkAsAWholeThatALampIsFlushWith) {
    for (const double scale : {1e-4, 1.0, 1e4}) {
        for (const glm::dvec3 move : {glm::dvec3(0.0), glm::dvec3(1e6, -3e5, 2e5)}) {
            Scene scene;
            scene.instances = {test::place(test::square(1))};
            Light light = test::rectangle({0.3, 0.2, 2}, 0.2, 0.2);
            std::vector<test::Point> points = test::floor_points({-5, -5}, {5, 5}, 40, 40);
            for (test::Point& point : points) {
                point.position_ws.z = 2.0;
                point.normal_ws = {0, 0, -1};
            }
            const glm::dmat4 turn = glm::rotate(glm::dmat4{1.0}, 0.7, glm::normalize(glm::dvec3(1, 2, 3)));
            test::transform(test::moved(move) * glm::scale(turn, glm::dvec3(scale)), scene, light, points);
            const std::vector<std::uint8_t> mask = light_mask(scene, test::view_of(points, 40), light);
            EXPECT_EQ(std::count(mask.begin(), mask.end(), 1), 0) << "scale " << scale;
        }
    }
}

}  // namespace
}  // namespace penumbra
