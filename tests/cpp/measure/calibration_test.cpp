// What wrong penumbrae cost on a straight edge, in closed form: the integral over the ramp t = 0 .. 1 of (V(t) - t)^2.
// 256 samples of the ramp come within 0.0005 of the integrals; the steps of the bands are exact.

#include <cmath>
#include <numbers>

#include "images.h"

namespace penumbra {
namespace {

using test::Image;
using test::Ramp;

struct Case {
    const char* name;
    std::function<double(double)> v;
    double penumbra_rmse;
    double width_ratio;
    const char* dominant;
};

class Calibration : public testing::TestWithParam<Case> {};

TEST_P(Calibration, GivesTheClosedForm) {
    const Ramp ramp{256, 256, 256, 4};
    const ErrorSummary summary = test::measure({ramp.image(GetParam().v)}, ramp.reference(), ramp.width());
    EXPECT_EQ(summary.penumbra_pixels, 4U * 256U);
    EXPECT_NEAR(summary.penumbra_rmse, GetParam().penumbra_rmse, 5e-4);
    EXPECT_NEAR(summary.penumbra_width_ratio, GetParam().width_ratio, 0.02);
    EXPECT_EQ(summary.dominant, GetParam().dominant);
    EXPECT_NEAR(test::sum_of_parts(summary), summary.rmse * summary.rmse, 1e-12);
}

double clamped(double v) {
    return std::clamp(v, 0.0, 1.0);
}

const std::vector<Case> kCases{
    Case{"hard_shadow", [](double t) { return t < 0.5 ? 0.0 : 1.0; }, 1.0 / std::sqrt(12.0), 0.0, "bias"},
    Case{"outer_half_only", [](double t) { return clamped(2.0 * t - 1.0); }, 1.0 / std::sqrt(12.0), 0.5, "bias"},
    Case{"outer_half_at_half_width", [](double t) { return clamped(4.0 * t - 2.0); }, 0.25, 0.25, "bias"},
    Case{"centred_half_as_wide", [](double t) { return clamped(2.0 * t - 0.5); }, 1.0 / std::sqrt(48.0), 0.5, "bias"},
    Case{"shifted_out_by_half", [](double t) { return clamped(t - 0.5); }, 1.0 / std::sqrt(6.0), 1.0, "bias"},
    Case{"smoothstep",
         [](double t) {
             t = clamped(t);
             return t * t * (3.0 - 2.0 * t);
         },
         // 0.1 < smoothstep < 0.9 holds for t = 0.1958 .. 0.8042
         1.0 / std::sqrt(210.0), 0.6084 / 0.8, "bias"},
    Case{"a_fifth_wider", [](double t) { return clamped(0.5 + (t - 0.5) / 1.2); }, 1.0 / (6.0 * std::sqrt(12.0)), 1.2,
         "bias"},
    Case{"sixteen_bands",
         [](double t) { return t <= 0.0 || t >= 1.0 ? clamped(t) : (std::floor(16.0 * t) + 0.5) / 16.0; },
         1.0 / (16.0 * std::sqrt(12.0)), 0.75 / 0.8, "bias"},  // a bin of the split sees half a band: systematic
    Case{"sixty_four_bands",
         [](double t) { return t <= 0.0 || t >= 1.0 ? clamped(t) : (std::floor(64.0 * t) + 0.5) / 64.0; },
         std::sqrt(1.25) / 256.0, 1.0, "aliasing"},  // finer than a bin
};

INSTANTIATE_TEST_SUITE_P(Ramps, Calibration, testing::ValuesIn(kCases),
                         [](const auto& parameter) { return parameter.param.name; });

TEST(Calibration, SixteenRandomRaysHaveTheBinomialError) {
    // The variance of a mean of 16 rays is t (1 - t) / 16, over the ramp 1 / 96.
    const Ramp ramp{0, 256, 0, 64};
    std::mt19937 random{3};
    std::vector<Image> seeds;
    for (int s = 0; s < 8; ++s) {
        seeds.push_back(ramp.image([&](double t) { return std::binomial_distribution<int>{16, t}(random) / 16.0; }));
    }
    const ErrorSummary summary = test::measure(seeds, ramp.reference(), ramp.width());
    EXPECT_NEAR(summary.penumbra_rmse, 1.0 / std::sqrt(96.0), 0.001);
    EXPECT_EQ(summary.dominant, "noise");
    EXPECT_GT(summary.parts.noise, 0.995 * summary.rmse * summary.rmse);
}

}  // namespace
}  // namespace penumbra
