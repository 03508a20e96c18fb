#include "geometry/radiometry.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "geometry/light_shape.h"

namespace penumbra {
namespace {

constexpr double kPi = std::numbers::pi;

Light light_of(LightKind kind) {
    Light light;
    light.kind = kind;
    light.power_w = {100.0, 50.0, 0.0};
    light.position_ws = {0.0, 0.0, 3.0};
    light.direction_ws = {0.0, 0.0, -1.0};
    return light;
}

double red(const Light& light, const glm::dvec3& p = glm::dvec3{0.0}) {
    return unshadowed_irradiance(light, p, {0.0, 0.0, 1.0}).x;
}

TEST(Radiometry, SphereOfAnyRadiusLightsLikeItsPointWhereTheHorizonDoesNotCut) {
    Light light = light_of(LightKind::Point);
    const double point = red(light);
    EXPECT_NEAR(point, 100.0 / (4.0 * kPi * 9.0), 1e-14);
    for (const double radius : {1e-13, 1e-9, 1e-3, 0.5, 2.9}) {
        light.radius_m = radius;
        EXPECT_NEAR(red(light) / point, 1.0, 1e-13) << radius;
    }
}

TEST(Radiometry, SunsOfAnyAngleLightASurfaceThatFacesThemAlike) {
    Light light = light_of(LightKind::Sun);
    for (const double angle : {0.0, 1e-10, 1e-6, 0.0092, 1.0, 3.0, kPi}) {
        light.sun_angle_rad = angle;
        EXPECT_NEAR(red(light), 100.0, 1e-11) << angle;
    }
}

TEST(Radiometry, AreaLightsTendToOneFacingPoint) {
    Light light = light_of(LightKind::Rectangle);
    const double point = red(light);
    EXPECT_NEAR(point, 100.0 / (kPi * 9.0), 1e-13) << "I = P / pi along the normal";
    for (const double size : {1e-11, 1e-6, 1e-3}) {
        for (const LightKind kind : {LightKind::Rectangle, LightKind::Ellipse}) {
            light.kind = kind;
            light.half_u_ws = {size, 0.0, 0.0};
            light.half_v_ws = {0.0, 2.0 * size, 0.0};
            EXPECT_NEAR(red(light) / point, 1.0, 1e-11 + size * size) << size;
            light.half_v_ws = glm::dvec3{0.0};
            EXPECT_NEAR(red(light) / point, 1.0, 1e-11 + size * size) << "as a line of half length " << size;
        }
    }
}

TEST(Radiometry, FluxThroughAPlaneBelowAnAreaLightIsItsPower) {
    // All of a downward light's flux passes a large plane below it: 2 pi times the integral of E rho.
    Light light = light_of(LightKind::Ellipse);
    light.half_u_ws = {0.7, 0.0, 0.0};
    light.half_v_ws = {0.0, 0.7, 0.0};
    double flux = 0.0;
    constexpr int kSteps = 4000;
    for (int i = 0; i < kSteps; ++i) {
        const double t = (i + 0.5) / kSteps * 0.5 * kPi;  // rho = 3 tan t
        const double rho = 3.0 * std::tan(t);
        const double width = 3.0 / (std::cos(t) * std::cos(t)) * 0.5 * kPi / kSteps;
        flux += 2.0 * kPi * rho * red(light, {rho, 0.0, 0.0}) * width;
    }
    EXPECT_NEAR(flux, 100.0, 1e-4);
}

TEST(Radiometry, ColourIsKept) {
    const glm::dvec3 e = unshadowed_irradiance(light_of(LightKind::Point), glm::dvec3{0.0}, {0.0, 0.0, 1.0});
    EXPECT_EQ(e.y, 0.5 * e.x);
    EXPECT_EQ(e.z, 0.0);
}

TEST(Radiometry, AShearedEllipseKeepsItsAreaAndShape) {
    glm::dvec3 u{1.0, 0.2, 0.0};
    glm::dvec3 v{0.7, 0.9, 0.1};
    const double area = glm::length(glm::cross(u, v));
    const glm::dvec3 old_u = u;
    const glm::dvec3 old_v = v;
    principal_axes(u, v);
    EXPECT_NEAR(glm::dot(u, v), 0.0, 1e-15);
    EXPECT_GE(glm::length(u), glm::length(v));
    EXPECT_NEAR(glm::length(glm::cross(u, v)), area, 1e-15);
    // Same support in any direction.
    for (const glm::dvec3& n : {glm::dvec3{1, 0, 0}, glm::dvec3{0.3, 0.8, 0.5}}) {
        EXPECT_NEAR(std::hypot(glm::dot(n, u), glm::dot(n, v)), std::hypot(glm::dot(n, old_u), glm::dot(n, old_v)),
                    1e-15);
    }
}

}  // namespace
}  // namespace penumbra
