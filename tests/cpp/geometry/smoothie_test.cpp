#include "geometry/smoothie.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

namespace penumbra {
namespace {

constexpr double kPi = std::numbers::pi;
constexpr Falloff kAll[] = {Falloff::Linear, Falloff::Sinusoidal, Falloff::Cubic, Falloff::Disc};

TEST(Smoothie, EveryFalloffRunsFromZeroToOneThroughTheMiddle) {
    for (const Falloff kind : kAll) {
        EXPECT_EQ(falloff(kind, 0.0), 0.0);
        EXPECT_NEAR(falloff(kind, 1.0), 1.0, 1e-15);
        EXPECT_NEAR(falloff(kind, 0.5), 0.5, 1e-15);
        EXPECT_EQ(falloff(kind, -3.0), 0.0);
        EXPECT_NEAR(falloff(kind, 7.0), 1.0, 1e-15);
        for (int i = 1; i <= 1000; ++i) {
            EXPECT_GE(falloff(kind, i / 1000.0), falloff(kind, (i - 1) / 1000.0));
        }
    }
}

double largest_gap(Falloff a, Falloff b) {
    double largest = 0.0;
    for (int i = 0; i <= 100000; ++i) {
        largest = std::max(largest, std::abs(falloff(a, i / 100000.0) - falloff(b, i / 100000.0)));
    }
    return largest;
}

// Section 2.5 of the specification: how far the falloffs lie apart, and from a disc cut by an edge.
TEST(Smoothie, FalloffsLieAsFarApartAsTheSpecificationSays) {
    EXPECT_NEAR(largest_gap(Falloff::Sinusoidal, Falloff::Cubic), 0.0100, 5e-5);
    EXPECT_NEAR(largest_gap(Falloff::Sinusoidal, Falloff::Linear), 0.105, 5e-4);
    EXPECT_NEAR(largest_gap(Falloff::Sinusoidal, Falloff::Disc), 0.049, 5e-4);
    EXPECT_NEAR(largest_gap(Falloff::Cubic, Falloff::Disc), 0.039, 5e-4);
    EXPECT_NEAR(largest_gap(Falloff::Linear, Falloff::Disc), 0.058, 5e-4);
}

TEST(Smoothie, RemapIsBoundedAndHiddenSmoothiesAreLit) {
    EXPECT_EQ(remapped_alpha(0.3, 0.0), 0.3);
    EXPECT_DOUBLE_EQ(remapped_alpha(0.1, 0.75), 0.4);
    EXPECT_EQ(remapped_alpha(0.1, 0.95), 1.0);
    EXPECT_EQ(remapped_alpha(0.0, 0.999), 0.0);
    for (const double hidden : {1.0, 1.5, 1e30}) {
        EXPECT_EQ(remapped_alpha(0.0, hidden), 1.0) << "0/0 counts as lit";
    }
}

// Parker's outer surface: seen from the receiver, an edge's shadow grows by R (r - b) / r at the blocker.
TEST(Smoothie, WidthOfTheLightEqualsTheOuterSurfaceOfParker) {
    for (const double b : {0.5, 2.0, 7.5}) {
        for (const double r : {b, b + 0.1, 9.0}) {
            const double radius = 0.3;
            const double at_blocker = radius * (r - b) / r;
            EXPECT_NEAR(smoothie_width_m(radius / b, b, r), at_blocker * r / b, 1e-13);
        }
    }
}

Light rectangle(double half_x, double half_y) {
    Light light;
    light.kind = LightKind::Rectangle;
    light.half_u_ws = {half_x, 0, 0};
    light.half_v_ws = {0, half_y, 0};
    return light;
}

TEST(Smoothie, HalfWidthIsTheSupportOfTheLightsShape) {
    const glm::dmat3 same{1.0};
    const double a = 0.7;
    const glm::dvec2 n{std::cos(a), std::sin(a)};
    EXPECT_NEAR(LightExtent::of(rectangle(2, 1), same).half_width(n), 2 * n.x + n.y, 1e-15);
    Light ellipse = rectangle(2, 1);
    ellipse.kind = LightKind::Ellipse;
    EXPECT_NEAR(LightExtent::of(ellipse, same).half_width(n), std::hypot(2 * n.x, n.y), 1e-15);
    Light line = rectangle(2, 0);
    line.kind = LightKind::Line;
    EXPECT_NEAR(LightExtent::of(line, same).half_width(n), 2 * n.x, 1e-15);
    EXPECT_NEAR(LightExtent::of(line, same).half_width({0, 1}), 0.0, 1e-15);
    Light sun;
    sun.kind = LightKind::Sun;
    sun.sun_angle_rad = 0.2;
    EXPECT_NEAR(LightExtent::of(sun, same).half_width(n), std::tan(0.1), 1e-15);
    sun.sun_angle_rad = kPi;
    EXPECT_TRUE(std::isfinite(LightExtent::of(sun, same).half_width(n)));
}

// The lit rim behind an edge is thrown by the light's far side: a triangle's is not the same to the left and right.
TEST(Smoothie, HalfWidthOfATriangleLooksAgainstTheNormal) {
    Light light;
    light.kind = LightKind::Polygon;
    light.corners_ws = {{-1, -1, 0}, {2, 0, 0}, {-1, 1, 0}};
    const LightExtent extent = LightExtent::of(light, glm::dmat3{1.0});
    EXPECT_NEAR(extent.half_width({1, 0}), 1.0, 1e-15);
    EXPECT_NEAR(extent.half_width({-1, 0}), 2.0, 1e-15);
    EXPECT_NEAR(extent.largest(), 2.0, 1e-15);
}

TEST(Smoothie, NoHalfWidthExceedsTheLargest) {
    const glm::dmat3 turn{{0.8, 0.6, 0}, {-0.6, 0.8, 0}, {0, 0, 1}};
    Light skewed = rectangle(2, 1);
    skewed.half_v_ws = {1.5, 1, 0};
    Light ellipse = skewed;
    ellipse.kind = LightKind::Ellipse;
    for (const Light& light : {rectangle(2, 1), skewed, ellipse}) {
        const LightExtent extent = LightExtent::of(light, turn);
        for (int i = 0; i < 360; ++i) {
            const double a = kPi * i / 180;
            EXPECT_LE(extent.half_width({std::cos(a), std::sin(a)}), extent.largest() + 1e-12);
        }
    }
}

TEST(Smoothie, TheDiscHasTheLightsAreaAndALineItsMeanHalfWidth) {
    EXPECT_NEAR(LightExtent::disc_of(rectangle(0.5, 0.5)).half_width({1, 0}), std::sqrt(1 / kPi), 1e-15);
    Light line = rectangle(2, 0);
    line.kind = LightKind::Line;
    double mean = 0.0;
    for (int i = 0; i < 10000; ++i) {
        mean += LightExtent::of(line, glm::dmat3{1.0}).half_width({std::cos(kPi * i / 5000), std::sin(kPi * i / 5000)});
    }
    EXPECT_NEAR(LightExtent::disc_of(line).half_width({1, 0}), mean / 10000, 1e-6);
}

// Section 3: errors of the outer ramp against a strip light of full penumbra W, by quadrature.
struct Errors {
    double integral, lowest, highest;
};
Errors against_strip(Falloff kind, double smoothie_over_full) {
    Errors errors{0.0, 0.0, 0.0};
    const int n = 400000;
    for (int i = 0; i < n; ++i) {
        const double x = -1.0 + 3.0 * (i + 0.5) / n;  // of W
        const double e = (x < 0 ? 0.0 : falloff(kind, x / smoothie_over_full)) - std::clamp(0.5 + x, 0.0, 1.0);
        errors.integral += e * 3.0 / n;
        errors.lowest = std::min(errors.lowest, e);
        errors.highest = std::max(errors.highest, e);
    }
    return errors;
}

TEST(Smoothie, ErrorAgainstAStripLightIsWhatTheSpecificationSays) {
    const Errors matched = against_strip(Falloff::Linear, 0.5);
    EXPECT_NEAR(matched.integral, -0.25, 1e-5);
    EXPECT_NEAR(matched.lowest, -0.5, 1e-5);
    EXPECT_LE(matched.highest, 1e-12) << "never too light";
    EXPECT_NEAR(against_strip(Falloff::Linear, 1.0).integral, -0.5, 1e-5);
    EXPECT_NEAR(against_strip(Falloff::Sinusoidal, 0.5).highest, 0.026, 1e-3);
    EXPECT_NEAR(against_strip(Falloff::Cubic, 0.5).highest, 0.022, 1e-3);
    EXPECT_NEAR(against_strip(Falloff::Sinusoidal, 0.5).integral, -0.25, 1e-5);
    EXPECT_NEAR(against_strip(Falloff::Linear, 0.3).highest, 0.5 - 0.3, 1e-5);
}

}  // namespace
}  // namespace penumbra
