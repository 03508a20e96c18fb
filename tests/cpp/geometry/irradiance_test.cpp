#include "geometry/irradiance.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>
#include <vector>

#include "geometry/contour.h"

namespace penumbra {
namespace {

constexpr double kPi = std::numbers::pi;

/// Nodes and weights on [-1, 1] [Golub1969], by Newton on the Legendre polynomial.
struct Gauss {
    std::vector<double> x;
    std::vector<double> w;
    explicit Gauss(int n) {
        for (int i = 0; i < n; ++i) {
            double z = std::cos(kPi * (i + 0.75) / (n + 0.5));
            double slope = 1.0;
            for (int step = 0; step < 100; ++step) {
                double p0 = 1.0;
                double p1 = z;
                for (int k = 2; k <= n; ++k) {
                    const double p2 = ((2 * k - 1) * z * p1 - (k - 1) * p0) / k;
                    p0 = p1;
                    p1 = p2;
                }
                slope = n * (z * p1 - p0) / (z * z - 1.0);
                const double next = z - p1 / slope;
                if (std::abs(next - z) < 1e-16) {
                    break;
                }
                z = next;
            }
            x.push_back(z);
            w.push_back(2.0 / ((1.0 - z * z) * slope * slope));
        }
    }
};

/// The integrand cos cos' / r^2 of a patch of a plane with normal m.
double kernel(const glm::dvec3& r, const glm::dvec3& n, const glm::dvec3& m) {
    const double r2 = glm::dot(r, r);
    return std::max(0.0, glm::dot(n, r)) * std::abs(glm::dot(m, r)) / (r2 * r2);
}

double integrate_rectangle(const glm::dvec3& c, const glm::dvec3& u, const glm::dvec3& v, const glm::dvec3& n,
                           int order) {
    const Gauss gauss{order};
    const glm::dvec3 area = glm::cross(u, v);
    double sum = 0.0;
    for (int i = 0; i < order; ++i) {
        for (int j = 0; j < order; ++j) {
            sum += gauss.w[i] * gauss.w[j] * kernel(c + gauss.x[i] * u + gauss.x[j] * v, n, area);
        }
    }
    return sum;
}

double integrate_ellipse(const glm::dvec3& c, const glm::dvec3& u, const glm::dvec3& v, const glm::dvec3& n) {
    const Gauss gauss{48};
    const glm::dvec3 area = glm::cross(u, v);
    constexpr int kTurns = 256;
    double sum = 0.0;
    for (int i = 0; i < 48; ++i) {
        const double r = 0.5 + 0.5 * gauss.x[i];
        for (int j = 0; j < kTurns; ++j) {
            const double t = 2.0 * kPi * j / kTurns;
            sum += 0.5 * gauss.w[i] * r * kernel(c + r * std::cos(t) * u + r * std::sin(t) * v, n, area);
        }
    }
    return sum * 2.0 * kPi / kTurns;
}

/// An ellipse as a polygon of 2^12 corners, extrapolated in the squared step: an oracle that clips at the horizon.
double ellipse_by_polygon(const glm::dvec3& c, const glm::dvec3& u, const glm::dvec3& v, const glm::dvec3& n) {
    const auto value = [&](int corners) {
        const double step = 2.0 * kPi / corners;
        const double reach = std::sqrt(step / std::sin(step));  // equal area
        std::vector<glm::dvec3> offsets;
        for (int i = 0; i < corners; ++i) {
            offsets.push_back(reach * (std::cos(i * step) * u + std::sin(i * step) * v));
        }
        return polygon_irradiance(c, offsets, n);
    };
    return value(8192);
}

std::vector<glm::dvec3> rectangle_offsets(const glm::dvec3& u, const glm::dvec3& v) {
    return {-u - v, u - v, u + v, v - u};
}

struct Random {
    std::mt19937 engine;
    explicit Random(unsigned seed) : engine{seed} {}
    double in(double low, double high) { return std::uniform_real_distribution<double>{low, high}(engine); }
    glm::dvec3 vector() { return {in(-1.0, 1.0), in(-1.0, 1.0), in(-1.0, 1.0)}; }
    glm::dvec3 unit() {
        while (true) {
            const glm::dvec3 v = vector();
            if (glm::length(v) > 0.1 && glm::length(v) < 1.0) {
                return glm::normalize(v);
            }
        }
    }
};

Light rectangle(const glm::dvec3& position, const glm::dvec3& u, const glm::dvec3& v) {
    Light light;
    light.kind = LightKind::Rectangle;
    light.position_ws = position;
    light.half_u_ws = u;
    light.half_v_ws = v;
    light.direction_ws = -glm::normalize(glm::cross(u, v));
    return light;
}

TEST(PolygonIrradiance, MatchesTheFormFactorOfAParallelRectangle) {
    // Corner above the receiver, sides X and Y at distance 1; pi times the form factor.
    for (const double x : {0.01, 0.3, 1.0, 7.0, 300.0}) {
        for (const double y : {0.02, 0.5, 2.0, 50.0}) {
            const double a = std::sqrt(1.0 + x * x);
            const double b = std::sqrt(1.0 + y * y);
            const double expected = 0.5 * (x / a * std::atan(y / a) + y / b * std::atan(x / b));
            const double value = polygon_irradiance({0.5 * x, 0.5 * y, 1.0},
                                                    rectangle_offsets({0.5 * x, 0, 0}, {0, 0.5 * y, 0}), {0, 0, 1});
            EXPECT_NEAR(value / expected, 1.0, 1e-13) << x << ' ' << y;
        }
    }
}

TEST(PolygonIrradiance, AgreesWithQuadratureAboveTheHorizon) {
    Random random{1};
    double worst = 0.0;
    for (int i = 0; i < 300; ++i) {
        const glm::dvec3 c = 3.0 * random.unit();
        const glm::dvec3 u = 0.7 * random.vector();
        const glm::dvec3 v = 0.7 * random.vector();
        const glm::dvec3 n = glm::normalize(c / 3.0 + 0.3 * random.vector());
        double lowest = 1.0;
        for (const glm::dvec3& offset : rectangle_offsets(u, v)) {
            lowest = std::min(lowest, glm::dot(n, c + offset));
        }
        const double height = std::abs(glm::dot(glm::cross(u, v), c));
        if (lowest > 0.0 && height > 1e-3) {
            const double expected = integrate_rectangle(c, u, v, n, 40);
            const double value = polygon_irradiance(c, rectangle_offsets(u, v), n);
            worst = std::max(worst, std::abs(value - expected) / expected);
        }
    }
    EXPECT_LT(worst, 1e-11);
}

TEST(PolygonIrradiance, ClipsAtTheHorizonLikeTheExplicitlyClippedPolygon) {
    // The horizon of a receiver that faces +x cuts the square in its middle.
    const double half = polygon_irradiance({0, 0, 1}, rectangle_offsets({1, 0, 0}, {0, 1, 0}), {1, 0, 0});
    const double right = polygon_irradiance({0.5, 0, 1}, rectangle_offsets({0.5, 0, 0}, {0, 1, 0}), {1, 0, 0});
    EXPECT_NEAR(half, right, 1e-15);
    EXPECT_NEAR(half, integrate_rectangle({0.5, 0, 1}, {0.5, 0, 0}, {0, 1, 0}, {1, 0, 0}, 40), 1e-14);
}

TEST(PolygonIrradiance, OfAHugePlaneTendsToPi) {
    EXPECT_NEAR(polygon_irradiance({0, 0, 1}, rectangle_offsets({1e9, 0, 0}, {0, 1e9, 0}), {0, 0, 1}), kPi, 1e-14);
    EXPECT_NEAR(polygon_irradiance({0, 0, 1}, rectangle_offsets({1e9, 0, 0}, {0, 1e9, 0}), {1, 0, 0}), 0.5 * kPi, 1e-8)
        << "half of it lies below the horizon";
}

TEST(PolygonIrradiance, KeepsItsDigitsOverTwelveDecadesOfSize) {
    const glm::dvec3 n = glm::normalize(glm::dvec3{0.3, -0.2, 1.0});
    const glm::dvec3 c{0.4, 0.7, 1.0};
    const glm::dvec3 u{0.6, 0.1, 0.2};
    const glm::dvec3 v{-0.1, 0.5, 0.1};
    const double point = 4.0 * kernel(c, n, glm::cross(u, v));
    for (int decade = 0; decade <= 12; ++decade) {
        const double s = std::pow(10.0, -decade);
        const double value = polygon_irradiance(c, rectangle_offsets(s * u, s * v), n) / (s * s);
        if (decade >= 1) {
            EXPECT_NEAR(value / integrate_rectangle(c, s * u, s * v, n, 24) * (s * s), 1.0, 3e-14) << decade;
        }
        if (decade >= 8) {
            EXPECT_NEAR(value / point, 1.0, 1e-13) << decade;
        }
    }
}

TEST(PolygonIrradiance, StableAndPlainFormsMeetWhereTheyChange) {
    // The contour switches form at radius / distance = 0.2; both sides of it must agree with quadrature.
    for (const double r : {0.199, 0.1999999, 0.2000001, 0.201}) {
        const double side = r / std::sqrt(2.0);
        const glm::dvec3 n = glm::normalize(glm::dvec3{0.5, 0.1, 1.0});
        const double value = polygon_irradiance({0, 0, 1}, rectangle_offsets({side, 0, 0}, {0, side, 0}), n);
        const double expected = integrate_rectangle({0, 0, 1}, {side, 0, 0}, {0, side, 0}, n, 24);
        EXPECT_NEAR(value / expected, 1.0, 1e-14) << r;
    }
}

TEST(EllipseIrradiance, MatchesTheFormFactorOfADiscOnItsAxis) {
    for (const double r : {1e-6, 0.01, 1.0, 100.0, 1e8}) {
        EXPECT_NEAR(ellipse_irradiance({0, 0, 1}, {r, 0, 0}, {0, r, 0}, {0, 0, 1}) / (kPi * r * r / (1.0 + r * r)), 1.0,
                    1e-14);
    }
}

TEST(EllipseIrradiance, AgreesWithQuadratureAboveTheHorizon) {
    Random random{2};
    double worst = 0.0;
    int tested = 0;
    for (int i = 0; i < 2000 && tested < 200; ++i) {
        const glm::dvec3 c = 2.5 * random.unit();
        const glm::dvec3 u = random.vector();
        const glm::dvec3 v = random.vector();  // not perpendicular: conjugate half axes
        const glm::dvec3 n = glm::normalize(c / 2.5 + 0.4 * random.vector());
        const double reach = std::hypot(glm::dot(n, u), glm::dot(n, v));
        const double area = glm::length(glm::cross(u, v));
        if (glm::dot(n, c) > reach && std::abs(glm::dot(glm::cross(u, v), c)) > 0.05 * area) {
            const double expected = integrate_ellipse(c, u, v, n);
            worst = std::max(worst, std::abs(ellipse_irradiance(c, u, v, n) - expected) / expected);
            ++tested;
        }
    }
    EXPECT_EQ(tested, 200);
    EXPECT_LT(worst, 1e-10);
}

TEST(EllipseIrradiance, ClippedByTheHorizonMatchesAFinePolygon) {
    Random random{3};
    double worst = 0.0;
    for (int i = 0; i < 500; ++i) {
        const glm::dvec3 c = random.in(0.05, 3.0) * random.unit();
        const glm::dvec3 u = random.vector();
        const glm::dvec3 v = random.vector();
        const glm::dvec3 n = random.unit();
        worst = std::max(worst, std::abs(ellipse_irradiance(c, u, v, n) - ellipse_by_polygon(c, u, v, n)));
    }
    EXPECT_LT(worst, 1e-6) << "the polygon's own error";
}

TEST(EllipseIrradiance, ClippedFormsMeetAtAllSizesWhereTheHorizonCuts) {
    // The horizon through the centre of a symmetric disc keeps half of it: the two halves of the normal's tilt.
    for (int decade = -8; decade <= 4; ++decade) {
        const double r = std::pow(10.0, decade) * 1.37;
        // n = x: integral of x / (1 + x^2 + y^2)^2 over x > 0, in polar form: atan(r) - r / (1 + r^2).
        const double expected = r < 0.01
                                    ? 2.0 * (r * r * r / 3.0 - 2.0 * std::pow(r, 5) / 5.0 + 3.0 * std::pow(r, 7) / 7.0)
                                    : std::atan(r) - r / (1.0 + r * r);
        EXPECT_NEAR(ellipse_irradiance({0, 0, 1}, {r, 0, 0}, {0, r, 0}, {1, 0, 0}) / expected, 1.0, 1e-11) << r;
        EXPECT_NEAR(cone_irradiance(r / std::hypot(1.0, r), 1.0 / std::hypot(1.0, r), {0, 0, 1}, {1, 0, 0}) / expected,
                    1.0, 1e-11)
            << r;
    }
}

TEST(EllipseIrradiance, IsContinuousWhereTheHorizonStartsToCut) {
    for (const double stretch : {1.0, 0.3, 1e-3}) {
        const glm::dvec3 u{0.8, 0, 0};
        const glm::dvec3 v{0, 0.8 * stretch, 0};
        for (const double r : {0.8, -0.8}) {
            const double limit = std::atan2(r, 1.0);
            const auto at = [&](double tilt) {
                return ellipse_irradiance({0, 0, 1}, u, v, {std::cos(limit + tilt), 0.0, std::sin(limit + tilt)});
            };
            EXPECT_NEAR(at(1e-9), at(-1e-9), 1e-8 * stretch);
            EXPECT_NEAR(at(1e-13), at(-1e-13), 1e-11 * stretch);
        }
    }
}

TEST(EllipseIrradiance, EqualsTheRectangleLimitFromAbove) {
    // Close above a disc the whole hemisphere is the disc.
    for (const double h : {1e-2, 1e-6, 1e-12}) {
        EXPECT_NEAR(ellipse_irradiance({0.3, 0.1, h}, {2, 0, 0}, {0, 1, 0}, {0, 0, 1}), kPi, 10.0 * h);
    }
    // Close above its plane but beside it: nothing is left, without NaN.
    for (const double h : {1e-2, 1e-6, 1e-12, 1e-300}) {
        const double value = ellipse_irradiance({5.0, 0.1, h}, {2, 0, 0}, {0, 1, 0}, {0, 0, 1});
        EXPECT_TRUE(value >= 0.0 && value < h * h + 1e-300) << h << ' ' << value;
    }
}

TEST(ConeIrradiance, OfASphereMatchesQuadratureWhereTheHorizonCuts) {
    // Integral over directions of the cone: the azimuth in closed form, the polar angle split where the horizon starts
    // to cut and substituted so that the square root there is smooth.
    const Gauss gauss{80};
    const auto numeric = [&](double half, double tilt) {
        const auto over_azimuth = [&](double theta) {
            const double up = std::cos(tilt) * std::cos(theta);
            const double across = std::sin(tilt) * std::sin(theta);
            const double open = up >= across ? kPi : up <= -across ? 0.0 : std::acos(-up / across);
            return 2.0 * (up * open + across * std::sin(open)) * std::sin(theta);
        };
        const double split = std::min(half, std::abs(0.5 * kPi - tilt));
        double sum = 0.0;
        for (std::size_t i = 0; i < gauss.x.size(); ++i) {
            const double s = 0.5 + 0.5 * gauss.x[i];
            sum += 0.5 * gauss.w[i] *
                   (split * over_azimuth(split * s) +
                    (half - split) * 2.0 * s * over_azimuth(split + (half - split) * s * s));
        }
        return sum;
    };
    for (const double half : {0.05, 0.3, 1.0, 1.5, 0.5 * kPi}) {
        for (int i = 0; i <= 12; ++i) {
            const double tilt = i * kPi / 12.0;
            const double value = cone_irradiance(std::sin(half), std::max(0.0, std::cos(half)), {0, 0, 1},
                                                 {std::sin(tilt), 0.0, std::cos(tilt)});
            EXPECT_NEAR(value, numeric(half, tilt), 1e-12) << half << ' ' << tilt;
        }
    }
}

TEST(ConeIrradiance, OfAHemisphereOfDirectionsIsTheLune) {
    for (int i = 0; i <= 16; ++i) {
        const double tilt = i * kPi / 16.0;
        EXPECT_NEAR(cone_irradiance(1.0, 0.0, {0, 0, 1}, {std::sin(tilt), 0.0, std::cos(tilt)}),
                    0.5 * kPi * (1.0 + std::cos(tilt)), 1e-14);
    }
}

TEST(LineIrradiance, AgreesWithQuadrature) {
    Random random{5};
    const Gauss gauss{60};
    double worst = 0.0;
    for (int i = 0; i < 300; ++i) {
        const glm::dvec3 c = random.in(1.5, 4.0) * random.unit();
        const glm::dvec3 half = random.vector();
        const glm::dvec3 n = glm::normalize(c / 4.0 + 0.1 * random.vector());
        const glm::dvec3 facing = random.unit();
        const glm::dvec3 along = glm::normalize(half);
        const glm::dvec3 flat = glm::normalize(facing - glm::dot(facing, along) * along);
        if (glm::dot(n, c) < std::abs(glm::dot(n, half))) {
            continue;
        }
        double cylinder = 0.0;
        double strip = 0.0;
        for (std::size_t k = 0; k < gauss.x.size(); ++k) {
            const glm::dvec3 r = c + gauss.x[k] * half;
            const double r2 = glm::dot(r, r);
            const double sine = glm::length(glm::cross(along, r)) / std::sqrt(r2);
            const double common = gauss.w[k] * glm::length(half) * glm::dot(n, r) / std::sqrt(r2) / r2;
            cylinder += common * sine;
            strip += common * std::max(0.0, -glm::dot(flat, r) / std::sqrt(r2));
        }
        worst = std::max(worst, std::abs(line_irradiance(c, half, n) - cylinder) / cylinder);
        worst = std::max(worst, std::abs(line_irradiance(c, half, n, &flat) - strip) / cylinder);
    }
    EXPECT_LT(worst, 1e-10);
}

TEST(LineIrradiance, OfAnEndlessLineIsHalfPiOverDistance) {
    // Integral of h^2 / r^4 over the line at distance h: pi / (2 h).
    for (const double h : {1e-4, 1.0, 1e4}) {
        EXPECT_NEAR(line_irradiance({0, 0, h}, {1e12 * h, 0, 0}, {0, 0, 1}) * h, 0.5 * kPi, 1e-11);
    }
}

TEST(LineIrradiance, ClippedByTheHorizonKeepsTheUpperHalf) {
    const double whole = line_irradiance({1, 0, 0}, {0, 0, 2}, glm::normalize(glm::dvec3{1, 0, 0.5}));
    const double up = line_irradiance({1, 0, 0.75}, {0, 0, 1.25}, glm::normalize(glm::dvec3{1, 0, 2}));
    const double cut = line_irradiance({1, 0, 0}, {0, 0, 2}, glm::normalize(glm::dvec3{1, 0, 2}));
    EXPECT_NEAR(cut, up, 1e-14);
    EXPECT_GT(whole, 0.0);
}

TEST(LineIrradiance, IsTheLimitOfANarrowRectangle) {
    const glm::dvec3 n = glm::normalize(glm::dvec3{0.2, 0.5, 1.0});
    const glm::dvec3 c{0.4, 0.1, 1.3};
    const glm::dvec3 facing{0, 0, -1};
    for (const double w : {1e-3, 1e-6}) {
        const double strip = polygon_irradiance(c, rectangle_offsets({1, 0, 0}, {0, 0.5 * w, 0}), n) / w;
        EXPECT_NEAR(strip / line_irradiance(c, {1, 0, 0}, n, &facing), 1.0, w);
    }
}

TEST(Irradiance, OfARectangleShrinksToItsLineAndItsPoint) {
    // Emission x factor is continuous in the light's size; radiometry_test holds the emission to the same limit.
    const glm::dvec3 p{0.3, 0.2, 0.0};
    const glm::dvec3 n{0, 0, 1};
    const Light point = rectangle({0, 0, 2}, {1e-300, 0, 0}, {0, 1e-300, 0});
    Light facing = point;
    facing.half_u_ws = facing.half_v_ws = glm::dvec3{0.0};
    facing.direction_ws = {0, 0, -1};
    const Light tiny = rectangle({0, 0, 2}, {1e-7, 0, 0}, {0, 1e-7, 0});
    EXPECT_EQ(form_of(facing), LightForm::FacingPoint);
    EXPECT_NEAR(irradiance_per_radiance(tiny, p, n) / 4e-14 / irradiance_per_radiance(facing, p, n), 1.0, 1e-13);
}

TEST(Irradiance, AreaLightsShineToOneSideAndNotAlongTheirPlane) {
    const Light light = rectangle({0, 0, 2}, {1, 0, 0}, {0, 1, 0});
    ASSERT_LT(light.direction_ws.z, 0.0);
    EXPECT_GT(irradiance_per_radiance(light, {0, 0, 0}, {0, 0, 1}), 0.0);
    EXPECT_EQ(irradiance_per_radiance(light, {0, 0, 3}, {0, 0, -1}), 0.0);
    EXPECT_EQ(irradiance_per_radiance(light, {5, 0, 2}, {-1, 0, 0}), 0.0);
    EXPECT_EQ(irradiance_per_radiance(light, {0, 0, 2}, {0, 0, 1}), 0.0) << "on the light";
}

TEST(Irradiance, InsideASphereIsPi) {
    Light light;
    light.kind = LightKind::Point;
    light.radius_m = 0.5;
    EXPECT_EQ(irradiance_per_radiance(light, {0, 0, 0.1}, {1, 0, 0}), kPi);
    EXPECT_EQ(irradiance_per_radiance(light, {0, 0, 0}, {1, 0, 0}), kPi);
    EXPECT_NEAR(irradiance_per_radiance(light, {0, 0, 0.5 + 1e-14}, {0, 0, -1}), kPi, 1e-12);
}

TEST(Irradiance, NeverGrowsWhenTheNormalTurnsAway) {
    Random random{6};
    const Light area = rectangle({0.3, 0, 1}, {0.7, 0, 0.1}, {0, 0.9, 0});
    Light disc = area;
    disc.kind = LightKind::Ellipse;
    Light sphere;
    sphere.radius_m = 0.6;
    sphere.position_ws = {0.2, 0.1, 1.0};
    for (const Light& light : {area, disc, sphere}) {
        // Turn away from the direction of the vector irradiance: E falls monotonically to 0.
        const glm::dvec3 p{0.0};
        const auto e = [&](const glm::dvec3& n) { return irradiance_per_radiance(light, p, n); };
        glm::dvec3 best{0, 0, 1};
        for (int i = 0; i < 4000; ++i) {
            const glm::dvec3 n = random.unit();
            if (e(n) > e(best)) {
                best = n;
            }
        }
        glm::dvec3 side = glm::normalize(glm::cross(best, glm::dvec3{0.3, 0.9, 0.1}));
        double last = 1e300;
        for (int i = 4; i <= 64; ++i) {  // the first steps are within the random search's error
            const double t = kPi * i / 64.0;
            const double value = e(std::cos(t) * best + std::sin(t) * side);
            EXPECT_LE(value, last + 1e-14);
            last = value;
        }
        EXPECT_EQ(last, 0.0);
    }
}

TEST(Irradiance, OfAnyLightAnywhereIsFiniteAndBetweenZeroAndItsBound) {
    Random random{8};
    for (int i = 0; i < 20000; ++i) {
        const double scale = std::pow(10.0, random.in(-6.0, 6.0));
        const double size = scale * std::pow(10.0, random.in(-8.0, 4.0));
        const double aspect = std::pow(10.0, random.in(-9.0, 0.0));
        Light light = rectangle(scale * random.vector(), size * random.unit(), size * aspect * random.unit());
        const int kind = i % 4;
        light.kind = kind == 0   ? LightKind::Rectangle
                     : kind == 1 ? LightKind::Ellipse
                     : kind == 2 ? LightKind::Point
                                 : LightKind::Line;
        light.radius_m = size;
        glm::dvec3 p = scale * random.vector();
        if (i % 7 == 0) {
            p = light.position_ws + random.in(-1, 1) * light.half_u_ws;
        } else if (i % 7 == 1) {
            p = light.position_ws + random.in(-2, 2) * light.half_u_ws + random.in(-2, 2) * light.half_v_ws +
                size * std::pow(10.0, random.in(-16.0, -2.0)) * light.direction_ws;
        }
        const double value = irradiance_per_radiance(light, p, random.unit());
        ASSERT_TRUE(std::isfinite(value) && value >= 0.0) << i;
        if (kind != 3 && form_of(light) >= LightForm::Sphere && form_of(light) != LightForm::FacingLine) {
            ASSERT_LE(value, kPi * (1.0 + 1e-12)) << i;
        }
    }
}

TEST(SpotAttenuation, IsASmoothstepOfTheCosine) {
    Light light;
    light.kind = LightKind::Spot;
    light.direction_ws = {0, 0, -1};
    light.half_u_ws = {1, 0, 0};
    light.half_v_ws = {0, 1, 0};
    light.spot_angle_rad = 1.2;
    light.spot_blend = 0.5;
    const double rim = std::cos(0.6);
    const auto at = [&](double cosine) {
        return spot_attenuation(light, 3.0 * glm::dvec3{std::sqrt(1.0 - cosine * cosine), 0.0, -cosine});
    };
    EXPECT_EQ(at(1.0), 1.0);
    EXPECT_EQ(at(rim - 1e-9), 0.0);
    EXPECT_NEAR(at(rim + 0.25 * (1.0 - rim)), 0.5, 1e-12);
    EXPECT_EQ(at(rim + 0.51 * (1.0 - rim)), 1.0);
    EXPECT_EQ(spot_attenuation(light, {0, 0, 1}), 0.0);
    EXPECT_EQ(spot_attenuation(light, {0, 0, 0}), 0.0);
    light.spot_blend = 0.0;
    EXPECT_EQ(at(rim + 1e-9), 1.0);
    EXPECT_EQ(at(rim - 1e-9), 0.0);
    light.spot_stretch = {2.0, 1.0};  // twice as wide along x: the tangent of the rim doubles
    const double rim_x = std::cos(std::atan(2.0 * std::tan(0.6)));
    EXPECT_EQ(at(rim_x + 1e-9), 1.0);
    EXPECT_EQ(at(rim_x - 1e-9), 0.0);
}

}  // namespace
}  // namespace penumbra
