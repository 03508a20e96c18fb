// Closed forms of plateaus.md in float64: tolerances from its section 3 and from the places marked [V].
#include "geometry/plateau.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace penumbra::plateau {
namespace {

constexpr double kPi = 3.14159265358979323846;

glm::dvec2 right_of(const glm::dvec2& e) {
    return {e.y, -e.x};
}

class Plateau : public testing::Test {
protected:
    double uniform(double low, double high) { return std::uniform_real_distribution<double>{low, high}(random_); }
    glm::dvec2 point(double reach) { return {uniform(-reach, reach), uniform(-reach, reach)}; }
    /// Least |p - c(s)| / r(s) over a fine sampling, then refined.
    static double brute_envelope(const glm::dvec2& p, const Circles& c) {
        const auto at = [&](double t) { return glm::length(p - glm::mix(c.s0, c.s1, t)) / (c.r0 + t * (c.r1 - c.r0)); };
        double best = 0.0, least = 1e300;
        for (int i = 0; i <= 400; ++i) {
            if (at(i / 400.0) < least) {
                least = at(i / 400.0);
                best = i / 400.0;
            }
        }
        double low = std::max(0.0, best - 1.0 / 400), high = std::min(1.0, best + 1.0 / 400);
        for (int i = 0; i < 80; ++i) {
            const double a = low + (high - low) / 3.0, b = high - (high - low) / 3.0;
            (at(a) < at(b) ? high : low) = at(a) < at(b) ? b : a;
        }
        return std::min(least, at(0.5 * (low + high)));
    }
    std::mt19937 random_{7};
};

TEST_F(Plateau, ProjectionLiesOnTheLineFromTheLight) {
    for (int i = 0; i < 1000; ++i) {
        const glm::dvec3 light{point(4.0), uniform(3.0, 6.0)}, v{point(4.0), uniform(0.0, 2.5)};
        const glm::dvec2 s = project(v, {light, 1.0});
        const glm::dvec3 along = glm::normalize(v - light);
        EXPECT_LT(glm::length(glm::cross(glm::dvec3{s, 0.0} - light, along)),
                  1e-12 * glm::length(glm::dvec3{s, 1.0}) + 1e-12);
        const glm::dvec3 sun = glm::normalize(light);
        const glm::dvec2 far = project(v, {1e9 * sun, 1.0});
        EXPECT_LT(glm::length(far - project(v, {sun, 0.0})), 1e-6);
        EXPECT_EQ(project(glm::dvec3{s, 0.0}, {light, 1.0}), s);
    }
}

TEST_F(Plateau, OuterTangentTouchesBothCirclesAndLeavesThemInside) {
    for (int i = 0; i < 40000; ++i) {
        const Circles c{point(1.0), point(1.0), uniform(0.0, 1.0), uniform(0.0, 1.0)};
        const auto tangent = outer_tangent(c);
        const double length = glm::length(c.s1 - c.s0);
        if (length <= std::abs(c.r0 - c.r1)) {
            EXPECT_FALSE(tangent);
            continue;
        }
        if (!tangent || length < 1e-3) {
            continue;
        }
        const glm::dvec2 n = tangent->normal;
        EXPECT_NEAR(glm::dot(n, tangent->t1 - tangent->t0), 0.0, 2e-14 / std::min(1.0, length));
        EXPECT_NEAR(glm::dot(n, c.s0) + c.r0, glm::dot(n, c.s1) + c.r1, 2e-14 / std::min(1.0, length));
        EXPECT_GE(glm::dot(n, right_of(c.s1 - c.s0)), 0.0);
    }
}

TEST_F(Plateau, EqualRadiiMakeAFlatQuad) {
    const Circles c{{0, 0}, {2, 0}, 0.5, 0.5};
    const auto tangent = outer_tangent(c);
    ASSERT_TRUE(tangent);
    EXPECT_EQ(tangent->t0, (glm::dvec2{0, -0.5}));
    EXPECT_EQ(tangent->t1, (glm::dvec2{2, -0.5}));
}

TEST_F(Plateau, ARadiusOfZeroMakesATriangle) {
    const Circles c{{0, 0}, {2, 0}, 0.5, 0.0};
    const auto tangent = outer_tangent(c);
    ASSERT_TRUE(tangent);
    EXPECT_EQ(tangent->t1, c.s1);
    EXPECT_EQ(envelope({3.0, 0.0}, {c.s1, c.s1, 0.0, 0.0}), std::numeric_limits<double>::infinity());
    EXPECT_EQ(envelope(c.s1, {c.s1, c.s1, 0.0, 0.0}), 0.0);
}

TEST_F(Plateau, EnvelopeIsTheLeastOfAllCones) {
    for (int i = 0; i < 3000; ++i) {
        const Circles c{point(1.0), point(1.0), uniform(0.01, 1.0), uniform(0.01, 1.0)};
        const glm::dvec2 p = point(2.0);
        EXPECT_NEAR(envelope(p, c), brute_envelope(p, c), 3e-8 * (1.0 + envelope(p, c)));
    }
}

TEST_F(Plateau, TheCircleThatHoldsTheOtherDecidesWithoutATangent) {
    const Circles c{{0, 0}, {0.2, 0}, 1.0, 0.1};
    EXPECT_FALSE(outer_tangent(c));
    for (int i = 0; i < 100; ++i) {
        const glm::dvec2 p = point(1.5);
        const double lambda = envelope(p, c);
        EXPECT_TRUE(std::isfinite(lambda));
        EXPECT_LE(lambda, glm::length(p - c.s0) / c.r0 + 1e-15);
    }
}

TEST_F(Plateau, BilinearInverseFindsThePointOfThePatch) {
    for (int i = 0; i < 3000; ++i) {
        const Circles c{point(1.0), point(1.0), uniform(0.05, 1.0), uniform(0.05, 1.0)};
        const auto tangent = outer_tangent(c);
        const double length = glm::length(c.s1 - c.s0);
        if (!tangent || std::abs(c.r0 - c.r1) > 0.95 * length) {
            continue;
        }
        const double u = uniform(0.01, 0.99), v = uniform(0.01, 0.99);
        EXPECT_NEAR(bilinear(patch(c, *tangent, u, v), c), v, 1e-12);
    }
}

// Two triangles instead of the patch: the error lies on the diagonal, and is what cell_error says, for every g.
TEST_F(Plateau, CellErrorIsTheLargestErrorOfTheTwoTriangles) {
    const auto measured = [&](const Circles& c, int n) {
        const Tangent tangent = *outer_tangent(c);
        double largest = 0.0;
        for (int row = 0; row < n; ++row) {
            for (int cell = 0; cell < n; ++cell) {
                const glm::dvec2 low = patch(c, tangent, double(cell) / n, double(row) / n);
                const glm::dvec2 high = patch(c, tangent, double(cell + 1) / n, double(row + 1) / n);
                for (int i = 1; i < 400; ++i) {  // the diagonal: linear in lambda
                    const double lambda = (row + i / 400.0) / n;
                    const double exact = bilinear(glm::mix(low, high, i / 400.0), c);
                    largest = std::max(largest, std::isfinite(exact) ? std::abs(exact - lambda) : 0.0);
                }
            }
        }
        return largest;
    };
    struct Row {
        double r0, r1, expected;
        int n;
    };
    for (const Row& row :
         {Row{0.6, 0.5, 0.0455, 1}, Row{0.4, 0.1, 0.333, 1}, Row{0.95, 0.05, 0.626, 1}, Row{0.6, 0.3, 0.171, 1},
          Row{0.6, 0.3, 0.050, 2}, Row{0.6, 0.3, 0.0139, 4}, Row{0.6, 0.3, 0.0037, 8}}) {
        EXPECT_NEAR(cell_error(row.r0, row.r1, row.n), row.expected, 1e-3) << row.r0 << " " << row.r1;
        EXPECT_NEAR(measured({{0, 0}, {1, 0}, row.r0, row.r1}, row.n), row.expected, 1e-3) << row.r0 << " " << row.r1;
    }
    EXPECT_EQ(cells_needed(0.5, 0.5), 1);
    EXPECT_EQ(cells_needed(0.6, 0.3), 8);
    EXPECT_EQ(cells_needed(0.5, 0.0), 32);
}

TEST_F(Plateau, EnvelopeAndBilinearDifferByTheGapAtMost) {
    EXPECT_NEAR(envelope_gap(0.1), 0.00075, 5e-5);
    EXPECT_NEAR(envelope_gap(0.25), 0.0048, 1e-4);
    EXPECT_NEAR(envelope_gap(0.5), 0.0223, 2e-4);
    EXPECT_NEAR(envelope_gap(0.7), 0.0553, 2e-4);
    EXPECT_NEAR(envelope_gap(0.9), 0.153, 1e-3);
    for (const double g : {0.1, 0.25, 0.5, 0.7, 0.9}) {
        const Circles c{{0, 0}, {1, 0}, 1.0, 1.0 - g};
        double largest = 0.0;
        for (int i = 0; i < 40000; ++i) {
            const glm::dvec2 p{uniform(-1.0, 2.5), uniform(-1.2, 0.0)};
            const double lower = envelope(p, c);
            const double least =
                std::min({bilinear(p, c), glm::length(p - c.s0) / c.r0, glm::length(p - c.s1) / c.r1, 1.0});
            if (lower < 1.0) {
                EXPECT_LE(lower, least + 1e-12);
                largest = std::max(largest, least - lower);
            }
        }
        EXPECT_LE(largest, envelope_gap(g) + 1e-6) << g;  // of its 4096 samples
        EXPECT_GE(largest, 0.9 * envelope_gap(g)) << g;   // attained
    }
}

// E4: with r = R h / (H - h) radii are affine along a projected edge, so a split changes nothing.
TEST_F(Plateau, SplittingAnEdgeChangesNothingWithDiscRadiiAndDarkensLinearOnes) {
    const PlaneLight light{0.3, -0.2, 5.0, 1.0};
    for (int i = 0; i < 500; ++i) {
        const glm::dvec3 a{point(1.0), uniform(0.0, 4.0)}, b{point(1.0), uniform(0.0, 4.0)};
        const glm::dvec3 m = glm::mix(a, b, uniform(0.1, 0.9));
        const glm::dvec2 sa = project(a, light), sb = project(b, light), sm = project(m, light);
        const double t = glm::dot(sm - sa, sb - sa) / glm::dot(sb - sa, sb - sa);
        EXPECT_NEAR(image_scale(m.z, light), glm::mix(image_scale(a.z, light), image_scale(b.z, light), t), 1e-12);
        EXPECT_GE(0.1 * m.z, 0.1 * glm::mix(a.z, b.z, t) - 1e-12);  // linear: concave along the projection
    }
}

TEST_F(Plateau, DiscCutMatchesThePublishedDistancesFromOtherFalloffs) {
    double sine = 0.0, smooth = 0.0, linear = 0.0, sine_to_smooth = 0.0, mean = 0.0, above = 0.0;
    constexpr int kSteps = 20000;
    for (int i = 0; i <= kSteps; ++i) {
        const double t = double(i) / kSteps;
        const double full = falloff(Falloff::DiscFull, t);
        sine = std::max(sine, std::abs(full - falloff(Falloff::Sine, t)));
        smooth = std::max(smooth, std::abs(full - falloff(Falloff::Smoothstep, t)));
        linear = std::max(linear, std::abs(full - t));
        sine_to_smooth =
            std::max(sine_to_smooth, std::abs(falloff(Falloff::Sine, t) - falloff(Falloff::Smoothstep, t)));
        mean += disc_cut(t) / (kSteps + 1);
        above = std::max(above, falloff(Falloff::Sine, t) - disc_cut(t));
        EXPECT_GE(disc_cut(t), 0.5 + 0.5 * t - 1e-15);  // B1, B2
    }
    EXPECT_NEAR(sine, 0.0491, 1e-4);
    EXPECT_NEAR(smooth, 0.0394, 1e-4);
    EXPECT_NEAR(linear, 0.0577, 1e-4);
    EXPECT_NEAR(sine_to_smooth, 0.0100, 1e-4);
    EXPECT_NEAR(mean, 1.0 - 2.0 / (3.0 * kPi), 1e-4);
    EXPECT_NEAR(above, 0.0009, 1e-4);
}

TEST_F(Plateau, SquareAndPolygonCutsAreAreas) {
    const std::vector<glm::dvec2> square{{-1, -1}, {1, -1}, {1, 1}, {-1, 1}};
    std::vector<glm::dvec2> round;
    for (int i = 0; i < 256; ++i) {
        round.emplace_back(std::cos(2 * kPi * i / 256), std::sin(2 * kPi * i / 256));
    }
    for (int i = 0; i < 500; ++i) {
        const glm::dvec2 n = point(1.0);
        const double xi = uniform(-1.0, 1.0);
        EXPECT_NEAR(square_cut(xi, n), polygon_cut(xi, n, square), 1e-9);
        EXPECT_NEAR(disc_cut(xi), polygon_cut(xi, n, round), 2e-4);
    }
    EXPECT_NEAR(square_cut(0.4, {1, 0}), 0.7, 1e-12);  // parallel: linear
}

TEST_F(Plateau, GaugesOfBoxesDiscsLozengesAndPolygonsAgree) {
    const std::vector<glm::dvec2> square{{-1, -1}, {1, -1}, {1, 1}, {-1, 1}};
    for (int i = 0; i < 2000; ++i) {
        const glm::dvec2 x = point(3.0);
        EXPECT_NEAR(gauge(RoundedBox{{0, 0}, 1.0}, x), glm::length(x), 1e-12);
        EXPECT_NEAR(gauge(RoundedBox{{1, 1}, 0.0}, x), std::max(std::abs(x.x), std::abs(x.y)), 1e-12);
        EXPECT_NEAR(gauge(square, x), gauge(RoundedBox{{1, 1}, 0.0}, x), 1e-12);
        // On the border of the grown shape: distance to its core is its radius.
        const RoundedBox lozenge{{1.0, 0.0}, 0.2};
        const double lambda = gauge(lozenge, x);
        const glm::dvec2 nearest{std::clamp(x.x, -lambda, lambda), 0.0};
        EXPECT_NEAR(glm::length(x - nearest), 0.2 * lambda, 1e-9 * (1.0 + lambda));
    }
}

TEST_F(Plateau, SegmentGaugeIsTheLeastOverItsPoints) {
    const std::vector<glm::dvec2> triangle{{-0.7, -0.5}, {0.9, -0.4}, {-0.2, 0.9}};
    for (int i = 0; i < 600; ++i) {
        const double wa = uniform(0.1, 2.0), wb = uniform(0.1, 2.0);
        const glm::dvec3 a{wa * point(3.0), wa}, b{wb * point(3.0), wb};
        for (const RoundedBox& shape : {RoundedBox{{0, 0}, 1.0}, RoundedBox{{1, 1}, 0.0}, RoundedBox{{0.7, 0.7}, 0.3},
                                        RoundedBox{{1.0, 0.0}, 0.1}}) {
            double least = 1e300, least_triangle = 1e300;
            for (int k = 0; k <= 4000; ++k) {
                const glm::dvec2 x = glm::mix(glm::dvec2{a} / wa, glm::dvec2{b} / wb, k / 4000.0);
                least = std::min(least, gauge(shape, x));
                least_triangle = std::min(least_triangle, gauge(triangle, x));
            }
            EXPECT_LE(gauge(shape, a, b), least + 1e-9);
            EXPECT_NEAR(gauge(shape, a, b), least, 0.02);  // of the sampling: a lozenge is steep across
            EXPECT_LE(gauge(triangle, a, b), least_triangle + 1e-9);
            EXPECT_NEAR(gauge(triangle, a, b), least_triangle, 5e-3);
        }
    }
}

TEST_F(Plateau, BallImageIsTheIntersectionOfItsCone) {
    for (const double theta : {0.2, 0.7, 1.2}) {
        for (const double alpha : {0.01, 0.1, 0.2}) {
            const auto ellipse = ball_image(2.0, theta, alpha);
            ASSERT_TRUE(ellipse);
            // Rays from (0, 0, 2) at the angle alpha around the axis hit z = 0 on the ellipse around (centre, 0).
            const glm::dvec3 axis{std::sin(theta), 0.0, -std::cos(theta)};
            const glm::dvec3 u{std::cos(theta), 0.0, std::sin(theta)};
            const double centre = 2.0 * std::tan(theta) + ellipse->shift_m;
            for (int i = 0; i < 64; ++i) {
                const double phi = 2 * kPi * i / 64;
                const glm::dvec3 ray = std::cos(alpha) * axis +
                                       std::sin(alpha) * (std::cos(phi) * u + std::sin(phi) * glm::dvec3{0, 1, 0});
                const glm::dvec2 hit = glm::dvec2{ray} * (-2.0 / ray.z);
                const double x = (hit.x - centre) / ellipse->along_m, y = hit.y / ellipse->across_m;
                EXPECT_NEAR(x * x + y * y, 1.0, 2e-9);
            }
        }
    }
    EXPECT_FALSE(ball_image(1.0, 1.5, 0.2));  // cos(1.5) < sin(0.2): a hyperbola
    const double narrow = ball_image(1.0, 1.0, 1e-6)->across_m;
    EXPECT_NEAR(narrow, 1e-6 / std::cos(1.0), 1e-12);
}

TEST_F(Plateau, TangentsOfEllipsesAreThoseOfCirclesScaled) {
    for (int i = 0; i < 500; ++i) {
        const Circles c{point(1.0), point(1.0) + glm::dvec2{2.5, 0.0}, uniform(0.1, 0.6), uniform(0.1, 0.6)};
        const glm::dmat2 scale{1.0, 0.0, 0.0, 0.5};
        const auto q = [&](double r) { return scale * glm::dmat2{r * r, 0, 0, r * r} * glm::transpose(scale); };
        const auto ellipses = outer_tangent(scale * c.s0, q(c.r0), scale * c.s1, q(c.r1));
        const auto circles = outer_tangent(c);
        ASSERT_TRUE(ellipses && circles);
        EXPECT_LT(glm::length(ellipses->t0 - scale * circles->t0), 1e-12);
        EXPECT_LT(glm::length(ellipses->t1 - scale * circles->t1), 1e-12);
        EXPECT_NEAR(glm::dot(ellipses->normal, ellipses->t1 - ellipses->t0), 0.0, 1e-14);
    }
}

// B5: the wedge of a vertical edge that stands on the plane.
TEST_F(Plateau, WedgeOfAVerticalEdgeIsExactWithEllipsesAndTooNarrowWithCircles) {
    for (const double theta : {0.3, 0.9, 1.2}) {
        const double alpha = 0.1;
        const double exact = std::asin(std::sin(alpha) / std::sin(theta));
        const Ellipse ellipse = *ball_image(1.0, theta, alpha);
        // Tangent from the foot of the edge to the ellipse of its top; smaller ones lie in the same wedge.
        const double centre = std::tan(theta) + ellipse.shift_m;
        const double a2 = ellipse.along_m * ellipse.along_m, b2 = ellipse.across_m * ellipse.across_m;
        EXPECT_NEAR(std::atan(std::sqrt(b2 / (centre * centre - a2))), exact, 4e-9);
        const double circle = std::asin(std::tan(alpha) / std::tan(theta));
        EXPECT_NEAR(std::sin(circle) / std::sin(exact), std::cos(theta) / std::cos(alpha), 1e-12);
    }
}

// 2.11.5: what a trimmed cone leaves out is covered by the sheets or by the neighbours' cones.
TEST_F(Plateau, TrimmedConesCoverAllThatTheWholeOnesShow) {
    int hidden = 0;
    for (int i = 0; i < 3000; ++i) {
        const double sector = uniform(0.2, 2 * kPi - 0.2);
        const double r = uniform(0.1, 1.0), ra = uniform(0.05, 1.0), rb = uniform(0.05, 1.0);
        const double da = uniform(0.3, 3.0), db = uniform(0.3, 3.0);
        const double ga = (r - ra) / da, gb = (r - rb) / db;
        const Sector kept = visible_sector(sector, ga, gb, r, da, db);
        hidden += kept.empty() ? 1 : 0;
        // Clockwise from the edge a: its outer side is on the right of "vertex -> neighbour a".
        const glm::dvec2 end_a{da, 0.0}, end_b{db * std::cos(sector), -db * std::sin(sector)};
        for (int k = 0; k < 40; ++k) {
            const double angle = sector * (k + 0.5) / 40.0;
            if (angle >= kept.from_rad && angle <= kept.to_rad) {
                continue;
            }
            for (const double lambda : {0.2, 0.6, 0.95}) {
                const glm::dvec2 p = lambda * r * glm::dvec2{std::cos(angle), -std::sin(angle)};
                const double others =
                    std::min({bilinear(p, {{0, 0}, end_a, r, ra}), bilinear(p, {end_b, {0, 0}, rb, r}),
                              glm::length(p - end_a) / ra, glm::length(p - end_b) / rb});
                EXPECT_LE(others, lambda + 1e-9) << sector << " " << ga << " " << gb << " " << angle;
            }
        }
    }
    EXPECT_GT(hidden, 100);
}

// B4: the light in the middle over a disc: V on the axis and the radius of the true umbra.
TEST_F(Plateau, LensIsTheOverlapOfTwoDiscs) {
    EXPECT_NEAR(lens(0.0, 0.3, 0.5), kPi * 0.09, 1e-12);
    EXPECT_EQ(lens(0.9, 0.3, 0.5), 0.0);
    EXPECT_NEAR(lens(0.7, 0.7, 0.7), 2 * 0.49 * std::acos(0.5) - 0.35 * std::sqrt(4 * 0.49 - 0.49), 1e-12);
}

}  // namespace
}  // namespace penumbra::plateau
