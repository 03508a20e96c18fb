#include "penumbra/light.h"

#include <cmath>
#include <functional>
#include <limits>
#include <numbers>

#include "scene/light_names.h"
#include "scene/normalise.h"
#include "scenes.h"

namespace penumbra {
namespace {

using test::expect_near;
using test::light_of;
using test::polygon_light;
using test::refusal;
using testing::AllOf;
using testing::HasSubstr;
using testing::IsEmpty;

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

std::string refusal_of(const Light& light) {
    return refusal([&] { validate(light); });
}

Light normalised(Light light) {
    normalise(light);
    return light;
}

const std::vector<glm::dvec3> kSquare{{0, 0, 2}, {1, 0, 2}, {1, 1, 2}, {0, 1, 2}};  // counter-clockwise from above

TEST(LightNames, GoBothWaysForEveryKind) {
    for (const LightKind kind : kLightKinds) {
        EXPECT_EQ(light_kind_from_string(to_string(kind)), kind);
    }
    EXPECT_EQ(light_kind_from_string("torch"), std::nullopt);
    EXPECT_EQ(light_kind_from_string(""), std::nullopt);
}

TEST(HasNoExtent, IsTrueForEveryKindOfSizeZero) {
    for (const LightKind kind : kLightKinds) {
        Light light = light_of(kind);
        light.corners_ws.assign(3, glm::dvec3{1, 2, 3});
        EXPECT_TRUE(has_no_extent(light)) << to_string(kind);
        EXPECT_THAT(refusal_of(light), IsEmpty()) << to_string(kind);
    }
}

TEST(HasNoExtent, IsFalseForTheSmallestExtent) {
    const double tiny = std::numeric_limits<double>::denorm_min();
    Light point = light_of(LightKind::Point);
    point.radius_m = tiny;
    EXPECT_FALSE(has_no_extent(point));
    Light sun = light_of(LightKind::Sun);
    sun.sun_angle_rad = tiny;
    EXPECT_FALSE(has_no_extent(sun));
    Light rectangle = light_of(LightKind::Rectangle);
    rectangle.half_v_ws.y = tiny;
    EXPECT_FALSE(has_no_extent(rectangle));
    EXPECT_FALSE(has_no_extent(polygon_light({{0, 0, 0}, {0, 0, 0}, {tiny, 0, 0}})));
}

TEST(ValidateLight, PassesTheDefaultOfBlendersScriptedLights) {
    EXPECT_THAT(refusal_of(light_of(LightKind::Point)), IsEmpty());
    EXPECT_THAT(refusal_of(light_of(LightKind::Spot)), IsEmpty());
    EXPECT_THAT(refusal_of(light_of(LightKind::Sun)), IsEmpty());
}

TEST(ValidateLight, NamesLightMemberAndValue) {
    Light light = light_of(LightKind::Point);
    light.radius_m = -0.25;
    EXPECT_THAT(refusal_of(light), AllOf(HasSubstr("light \"Lamp\""), HasSubstr("radius is -0.25"), HasSubstr("give")));
}

TEST(ValidateLight, RefusesNotANumberInEveryMemberOfEveryKind) {
    const std::vector<std::function<void(Light&)>> spoils{
        [](Light& l) { l.position_ws.x = kNan; },   [](Light& l) { l.direction_ws.y = kNan; },
        [](Light& l) { l.half_u_ws.z = kNan; },     [](Light& l) { l.half_v_ws.x = kNan; },
        [](Light& l) { l.corners_ws[1].y = kNan; }, [](Light& l) { l.radius_m = kNan; },
        [](Light& l) { l.sun_angle_rad = kNan; },   [](Light& l) { l.spot_angle_rad = kNan; },
        [](Light& l) { l.spot_blend = kNan; },      [](Light& l) { l.spot_stretch.x = kNan; },
        [](Light& l) { l.power_w.z = kNan; }};
    for (const LightKind kind : kLightKinds) {
        for (const auto& spoil : spoils) {
            Light light = light_of(kind);
            light.corners_ws = kSquare;
            spoil(light);
            EXPECT_THAT(refusal_of(light), HasSubstr("nan")) << to_string(kind);
        }
    }
}

TEST(ValidateLight, RefusesAnglesBeyondAHalfTurnAndStretchesThatAreNotPositive) {
    Light sun = light_of(LightKind::Sun);
    sun.sun_angle_rad = 3.2;
    EXPECT_THAT(refusal_of(sun), HasSubstr("sun angle is 3.2"));
    Light spot = light_of(LightKind::Spot);
    spot.spot_stretch.y = 0.0;
    EXPECT_THAT(refusal_of(spot), HasSubstr("spot stretch"));
    spot = light_of(LightKind::Spot);
    spot.spot_blend = 1.01;
    EXPECT_THAT(refusal_of(spot), HasSubstr("spot blend is 1.01"));
}

TEST(ValidateLight, TakesNegativePowerAsLightTakenAway) {
    Light light = light_of(LightKind::Point);
    light.power_w = {-1, 2, 0};
    EXPECT_THAT(refusal_of(light), IsEmpty());
}

TEST(ValidateLight, WantsADirectionWhereTheKindHasOne) {
    for (const LightKind kind : kLightKinds) {
        Light light = light_of(kind);
        light.corners_ws = kSquare;
        light.direction_ws = glm::dvec3{0.0};
        const bool all_around = kind == LightKind::Point || kind == LightKind::Line;
        EXPECT_EQ(refusal_of(light).empty(), all_around) << to_string(kind);
    }
}

TEST(NormaliseLight, GivesAUnitDirectionOverManyDecades) {
    for (const double length : {1e-300, 1e-20, 1.0, 1e20, 1e300}) {
        Light sun = light_of(LightKind::Sun);
        sun.direction_ws = length * glm::dvec3{0.6, 0.0, -0.8};
        expect_near(normalised(sun).direction_ws, {0.6, 0.0, -0.8}, 1e-15);
    }
}

TEST(NormaliseLight, ClampsAngleThatRoundingPushedOverAHalfTurn) {
    Light sun = light_of(LightKind::Sun);
    sun.sun_angle_rad = std::nextafter(std::numbers::pi, 4.0);
    EXPECT_EQ(normalised(sun).sun_angle_rad, std::numbers::pi);
}

TEST(NormaliseLight, GivesASpotAnOrthonormalFrame) {
    Light spot = light_of(LightKind::Spot);
    spot.direction_ws = {0, 0, -2};
    spot.half_u_ws = {3, 0, 1};
    spot = normalised(spot);
    expect_near(spot.half_u_ws, {1, 0, 0}, 1e-15);
    expect_near(spot.half_v_ws, {0, 1, 0}, 1e-15);
    spot.half_u_ws = {0, 0, 1};  // along the axis: any frame will do
    spot = normalised(spot);
    EXPECT_NEAR(glm::dot(spot.half_u_ws, spot.direction_ws), 0.0, 1e-15);
    EXPECT_NEAR(glm::length(spot.half_v_ws), 1.0, 1e-15);
}

TEST(NormaliseLight, SnapsTheDirectionOfARectangleToItsNormalOnTheSameSide) {
    Light light = light_of(LightKind::Rectangle);
    light.half_u_ws = {1, 0, 0};
    light.half_v_ws = {0.5, 2, 0};
    light.direction_ws = {0.3, 0.2, -1};
    expect_near(normalised(light).direction_ws, {0, 0, -1}, 1e-15);
    std::swap(light.half_u_ws, light.half_v_ws);  // a mirrored light shines to the same side
    expect_near(normalised(light).direction_ws, {0, 0, -1}, 1e-15);
    light.direction_ws = {1, 0, 0};
    EXPECT_THAT(refusal_of(light), HasSubstr("lies in the plane"));
}

TEST(NormaliseLight, KeepsARectangleWithoutWidthOneSided) {
    Light light = light_of(LightKind::Rectangle);
    light.half_u_ws = {1, 0, 0};
    light.direction_ws = {0.5, 0, -1};
    light = normalised(light);
    EXPECT_EQ(light.kind, LightKind::Rectangle);
    expect_near(light.direction_ws, {0, 0, -1}, 1e-15);
    light.direction_ws = {1, 0, 0};
    EXPECT_THAT(refusal_of(light), HasSubstr("runs along the light"));
}

TEST(NormalisePolygon, OrdersCornersCounterClockwiseSeenFromTheLitSide) {
    Light up = polygon_light(kSquare);
    up.direction_ws = {0, 0, 1};
    EXPECT_EQ(normalised(up).corners_ws, kSquare);
    Light down = up;
    down.direction_ws = {0, 0, -1};
    down = normalised(down);
    EXPECT_EQ(down.corners_ws, (std::vector<glm::dvec3>{kSquare.rbegin(), kSquare.rend()}));
    expect_near(down.direction_ws, {0, 0, -1}, 1e-15);
    expect_near(down.position_ws, {0.5, 0.5, 2.0}, 1e-15);
    EXPECT_EQ(normalised(down).corners_ws, down.corners_ws);
}

TEST(NormalisePolygon, TakesThreeToEightCorners) {
    for (std::size_t count = 0; count <= 10; ++count) {
        std::vector<glm::dvec3> corners;
        for (std::size_t i = 0; i < count; ++i) {
            const double angle = 2.0 * std::numbers::pi * static_cast<double>(i) / static_cast<double>(count);
            corners.emplace_back(1e6 + std::cos(angle), std::sin(angle), 0.0);
        }
        EXPECT_EQ(refusal_of(polygon_light(corners)).empty(), count >= 3 && count <= 8) << count;
    }
}

TEST(NormalisePolygon, RefusesACornerOutOfThePlane) {
    Light light = polygon_light(kSquare);
    light.corners_ws[2].z += 1e-3;
    EXPECT_THAT(refusal_of(light), AllOf(HasSubstr("leaves the polygon's plane"), HasSubstr("flatten it")));
    light.corners_ws[2].z = 2.0 + 1e-8;
    EXPECT_THAT(refusal_of(light), IsEmpty());
}

TEST(NormalisePolygon, JudgesFlatnessAtAnyScale) {
    for (const double scale : {1e-6, 1e-3, 1.0, 1e6}) {
        Light light = polygon_light(kSquare);
        for (glm::dvec3& corner : light.corners_ws) {
            corner *= scale;
        }
        EXPECT_THAT(refusal_of(light), IsEmpty());
        light.corners_ws[2].z += 1e-3 * scale;
        EXPECT_THAT(refusal_of(light), HasSubstr("leaves the polygon's plane"));
    }
}

TEST(NormalisePolygon, RefusesADentAStarAndABowTie) {
    EXPECT_THAT(refusal_of(polygon_light({{0, 0, 0}, {2, 0, 0}, {0.5, 0.5, 0}, {0, 2, 0}})), HasSubstr("not convex"));
    std::vector<glm::dvec3> star;
    for (int i = 0; i < 5; ++i) {
        star.emplace_back(std::cos(0.8 * std::numbers::pi * i), std::sin(0.8 * std::numbers::pi * i), 0.0);
    }
    EXPECT_THAT(refusal_of(polygon_light(star)), HasSubstr("crosses itself"));
    EXPECT_THAT(refusal_of(polygon_light({{0, 0, 0}, {1, 1, 0}, {1, 0, 0}, {0, 1, 0}})), HasSubstr("crosses itself"));
}

TEST(NormalisePolygon, DropsRepeatedCornersAndKeepsCornersInsideAnEdge) {
    Light light = polygon_light({{0, 0, 0}, {0, 0, 0}, {1, 0, 0}, {2, 0, 0}, {0, 2, 0}, {0, 0, 0}});
    light = normalised(light);
    EXPECT_EQ(light.corners_ws.size(), 4U);
    EXPECT_THAT(light.corners_ws, testing::Contains(glm::dvec3(1, 0, 0)));
}

TEST(NormalisePolygon, KeepsAPolygonWithoutAreaOneSided) {
    Light light = polygon_light({{0, 0, 0}, {1, 0, 0}, {3, 0, 0}});
    light.direction_ws = {0.5, 0, -1};
    light = normalised(light);
    EXPECT_FALSE(has_no_extent(light));
    expect_near(light.direction_ws, {0, 0, -1}, 1e-15);
}

}  // namespace
}  // namespace penumbra
