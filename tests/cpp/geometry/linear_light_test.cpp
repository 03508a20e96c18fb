// The oracle of linear light maps against closed forms, linear-light-soft-shadow-maps sections 2 to 4.
#include "geometry/linear_light.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>
#include <utility>
#include <vector>

#include "geometry/linear_placement.h"

namespace penumbra {
namespace {

constexpr double kInf = std::numeric_limits<double>::infinity();

/// A flat strip or a box in one plane through the light: [x0, x1] x [z0, z1]; the light lies on z = 0, from 0 to 1.
struct Block {
    double x0, x1, z0, z1;
};
Block strip(double x0, double x1, double z = 1.0) {
    return {x0, x1, z, z};
}

/// Occluders over the receiver z = z_r + slope x.
struct RowScene {
    std::vector<Block> blocks;
    double z_r = 2.0, slope = 0.0;
    bool background = true;  ///< false: there is nothing behind the occluders

    [[nodiscard]] double receiver_z(double x) const { return z_r + slope * x; }

    /// Inverse depth of the first surface on the ray from (x, 0) in direction (u, 1).
    [[nodiscard]] double see(double x, double u) const {
        const double far_z = background ? z_r / (1.0 - slope * u) + slope * x / (1.0 - slope * u) : kInf;
        double nearest = background && far_z > 0.0 ? far_z : kInf;
        for (const Block& block : blocks) {
            // Enters through the near face or through a side.
            const double at_near = x + u * block.z0;
            if (at_near >= block.x0 && at_near <= block.x1) {
                nearest = std::min(nearest, block.z0);
                continue;
            }
            const double side = at_near < block.x0 ? block.x0 : block.x1;
            const double z = u != 0.0 ? (side - x) / u : kInf;
            if (z > block.z0 && z <= block.z1) {
                nearest = std::min(nearest, z);
            }
        }
        return std::isfinite(nearest) ? 1.0 / nearest : 0.0;
    }

    /// Share of the light that the receiver's point over x sees: what no block's shadow on the light covers.
    [[nodiscard]] double truth(double x) const {
        const double z = receiver_z(x);
        std::vector<std::pair<double, double>> hidden;
        for (const Block& block : blocks) {
            double low = kInf;
            double high = -kInf;
            for (const double bx : {block.x0, block.x1}) {
                for (const double bz : {block.z0, block.z1}) {
                    const double s = x + (bx - x) * z / (z - bz);
                    low = std::min(low, s);
                    high = std::max(high, s);
                }
            }
            hidden.emplace_back(std::clamp(low, 0.0, 1.0), std::clamp(high, 0.0, 1.0));
        }
        std::ranges::sort(hidden);
        double seen = 1.0;
        double up_to = 0.0;
        for (const auto& [low, high] : hidden) {
            seen -= std::max(0.0, high - std::max(low, up_to));
            up_to = std::max(up_to, high);
        }
        return seen;
    }
};

std::vector<LinearMap> maps_of(const RowScene& scene, const std::vector<double>& places, int width_px,
                               double half_width = 3.0) {
    std::vector<LinearMap> maps;
    for (const double along : places) {
        LinearMap map;
        map.width_px = width_px;
        map.height_px = 1;
        map.along = along;
        map.low = {-half_width, 0.0};
        map.step = {2.0 * half_width / width_px, 1.0};
        for (int x = 0; x < width_px; ++x) {
            map.d.push_back(scene.see(along, map.u_of(x)));
        }
        maps.push_back(std::move(map));
    }
    return maps;
}

std::vector<double> even(int samples) {
    std::vector<double> places;
    for (int i = 0; i < samples; ++i) {
        places.push_back(i / (samples - 1.0));
    }
    return places;
}

struct Errors {
    double rms = 0.0, low = 0.0, high = 0.0;
};

const LinearLookup kPaper{.bias = 2e-3};

/// Over x in [-2.5, 3.5], leaving out a texel around what `skip` names.
Errors errors_of(const RowScene& scene, int samples, int width_px, const SkinRules& rules = {},
                 const LinearLookup& lookup = kPaper) {
    const LinearVisibility light{maps_of(scene, even(samples), width_px), rules};
    Errors errors;
    constexpr int kPoints = 6001;
    double sum = 0.0;
    for (int i = 0; i < kPoints; ++i) {
        const double x = -2.5 + 6.0 * (i + 0.37) / kPoints;
        const double z = scene.receiver_z(x);
        LinearPoint point;
        point.uv = {x / z, 0.5};
        point.d = 1.0 / z;
        const double error = light.at(point, lookup) - scene.truth(x);
        errors.low = std::min(errors.low, error);
        errors.high = std::max(errors.high, error);
        sum += error * error;
    }
    errors.rms = std::sqrt(sum / kPoints);
    return errors;
}

RowScene wide_strip() {
    return {.blocks = {strip(0.2, 1.2)}};
}
RowScene thin_strip() {
    return {.blocks = {strip(0.45, 0.55)}};
}
RowScene gap(double from, double to) {
    return {.blocks = {strip(-9.0, from), strip(to, 9.0)}, .z_r = 2.2};
}
RowScene two_thin_strips() {
    return {.blocks = {strip(0.35, 0.42), strip(0.58, 0.65)}};
}
RowScene floating_box() {
    return {.blocks = {{0.3, 0.8, 0.8, 1.3}}, .z_r = 2.2};
}

TEST(LinearLight, TheFilterIsZeroOnPlanesAndChangesSignAcrossAStep) {
    for (const LogKernel kernel : {LogKernel::Three, LogKernel::Five}) {
        const std::vector<double> weights = log_weights(kernel);
        double sum = 0.0;
        for (const double weight : weights) {
            sum += weight;
        }
        EXPECT_NEAR(sum, 0.0, 1e-14);
        LinearMap map;
        map.width_px = map.height_px = 16;
        for (int y = 0; y < 16; ++y) {
            for (int x = 0; x < 16; ++x) {
                map.d.push_back(0.3 + 0.02 * x - 0.01 * y);
            }
        }
        const std::vector<double> plane = filter_log(map, kernel);
        for (int y = 3; y < 13; ++y) {
            for (int x = 3; x < 13; ++x) {
                EXPECT_NEAR(plane[map.index(x, y)], 0.0, 1e-14);
            }
        }
        for (int i = 0; i < 256; ++i) {
            map.d[static_cast<std::size_t>(i)] = i % 16 < 8 ? 1.0 : 0.0;
        }
        const std::vector<double> step = filter_log(map, kernel);
        const double a = step[map.index(7, 8)];
        const double b = step[map.index(8, 8)];
        EXPECT_NEAR(std::abs(a), kernel == LogKernel::Three ? 0.920 : 0.390, 1e-3);
        EXPECT_NEAR(a, -b, 1e-12);
        EXPECT_GE(std::abs(a - b), least_step_response(kernel));
    }
}

TEST(LinearLight, ACreaseAnswersWithOneSign) {
    LinearMap map;
    map.width_px = 16;
    map.height_px = 4;
    for (int i = 0; i < 64; ++i) {
        map.d.push_back(std::max(0, i % 16 - 8));
    }
    const std::vector<double> log = filter_log(map, LogKernel::Three);
    EXPECT_NEAR(log[map.index(7, 2)], 0.0, 1e-12);
    EXPECT_NEAR(std::abs(log[map.index(8, 2)]), 0.92, 0.001);
    EXPECT_NEAR(log[map.index(9, 2)], 0.0, 1e-12);
}

TEST(LinearLight, EveryEdgeOfRotatedSquaresAnswersAtLeastG) {
    // The true jump pairs of squares at many angles, rasterised by texel centres.
    double least = kInf;
    int same_sign = 0;
    for (int turn = 0; turn < 90; turn += 3) {
        LinearMap map;
        map.width_px = map.height_px = 48;
        const double c = std::cos(turn * 0.0174532925);
        const double s = std::sin(turn * 0.0174532925);
        for (int y = 0; y < 48; ++y) {
            for (int x = 0; x < 48; ++x) {
                const double px = x + 0.5 - 24.13;
                const double py = y + 0.5 - 23.71;
                map.d.push_back(std::max(std::abs(c * px + s * py), std::abs(c * py - s * px)) < 11.0 ? 1.0 : 0.0);
            }
        }
        const std::vector<double> log = filter_log(map, LogKernel::Three);
        for (int y = 3; y < 45; ++y) {
            for (int x = 3; x < 44; ++x) {
                const std::size_t a = map.index(x, y);
                if (map.d[a] != map.d[a + 1]) {
                    least = std::min(least, std::abs(log[a] - log[a + 1]));
                    same_sign += log[a] * log[a + 1] >= 0.0 ? 1 : 0;
                }
            }
        }
    }
    EXPECT_EQ(same_sign, 0);
    EXPECT_GE(least, 1.76);
}

// X1, X3: flat occluders parallel to the light are exact up to texels, of any width.
TEST(LinearLight, FlatOccludersParallelToTheLightAreExactToTheBoundOfTexels) {
    for (const int width_px : {256, 1024, 2048}) {
        const double ramp_px = 0.5 * width_px / 6.0;  // l (1/z_o - 1/z_r) in texels
        const Errors wide = errors_of(wide_strip(), 2, width_px);
        EXPECT_LE(std::max(wide.high, -wide.low), 1.5 / ramp_px) << width_px;
        const Errors thin = errors_of(thin_strip(), 2, width_px);
        EXPECT_LE(std::max(thin.high, -thin.low), 1.5 / ramp_px) << width_px;
    }
    EXPECT_NEAR(errors_of(wide_strip(), 2, 2048).rms, 0.0017, 0.0004);
    EXPECT_NEAR(errors_of(thin_strip(), 2, 2048).rms, 0.0016, 0.0004);
}

TEST(LinearLight, ThinStripsLoseTheirUmbraAndStillAddUp) {
    std::mt19937 random{5};
    std::uniform_real_distribution<double> uniform{0.0, 1.0};
    for (int i = 0; i < 20; ++i) {
        const double x0 = uniform(random);
        RowScene scene{.blocks = {strip(x0, x0 + 0.02 + 0.4 * uniform(random), 0.7 + 0.8 * uniform(random))}};
        const double ramp_px = (1.0 / scene.blocks[0].z0 - 0.5) * 2048 / 6.0;
        const Errors errors = errors_of(scene, 2, 2048);
        // Where the umbra is gone both edges' skins end at a point, each with its own bound.
        EXPECT_LE(std::max(errors.high, -errors.low), 2.0 * 1.5 / ramp_px) << i;
    }
}

// The table of section 3, W = 2048.
TEST(LinearLight, TheTableOfTheSpecificationComesOut) {
    struct Row {
        const char* name;
        RowScene scene;
        int samples;
        double rms, low, high;
    };
    const std::vector<Row> rows{
        {"strip", wide_strip(), 2, 0.0017, -0.008, 0.006},
        {"thin strip", thin_strip(), 2, 0.0016, -0.007, 0.002},
        {"gap", gap(0.3, 0.7), 2, 0.168, -0.734, 0.007},
        {"gap", gap(0.3, 0.7), 3, 0.0019, -0.006, 0.007},
        {"off-centre gap", gap(0.75, 0.95), 2, 0.131, -0.367, 0.006},
        {"off-centre gap", gap(0.75, 0.95), 5, 0.0017, -0.006, 0.006},
        {"two thin strips", two_thin_strips(), 2, 0.107, -0.324, 0.006},
        {"two thin strips", two_thin_strips(), 5, 0.0024, -0.008, 0.011},
        {"floating box", floating_box(), 2, 0.023, -0.005, 0.182},
    };
    for (const Row& row : rows) {
        const Errors errors = errors_of(row.scene, row.samples, 2048);
        EXPECT_NEAR(errors.rms, row.rms, 0.1 * row.rms + 4e-4) << row.name << " " << row.samples;
        EXPECT_NEAR(errors.low, row.low, 0.006) << row.name << " " << row.samples;
        EXPECT_NEAR(errors.high, row.high, 0.006) << row.name << " " << row.samples;
    }
}

// X4: a tilted receiver.
TEST(LinearLight, ATiltedReceiverErrsByTheRootOfTheDistancesAndNotInExactMode) {
    for (const double slope : {0.25, 0.5, -0.4, 1.0}) {
        RowScene scene = wide_strip();
        scene.slope = slope;
        const double kappa = (2.0 + slope) / 2.0;
        const double predicted = std::abs(std::sqrt(kappa) - 1.0) / (std::sqrt(kappa) + 1.0);
        const Errors linear = errors_of(scene, 2, 4096);
        EXPECT_NEAR(std::max(linear.high, -linear.low), predicted, 0.008) << slope;
        const Errors exact = errors_of(scene, 2, 4096, {.exact = true});
        EXPECT_LE(std::max(exact.high, -exact.low), 0.008) << slope;
        // Too dark in one channel, too light in the other, by the same; at slope 1 one penumbra has no end.
        if (slope < 1.0) {
            EXPECT_NEAR(linear.high, -linear.low, 0.012) << slope;
        }
    }
}

TEST(LinearLight, ExactAndLinearAgreeWhereTheReceiverIsParallel) {
    const LinearVisibility linear{maps_of(wide_strip(), even(2), 1024), {}};
    const LinearVisibility exact{maps_of(wide_strip(), even(2), 1024), {.exact = true}};
    for (std::size_t i = 0; i < 1024; ++i) {
        EXPECT_NEAR(linear.before(1)[i], exact.before(1)[i], 0.02);
        EXPECT_NEAR(linear.after(0)[i], exact.after(0)[i], 0.02);
    }
}

// (1) of 2.10, and its general form in space.
TEST(LinearLight, TheTransitionOfTwoLinesIsTheirRationalFunction) {
    const auto seen_from = [](double m, double t, double n, double u, double x_r) {
        return t * x_r / ((n - m) * x_r + u);
    };
    for (const double m : {0.0, 0.2, -0.3}) {
        for (const double n : {0.0, 0.4, -0.1}) {
            const double t = 2.0;
            const double u = -1.5;
            for (const double x_r : {-0.8, -0.1, 0.3, 1.1}) {
                // Light on y = m x + t, receiver on y = n x + u, the edge at the origin: both points on a line with it.
                const double x_l = seen_from(m, t, n, u, x_r);
                EXPECT_NEAR(x_l * (n * x_r + u) - x_r * (m * x_l + t), 0.0, 1e-12);
                EXPECT_NEAR(u * x_l / (t - (n - m) * x_l), x_r, 1e-12);
            }
            const bool linear = std::abs(seen_from(m, t, n, u, 1.0) - 2.0 * seen_from(m, t, n, u, 0.5)) < 1e-12;
            EXPECT_EQ(linear, m == n);
        }
    }
}

// X5: thick occluders jump where the other sample's edge ends.
TEST(LinearLight, AThickOccluderIsTooLightByTheClosedFormsJump) {
    const double z1 = 0.8;
    const double z2 = 1.3;
    for (const double a : {0.3, 0.5}) {
        // Seen from the sample at 0 the side at x = a; the box goes far to the right.
        const RowScene scene{.blocks = {{a, 9.0, z1, z2}}, .z_r = 2.2};
        const double jump = (a / z1 - a / z2) / (1.0 / z1 - 1.0 / 2.2);
        const Errors errors = errors_of(scene, 2, 4096);
        EXPECT_NEAR(errors.high, jump, 0.012) << a;
        EXPECT_GE(errors.low, -0.012) << a;
    }
}

TEST(LinearLight, ABoxThatStandsOnItsReceiverHasNoJump) {
    const RowScene scene{.blocks = {{0.3, 0.8, 1.2, 2.2}}, .z_r = 2.2};
    const LinearVisibility light{maps_of(scene, even(2), 4096), {}};
    for (double x = -1.5; x < 2.5; x += 0.001) {
        if (x > 0.29 && x < 0.81) {  // under the box, and the texel along the contact line
            continue;
        }
        LinearPoint point{.uv = {x / 2.2, 0.5}, .d = 1.0 / 2.2};
        EXPECT_NEAR(light.at(point, kPaper), scene.truth(x), 0.012) << x;
    }
}

TEST(LinearLight, MoreSamplesTendToTheTruth) {
    for (const RowScene& scene : {gap(0.3, 0.7), gap(0.75, 0.95), two_thin_strips(), floating_box()}) {
        const double few = errors_of(scene, 2, 2048).rms;
        const double many = errors_of(scene, 17, 2048).rms;
        EXPECT_LT(many, std::min(0.25 * few, 0.012));
    }
}

// X6, X7 and the clamp.
TEST(LinearLight, AnErrorWithinASegmentIsAtMostItsShare) {
    const Errors five = errors_of(gap(0.55, 0.7), 5, 2048);  // between two samples: missed whole
    EXPECT_GE(five.low, -0.25 - 0.02);
    EXPECT_LE(five.high, 0.02);
}

TEST(LinearLight, VStaysBetweenUmbraAndLitInRandomScenes) {
    std::mt19937 random{11};
    std::uniform_real_distribution<double> uniform{0.0, 1.0};
    for (int i = 0; i < 40; ++i) {
        RowScene scene;
        scene.slope = uniform(random) - 0.5;
        for (int k = 0; k < 4; ++k) {
            const double x = 2.0 * uniform(random) - 0.5;
            const double z = 0.4 + 0.8 * uniform(random);
            scene.blocks.push_back({x, x + 0.6 * uniform(random), z, z + 0.4 * uniform(random)});
        }
        const int samples = 2 + i % 4;
        for (const bool exact : {false, true}) {
            const LinearVisibility light{maps_of(scene, even(samples), 512), {.exact = exact}};
            for (double x = -1.5; x < 2.5; x += 0.01) {
                const double z = scene.receiver_z(x);
                const double v = light.at({.uv = {x / z, 0.5}, .d = 1.0 / z}, kPaper);
                ASSERT_TRUE(v >= 0.0 && v <= 1.0) << v;
            }
        }
    }
}

TEST(LinearLight, WithoutSkinsItIsTheTrapezoidSumOfHardShadows) {
    const RowScene scene = wide_strip();
    const LinearVisibility light{maps_of(scene, even(4), 1024), {.least_skin_px = 1e9}};
    EXPECT_EQ(light.skin_count(), 0U);
    for (double x = -2.0; x < 3.0; x += 0.01) {
        const double v = light.at({.uv = {x / 2.0, 0.5}, .d = 0.5}, kPaper);
        const double sixths = 6.0 * v;  // ends weigh 1/6, inner samples 1/3
        EXPECT_NEAR(sixths, std::round(sixths), 1e-12) << x;
    }
}

TEST(LinearLight, SegmentsOfThreeSamplesKeepTheirOwnSlots) {
    // The strip hides the second half of the light alone: the first segment must be whole.
    const RowScene scene = wide_strip();
    const LinearVisibility light{maps_of(scene, even(3), 2048), {}};
    int told_apart = 0;
    for (double x = -2.0; x < 3.0; x += 0.002) {
        const LinearPoint point{.uv = {x / 2.0, 0.5}, .d = 0.5};
        const double low = 2.0 * 0.2 - x;  // the strip hides [low, low + 2] of the light
        const double first = 1.0 - std::clamp(std::min(0.5, low + 2.0) - std::max(0.0, low), 0.0, 0.5) / 0.5;
        const double second = 1.0 - std::clamp(std::min(1.0, low + 2.0) - std::max(0.5, low), 0.0, 0.5) / 0.5;
        EXPECT_NEAR(light.segment_at(0, point, kPaper), first, 0.03) << x;
        EXPECT_NEAR(light.segment_at(1, point, kPaper), second, 0.03) << x;
        told_apart += std::abs(first - second) > 0.5 ? 1 : 0;
    }
    EXPECT_GT(told_apart, 100);
}

// Section 4.
TEST(LinearLight, ALightWithoutLengthIsAPlainShadowMap) {
    for (const double length : {0.0, 1e-9}) {
        const LinearVisibility light{maps_of(wide_strip(), {0.0, length}, 512), {}};
        EXPECT_EQ(light.skin_count(), 0U);
        const LinearVisibility hard{maps_of(wide_strip(), {0.0}, 512), {}};
        for (double x = -2.0; x < 3.0; x += 0.01) {
            const LinearPoint point{.uv = {x / 2.0, 0.5}, .d = 0.5};
            EXPECT_EQ(light.at(point, kPaper), hard.at(point, kPaper)) << x;
        }
    }
}

TEST(LinearLight, OverNothingTheSkinEndsAtInfinity) {
    RowScene scene = wide_strip();
    scene.background = false;
    const LinearVisibility linear{maps_of(scene, even(2), 1024), {}};
    EXPECT_GT(linear.skin_count(), 0U);
    for (const double v : linear.before(1)) {
        EXPECT_TRUE(v >= 0.0 && v <= 1.0);
    }
    // A skin to a far background under-lights a nearer receiver that is no part of the maps.
    const LinearPoint point{.uv = {0.5 * (0.2 + 0.4 * 0.5), 0.5}, .d = 0.5};
    EXPECT_LE(linear.at(point, {.rim_rule = false}), 1.0);
}

TEST(LinearLight, AnOccluderThatTouchesItsReceiverHasAHardShadow) {
    const RowScene scene{.blocks = {strip(0.3, 0.8, 2.0 - 1e-9)}};
    for (const bool exact : {false, true}) {
        const LinearVisibility light{maps_of(scene, even(2), 1024), {.exact = exact}};
        for (double x = -1.0; x < 2.0; x += 0.01) {
            const double v = light.at({.uv = {x / 2.0, 0.5}, .d = 0.5}, kPaper);
            EXPECT_TRUE(v == 1.0 || v == 0.0) << x << " " << v;
        }
    }
}

TEST(LinearLight, AnOccluderCloseToTheLightStaysFinite) {
    const RowScene scene{.blocks = {strip(0.4, 0.6, 1e-4)}};
    for (const bool exact : {false, true}) {
        const LinearVisibility light{maps_of(scene, even(2), 512), {.exact = exact}};
        for (double x = -2.0; x < 3.0; x += 0.01) {
            const double v = light.at({.uv = {x / 2.0, 0.5}, .d = 0.5}, kPaper);
            EXPECT_TRUE(v >= 0.0 && v <= 1.0) << x;
        }
    }
}

TEST(LinearLight, OutsideOfTheMapsItIsLit) {
    const LinearVisibility light{maps_of(wide_strip(), even(3), 256), {}};
    EXPECT_EQ(light.at({.uv = {40.0, 0.5}, .d = 0.5}, kPaper), 1.0);
    EXPECT_EQ(light.at({.uv = {0.0, 7.0}, .d = 0.5}, kPaper), 1.0);
}

TEST(LinearLight, TheRimOfAnOccluderStaysLit) {
    // Just inside the strip's edge the nearest entry can be the receiver's.
    for (const int samples : {2, 3}) {
        const LinearVisibility light{maps_of(wide_strip(), even(samples), 512), {}};
        int dark_without_the_rule = 0;
        for (double x = 0.2; x < 1.2; x += 0.0005) {
            const LinearPoint point{.uv = {x, 0.5}, .d = 1.0};
            EXPECT_EQ(light.at(point, kPaper), 1.0) << x;
            dark_without_the_rule += light.at(point, {.rim_rule = false}) < 1.0 ? 1 : 0;
        }
        EXPECT_GT(dark_without_the_rule, 0) << "else this tests nothing";
    }
}

TEST(LinearLight, ThePlaneOfTheReceiverCutsWhatItTurnsFrom) {
    // A point on a plane through the light's middle: half of the light lies behind it.
    std::vector<LinearMap> maps = maps_of({.blocks = {}}, even(2), 256);
    const LinearVisibility light{std::move(maps), {}};
    LinearPoint point{.uv = {0.25, 0.5}, .d = 1.0, .has_plane = true, .normal_uv = {1.0, 0.0}};
    LinearLookup lookup{.facing_test = true};
    for (const double s : {0.25, 0.5, 0.8}) {
        point.towards = -s;  // normal along +u: samples beyond s face it
        EXPECT_NEAR(light.at(point, lookup), 1.0 - s, 1e-12);
    }
    lookup.facing_test = false;
    EXPECT_EQ(light.at(point, lookup), 1.0);
}

TEST(LinearLight, PointSamplesErrAsTheSpecificationSays) {
    // X8: N point samples, evenly placed, against this method with two.
    const RowScene scene = wide_strip();
    struct Row {
        int samples;
        double rms;
    };
    for (const auto& [samples, rms] : {Row{2, 0.167}, Row{4, 0.068}, Row{16, 0.0152}, Row{64, 0.0039}}) {
        double sum = 0.0;
        constexpr int kPoints = 6001;
        for (int i = 0; i < kPoints; ++i) {
            const double x = -2.5 + 6.0 * (i + 0.37) / kPoints;
            double seen = 0.0;
            for (int k = 0; k < samples; ++k) {
                const double s = (k + 0.5) / samples;
                const double at = x + (s - x) * 0.5;  // where the ray crosses z = 1
                seen += at > 0.2 && at < 1.2 ? 0.0 : 1.0 / samples;
            }
            sum += (seen - scene.truth(x)) * (seen - scene.truth(x));
        }
        const double measured = std::sqrt(sum / kPoints);
        // Of N strata; the table's own placement has the ends among them and errs a little more.
        EXPECT_LE(measured, rms * 1.05) << samples;
        EXPECT_GT(measured, errors_of(scene, 2, 2048).rms) << samples;
    }
}

// 2.12, with the numbers of samples and the errors that it measured.
TEST(LinearLight, SamplesAreAddedWhereTwoAreTooFewAndNowhereElse) {
    struct Row {
        const char* name;
        RowScene scene;
        std::size_t samples;
        double rms;
    };
    const std::vector<Row> rows{
        {"strip", wide_strip(), 2, 0.0020},
        {"thin strip", thin_strip(), 2, 0.0020},
        {"box", floating_box(), 2, 0.026},
        {"gap", gap(0.3, 0.7), 3, 0.0022},
        {"off-centre gap", gap(0.75, 0.95), 5, 0.0020},
        {"two thin strips", two_thin_strips(), 5, 0.0028},
    };
    for (const Row& row : rows) {
        const auto triggers = [&](double from, double at, double to) {
            const std::vector<LinearMap> maps = maps_of(row.scene, {from, at, to}, 2048);
            return score_candidate(maps[0], maps[1], maps[2], {}, kPaper).triggers();
        };
        const std::vector<double> places = place_samples({0.0, 1.0}, 17, 1.0 / 16.0, triggers);
        EXPECT_EQ(places.size(), row.samples) << row.name;
        EXPECT_LE(errors_of(row.scene, static_cast<int>(places.size()), 2048).rms, row.rms) << row.name;
    }
}

TEST(LinearLight, PlacementStopsAtItsLimits) {
    const auto always = [](double, double, double) { return true; };
    EXPECT_EQ(place_samples({0.0, 1.0}, 9, 0.0, always).size(), 9U);
    EXPECT_EQ(place_samples({0.0, 1.0}, 17, 0.3, always).size(), 5U);
    EXPECT_EQ(place_samples({0.0, 0.5, 1.0}, 3, 0.0, always).size(), 3U);
    EXPECT_EQ(place_samples({0.0}, 9, 0.0, always).size(), 1U);
    const std::vector<double> places = place_samples({0.0, 1.0}, 6, 0.0, always);
    EXPECT_TRUE(std::ranges::is_sorted(places));
}

}  // namespace
}  // namespace penumbra
