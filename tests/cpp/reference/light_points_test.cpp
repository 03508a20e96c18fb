#include "reference/light_points.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>

#include "reference/sampling.h"
#include "test_scenes.h"

namespace penumbra {
namespace {

using test::kPi;

struct LightPoint {
    glm::dvec3 origin;  ///< where the ray starts, anchor units = metres here
    glm::dvec3 direction;
    double end;
    double weight;
};

/// Calls `use` for side * side jittered samples of the light as seen from p. The frame is the identity.
void sample(const Light& light, const glm::dvec3& p, const glm::dvec3& n, int side,
            const std::function<void(const LightPoint&)>& use, float offset = 0.0F) {
    const LightPoints points{light, AnchorFrame{}};
    ReceiverLanes receivers{};
    for (int i = 0; i < kRayLanes; ++i) {
        receivers.px[i] = static_cast<float>(p.x);
        receivers.py[i] = static_cast<float>(p.y);
        receivers.pz[i] = static_cast<float>(p.z);
        receivers.nx[i] = static_cast<float>(n.x);
        receivers.ny[i] = static_cast<float>(n.y);
        receivers.nz[i] = static_cast<float>(n.z);
        receivers.sx[i] = receivers.nx[i];
        receivers.sy[i] = receivers.ny[i];
        receivers.sz[i] = receivers.nz[i];
        receivers.offset[i] = offset;
    }
    const std::uint32_t key = sequence_key(11, sequence_base(3, 0));
    ASSERT_EQ(side * side % kRayLanes, 0);
    for (int first = 0; first < side * side; first += kRayLanes) {
        SampleLanes samples;
        for (int i = 0; i < kRayLanes; ++i) {
            float a;
            float b;
            uniform_pair(key, static_cast<std::uint32_t>(first + i), a, b);
            samples.u[i] = (static_cast<float>((first + i) % side) + a) / static_cast<float>(side);
            samples.v[i] = (static_cast<float>((first + i) / side) + b) / static_cast<float>(side);
        }
        RayPacket rays{};
        alignas(64) float weight[kRayLanes];
        points.aim(receivers, samples, rays, weight);
        for (int i = 0; i < kRayLanes; ++i) {
            use({{rays.org_x[i], rays.org_y[i], rays.org_z[i]},
                 {rays.dir_x[i], rays.dir_y[i], rays.dir_z[i]},
                 rays.tfar[i],
                 weight[i]});
        }
    }
}

constexpr int kSide = 256;
constexpr double kSamples = static_cast<double>(kSide) * kSide;

/// E for unit radiance by the sampler.
double irradiance(const Light& light, const glm::dvec3& p, const glm::dvec3& n) {
    double sum = 0.0;
    sample(light, p, n, kSide, [&](const LightPoint& s) { sum += s.weight; });
    return sum / kSamples * LightPoints{light, AnchorFrame{}}.scale(p);
}

/// Lambert's formula for a polygon wholly above the horizon.
double polygon_irradiance(const std::vector<glm::dvec3>& corners, const glm::dvec3& p, const glm::dvec3& n) {
    double sum = 0.0;
    for (std::size_t i = 0; i < corners.size(); ++i) {
        const glm::dvec3 a = glm::normalize(corners[i] - p);
        const glm::dvec3 b = glm::normalize(corners[(i + 1) % corners.size()] - p);
        const glm::dvec3 c = glm::cross(a, b);
        sum += std::acos(glm::dot(a, b)) * glm::dot(c, n) / glm::length(c);
    }
    return 0.5 * std::abs(sum);
}

const glm::dvec3 kUp{0, 0, 1};

// Jittered smooth integrands converge like 1 / samples: 1e-4 relative is generous for 65,536 of them.
constexpr double kClose = 1e-4;

TEST(LightPoints, OfARectangleHaveItsMoments) {
    const Light light = test::rectangle({1, 2, 5}, 2.0, 0.5);
    glm::dvec3 mean{0.0};
    double uu = 0.0;
    double vv = 0.0;
    sample(light, {0, 0, 0}, kUp, kSide, [&](const LightPoint& s) {
        const glm::dvec3 target = s.origin + s.direction;
        EXPECT_NEAR(target.z, 5.0, 2e-4);
        mean += target / kSamples;
        uu += (target.x - 1.0) * (target.x - 1.0) / kSamples;
        vv += (target.y - 2.0) * (target.y - 2.0) / kSamples;
    });
    EXPECT_NEAR(mean.x, 1.0, kClose);
    EXPECT_NEAR(mean.y, 2.0, kClose);
    EXPECT_NEAR(uu, 4.0 / 3.0, kClose);
    EXPECT_NEAR(vv, 0.25 / 3.0, kClose);
}

TEST(LightPoints, OfAnEllipseHaveItsMomentsAndStayInside) {
    const Light light = test::ellipse({1, 2, 5}, 2.0, 0.5);
    double uu = 0.0;
    double vv = 0.0;
    double fourth = 0.0;
    sample(light, {0, 0, 0}, kUp, kSide, [&](const LightPoint& s) {
        const glm::dvec3 target = s.origin + s.direction;
        const double x = (target.x - 1.0) / 2.0;
        const double y = (target.y - 2.0) / 0.5;
        const double r2 = x * x + y * y;
        EXPECT_LE(r2, 1.0 + 1e-5);
        uu += x * x / kSamples;
        vv += y * y / kSamples;
        fourth += r2 * r2 / kSamples;
    });
    EXPECT_NEAR(uu, 0.25, kClose);
    EXPECT_NEAR(vv, 0.25, kClose);
    EXPECT_NEAR(fourth, 1.0 / 3.0, kClose);
}

TEST(LightPoints, OfAPolygonHaveItsCentroidAndSecondMoments) {
    // Right triangle: centroid (1, 2/3); E[x^2] = 3^2 / 6, E[y^2] = 2^2 / 6 about the right angle.
    const Light light = test::polygon({{0, 0, 4}, {0, 2, 4}, {3, 0, 4}});
    glm::dvec3 mean{0.0};
    double xx = 0.0;
    double yy = 0.0;
    sample(light, {0, 0, 0}, kUp, kSide, [&](const LightPoint& s) {
        const glm::dvec3 target = s.origin + s.direction;
        mean += target / kSamples;
        xx += target.x * target.x / kSamples;
        yy += target.y * target.y / kSamples;
    });
    EXPECT_NEAR(mean.x, 1.0, kClose * 3);
    EXPECT_NEAR(mean.y, 2.0 / 3.0, kClose * 2);
    EXPECT_NEAR(xx, 1.5, kClose * 9);
    EXPECT_NEAR(yy, 4.0 / 6.0, kClose * 4);
}

TEST(LightPoints, OfAPolygonWithEightCornersAreUniform) {
    std::vector<glm::dvec3> corners;
    for (int i = 0; i < 8; ++i) {
        corners.emplace_back(std::cos(-kPi * i / 4), std::sin(-kPi * i / 4), 3.0);
    }
    double xx = 0.0;
    double right = 0.0;
    sample(test::polygon(corners), {0, 0, 0}, kUp, kSide, [&](const LightPoint& s) {
        const glm::dvec3 target = s.origin + s.direction;
        xx += target.x * target.x / kSamples;
        right += target.x > 0.0 ? 1.0 / kSamples : 0.0;
    });
    // Regular octagon of circumradius 1: E[x^2] = (2 + cos(pi/4)) / 12.
    EXPECT_NEAR(xx, (2.0 + std::cos(kPi / 4)) / 12.0, kClose);
    EXPECT_NEAR(right, 0.5, 2e-3);
}

TEST(LightPoints, OfALineAreUniformByLength) {
    const Light light = test::line({0, 0, 2}, {0, 3, 0});
    double yy = 0.0;
    sample(light, {0, 0, 0}, kUp, kSide, [&](const LightPoint& s) {
        const glm::dvec3 target = s.origin + s.direction;
        EXPECT_NEAR(target.x, 0.0, 1e-6);
        yy += target.y * target.y / kSamples;
    });
    EXPECT_NEAR(yy, 3.0, 9 * kClose);
}

TEST(LightPoints, OfASphereLieOnItsNearSideUniformInSolidAngle) {
    const glm::dvec3 centre{1, -2, 3};
    const double radius = 0.7;
    const Light light = test::point_light(centre, radius);
    const double d = glm::length(centre);
    const double cos_max = std::sqrt(1.0 - radius * radius / (d * d));
    double mean_cosine = 0.0;
    glm::dvec3 mean{0.0};
    sample(light, {0, 0, 0}, kUp, kSide, [&](const LightPoint& s) {
        const glm::dvec3 end = s.origin + s.direction * s.end;
        EXPECT_NEAR(glm::length(end - centre), radius, 2e-5);
        const double cosine = glm::dot(s.direction, centre) / d;
        EXPECT_GE(cosine, cos_max - 1e-6);
        EXPECT_LE(s.end, std::sqrt(d * d - radius * radius) + 1e-4) << "beyond the horizon of the sphere";
        mean_cosine += cosine / kSamples;
        mean += s.direction / kSamples;
    });
    EXPECT_NEAR(mean_cosine, 0.5 * (1.0 + cos_max), kClose);  // uniform in cosine
    EXPECT_NEAR(glm::length(glm::cross(mean, centre / d)), 0.0, kClose);
}

TEST(LightPoints, SeenFromInsideASphereGoAllAroundAndEndOnIt) {
    const Light light = test::point_light({0.2, 0.1, -0.3}, 1.0);
    glm::dvec3 mean{0.0};
    glm::dvec3 squares{0.0};
    sample(light, {0, 0, 0}, kUp, kSide, [&](const LightPoint& s) {
        EXPECT_NEAR(glm::length(s.origin + s.direction * s.end - glm::dvec3(0.2, 0.1, -0.3)), 1.0, 1e-5);
        mean += s.direction / kSamples;
        squares += s.direction * s.direction / kSamples;
    });
    for (int axis = 0; axis < 3; ++axis) {
        EXPECT_NEAR(mean[axis], 0.0, kClose);
        EXPECT_NEAR(squares[axis], 1.0 / 3.0, kClose);
    }
}

TEST(LightPoints, AtTheCentreOfASphereAreFinite) {
    for (const double radius : {0.0, 1.0}) {
        sample(test::point_light({0, 0, 0}, radius), {0, 0, 0}, kUp, 4, [&](const LightPoint& s) {
            EXPECT_NEAR(glm::length(s.direction), 1.0, 1e-6);
            EXPECT_NEAR(s.end, radius, 1e-6);
        });
    }
}

TEST(LightPoints, OfAPointWithoutRadiusAreThatPointFromAnyDistance) {
    for (double distance = 1e-6; distance < 1e7; distance *= 10.0) {
        const glm::dvec3 at = glm::normalize(glm::dvec3(1, 2, 3)) * distance;
        sample(test::point_light(at, 0.0), {0, 0, 0}, kUp, 4, [&](const LightPoint& s) {
            EXPECT_LT(glm::length(s.direction * s.end - at), 4e-6 * distance) << "distance " << distance;
        });
    }
}

TEST(LightPoints, OfASunFillItsConeUniformlyWithoutEnd) {
    for (const double angle : {0.0, 1e-4, 0.0093, 0.5, kPi}) {
        const glm::dvec3 towards = glm::normalize(glm::dvec3(0.3, -0.4, 0.8));
        const Light light = test::sun(-towards, angle);
        const double cos_max = std::cos(0.5 * angle);
        double mean = 0.0;
        sample(light, {5, 6, 7}, kUp, kSide, [&](const LightPoint& s) {
            const double cosine = glm::dot(s.direction, towards);
            EXPECT_NEAR(glm::length(s.direction), 1.0, 1e-6);
            EXPECT_GE(cosine, cos_max - 1e-6);
            EXPECT_TRUE(std::isinf(s.end));
            mean += cosine / kSamples;
        });
        EXPECT_NEAR(mean, 0.5 * (1.0 + cos_max), kClose) << "angle " << angle;
    }
}

TEST(IrradianceWeight, OfAPolygonGivesLambertsFormula) {
    const std::vector<glm::dvec3> corners{{-1, -1, 2}, {-0.5, 1.5, 2}, {1, 1, 2}, {1.2, -0.5, 2}};
    for (const glm::dvec3 n : {kUp, glm::normalize(glm::dvec3(0.3, 0.2, 1))}) {
        const glm::dvec3 p{0.4, -0.2, 0};
        const double expected = polygon_irradiance(corners, p, n);
        EXPECT_NEAR(irradiance(test::polygon(corners), p, n) / expected, 1.0, 3e-4);
    }
    const Light light = test::rectangle({0.5, 1, 2}, 1.0, 0.75);
    const std::vector<glm::dvec3> rectangle{{-0.5, 0.25, 2}, {-0.5, 1.75, 2}, {1.5, 1.75, 2}, {1.5, 0.25, 2}};
    EXPECT_NEAR(irradiance(light, {0, 0, 0}, kUp) / polygon_irradiance(rectangle, {0, 0, 0}, kUp), 1.0, kClose);
}

TEST(IrradianceWeight, OfADiscOnAxisGivesTheViewFactor) {
    for (const double radius : {0.01, 1.0, 10.0}) {
        const double expected = kPi * radius * radius / (radius * radius + 4.0);
        EXPECT_NEAR(irradiance(test::ellipse({0, 0, 2}, radius, radius), {0, 0, 0}, kUp) / expected, 1.0, 3e-4)
            << "radius " << radius;
    }
}

TEST(IrradianceWeight, OfASphereAboveTheHorizonGivesSineSquaredTimesCosine) {
    const glm::dvec3 centre{1, 0.5, 3};
    const double radius = 0.8;
    const double d2 = glm::dot(centre, centre);
    const double expected = kPi * radius * radius / d2 * centre.z / std::sqrt(d2);
    EXPECT_NEAR(irradiance(test::point_light(centre, radius), {0, 0, 0}, kUp) / expected, 1.0, kClose);
}

TEST(IrradianceWeight, OfASphereCutByTheHorizonCountsTheUpperHalf) {
    // Centre on the horizon: the upper half of the cone. E = integral of the cosine over half a cap of half angle a
    // about a horizontal axis: (2 a - sin 2a) / 2 ... from the projected half disc: E = a - sin(a) cos(a).
    const double radius = 1.0;
    const double d = 2.0;
    const double a = std::asin(radius / d);
    EXPECT_NEAR(irradiance(test::point_light({d, 0, 0}, radius), {0, 0, 0}, kUp), a - std::sin(a) * std::cos(a), 2e-4);
}

TEST(IrradianceWeight, InsideASphereIsPi) {
    EXPECT_NEAR(irradiance(test::point_light({0.2, 0.1, 0.3}, 1.0), {0, 0, 0}, kUp), kPi, 3e-4);
}

TEST(IrradianceWeight, OfASunIsItsSineSquaredTimesCosine) {
    const double angle = 0.4;
    const glm::dvec3 towards = glm::normalize(glm::dvec3(0.3, -0.4, 0.8));
    const double s = std::sin(0.5 * angle);
    EXPECT_NEAR(irradiance(test::sun(-towards, angle), {0, 0, 0}, kUp), kPi * s * s * towards.z, 1e-5);
}

TEST(IrradianceWeight, OfALineOverheadGivesTheClosedForm) {
    // Segment at height h along y, half length a, receiver below its middle, normal up:
    // integral of (h/d) (h/d) / d^2 dy = atan(a/h) / h + a / (h^2 + a^2).
    const double h = 1.5;
    const double a = 2.0;
    const double expected = std::atan(a / h) / h + a / (h * h + a * a);
    EXPECT_NEAR(irradiance(test::line({0, 0, h}, {0, a, 0}), {0, 0, 0}, kUp) / expected, 1.0, kClose);
}

TEST(IrradianceWeight, BehindAFlatLightOrBelowTheHorizonIsZero) {
    EXPECT_EQ(irradiance(test::rectangle({0, 0, -2}, 1, 1), {0, 0, 0}, -kUp), 0.0);
    EXPECT_EQ(irradiance(test::rectangle({0, 0, 2}, 1, 1), {0, 0, 0}, -kUp), 0.0);
    EXPECT_EQ(irradiance(test::point_light({0, 0, 2}, 1), {0, 0, 0}, -kUp), 0.0);
}

TEST(LightPoints, LeaveTheSurfaceOnTheSideTheyGoTo) {
    const float offset = 1e-3F;
    for (const double side : {-1.0, 1.0}) {
        sample(
            test::point_light({3, 0, 2 * side}, 0.1), {0, 0, 0}, kUp, 4,
            [&](const LightPoint& s) { EXPECT_FLOAT_EQ(static_cast<float>(s.origin.z * side), offset); }, offset);
    }
}

TEST(LightPoints, KnowWhenOneRayTellsAll) {
    EXPECT_TRUE((LightPoints{test::point_light({0, 0, 1}, 0.0), AnchorFrame{}}.single_point()));
    EXPECT_TRUE((LightPoints{test::sun({0, 0, -1}, 0.0), AnchorFrame{}}.single_point()));
    EXPECT_FALSE((LightPoints{test::sun({0, 0, -1}, 0.01), AnchorFrame{}}.single_point()));
    EXPECT_TRUE((LightPoints{test::line({0, 0, 1}, {1, 0, 0}), AnchorFrame{}}.one_dimensional()));
    EXPECT_TRUE((LightPoints{test::rectangle({0, 0, 1}, 0.0, 1.0), AnchorFrame{}}.one_dimensional()));
    EXPECT_FALSE((LightPoints{test::rectangle({0, 0, 1}, 1.0, 1.0), AnchorFrame{}}.one_dimensional()));
}

}  // namespace
}  // namespace penumbra
