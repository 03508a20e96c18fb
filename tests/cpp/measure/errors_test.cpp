#include <cmath>
#include <limits>

#include "images.h"
#include "penumbra/error.h"

namespace penumbra {
namespace {

using test::Image;
using test::measure;
using test::Ramp;
using test::sum_of_parts;
using testing::HasSubstr;

constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
constexpr float kInf = std::numeric_limits<float>::infinity();

Image with_noise(const Image& image, double sigma, unsigned seed) {
    std::mt19937 random{seed};
    std::normal_distribution<double> normal{0.0, sigma};
    Image noisy;
    for (const float v : image) {
        noisy.push_back(static_cast<float>(static_cast<double>(v) + normal(random)));
    }
    return noisy;
}

TEST(Errors, AreZeroForTheReferenceItself) {
    const Ramp ramp;
    const ErrorSummary s = measure({ramp.reference()}, ramp.reference(), ramp.width());
    EXPECT_EQ(s.pixels, 768U);
    EXPECT_EQ(s.rmse, 0.0);
    EXPECT_EQ(s.max, 0.0);
    EXPECT_EQ(s.leak, 0.0);
    EXPECT_EQ(s.over_darkening, 0.0);
    EXPECT_EQ(s.penumbra_width_ratio, 1.0);
    EXPECT_TRUE(s.within_reference_noise);
    EXPECT_EQ(s.dominant, "none");
    EXPECT_THAT(s.sentence, HasSubstr("equals the reference"));
}

TEST(Errors, OfAConstantShiftAreThatShift) {
    const Image reference(100, 0.5F);
    const ErrorSummary s = measure({Image(100, 0.25F)}, reference, 10);
    EXPECT_EQ(s.rmse, 0.25);
    EXPECT_EQ(s.mae, 0.25);
    EXPECT_EQ(s.bias, -0.25);
    EXPECT_EQ(s.p95, 0.25);
    EXPECT_EQ(s.max, 0.25);
    EXPECT_EQ(s.penumbra_rmse, 0.25);
    EXPECT_EQ(s.parts.bias, 0.0625);
}

TEST(Errors, CountOnlyTheMask) {
    const Image reference{0.5F, kNan, 0.5F, 0.5F};
    const ErrorSummary s = measure({{0.5F, kNan, 1.0F, 0.5F}}, reference, 2, {}, {1, 0, 0, 1});
    EXPECT_EQ(s.pixels, 2U);
    EXPECT_EQ(s.rmse, 0.0);
    EXPECT_EQ(s.non_finite, 0U);
}

TEST(Errors, OfAnEmptyMaskAreZeroAndSaySo) {
    const Image reference(4, 0.5F);
    const ErrorSummary s = measure({Image(4, 1.0F)}, reference, 2, {}, {0, 0, 0, 0});
    EXPECT_EQ(s.pixels, 0U);
    EXPECT_EQ(s.rmse, 0.0);
    EXPECT_EQ(s.p99, 0.0);
    EXPECT_EQ(s.dominant, "none");
    EXPECT_THAT(s.sentence, HasSubstr("Nothing to compare"));
}

TEST(Errors, OfNoPixelsAtAllAreZero) {
    EXPECT_EQ(measure({Image{}}, Image{}, 1).pixels, 0U);
}

TEST(Errors, OfASinglePixelAreItsError) {
    const ErrorSummary s = measure({{1.0F}}, {0.0F}, 1);
    EXPECT_EQ(s.rmse, 1.0);
    EXPECT_EQ(s.p95, 1.0);
    EXPECT_EQ(s.leak, 1.0);
    EXPECT_EQ(s.parts.leak, 1.0);
    EXPECT_EQ(s.dominant, "leak");
}

TEST(Errors, CountEveryNotANumberAsAnErrorOfOne) {
    const Image reference{0.0F, 1.0F, 0.25F, 0.75F};
    const ErrorSummary s = measure({{kNan, kInf, -kInf, kNan}}, reference, 2);
    EXPECT_EQ(s.non_finite, 4U);
    EXPECT_EQ(s.rmse, 1.0);
    EXPECT_EQ(s.mae, 1.0);
    EXPECT_EQ(s.max, 1.0);
    EXPECT_EQ(s.leak, 1.0);
    EXPECT_EQ(s.over_darkening, 1.0);
    EXPECT_THAT(s.sentence, HasSubstr("4 values were not a number"));
}

TEST(Errors, TakeTheClassFromTheReferenceWithItsMarginIncluded) {
    const Image reference{1e-4F, 1.01e-4F, 1.0F - 1e-4F, 0.9998F};
    EXPECT_EQ(measure({reference}, reference, 4).penumbra_pixels, 2U);
}

TEST(Errors, LeakIsTheMeanVInTheUmbraAndOverDarkeningWhatLitPixelsMiss) {
    const Image reference{0.0F, 0.0F, 1.0F, 1.0F};
    const ErrorSummary s = measure({{0.5F, 0.0F, 1.0F, 0.75F}}, reference, 2);
    EXPECT_EQ(s.leak, 0.25);
    EXPECT_EQ(s.over_darkening, 0.125);
    EXPECT_EQ(s.parts.leak, 0.0625);
    EXPECT_EQ(s.parts.over_darkening, 0.015625);
    EXPECT_EQ(s.penumbra_rmse, 0.0);
}

TEST(Errors, WithinTheReferencesOwnErrorHaveNoDominantPart) {
    const Image reference(64, 0.5F);
    EXPECT_EQ(measure({Image(64, 0.501F)}, reference, 8, Image(64, 0.002F)).dominant, "none");
    const ErrorSummary s = measure({Image(64, 0.503F)}, reference, 8, Image(64, 0.002F));
    EXPECT_FALSE(s.within_reference_noise);
    EXPECT_NEAR(s.reference_standard_error, 0.002, 1e-9);
    EXPECT_EQ(s.dominant, "bias");
}

TEST(Errors, RefuseArraysThatDoNotFitAndReferencesThatAreNotANumber) {
    EXPECT_THROW(measure({}, {0.5F}, 1), Error);
    EXPECT_THROW(measure({{0.5F, 0.5F}}, {0.5F}, 1), Error);
    EXPECT_THROW(measure({{0.5F}}, {0.5F}, 0), Error);
    EXPECT_THROW(measure({{0.5F, 0.5F, 0.5F}}, {0.5F, 0.5F, 0.5F}, 2), Error);
    EXPECT_THROW(measure({{0.5F}}, {0.5F}, 1, {0.1F, 0.1F}), Error);
    EXPECT_THROW(measure({{0.5F}}, {0.5F}, 1, {}, {1, 1}), Error);
    EXPECT_THROW(measure({{0.5F}}, {kNan}, 1), Error);
    EXPECT_THROW(measure({{0.5F}}, {0.5F}, 1, {kInf}), Error);
}

TEST(Split, AddsUpForAnyImages) {
    std::mt19937 random{11};
    std::uniform_real_distribution<float> number{-0.2F, 1.2F};
    for (int round = 0; round < 50; ++round) {
        const int seeds = 1 + round % 8;
        const auto make = [&] {
            Image image(300);
            for (float& v : image) {
                v = number(random);
            }
            return image;
        };
        Image reference = make();
        for (float& v : reference) {
            v = std::clamp(v, 0.0F, 1.0F);
        }
        std::vector<Image> images;
        for (int s = 0; s < seeds; ++s) {
            images.push_back(round % 3 == 0 ? with_noise(reference, 0.1, static_cast<unsigned>(round * 8 + s))
                                            : make());
        }
        const ErrorSummary summary = measure(images, reference, 20);
        EXPECT_NEAR(sum_of_parts(summary), summary.rmse * summary.rmse, 1e-12);
        for (const double part : {summary.parts.noise, summary.parts.leak, summary.parts.over_darkening,
                                  summary.parts.bias, summary.parts.aliasing}) {
            EXPECT_GE(part, 0.0);
        }
    }
}

TEST(Split, SeesPureNoiseAsNoiseWhateverTheNumberOfSeeds) {
    const Ramp ramp{256, 256, 256, 32};
    for (const int count : {2, 4, 16}) {
        std::vector<Image> seeds;
        for (int s = 0; s < count; ++s) {
            seeds.push_back(with_noise(ramp.reference(), 0.1, static_cast<unsigned>(100 * count + s)));
        }
        const ErrorSummary summary = measure(seeds, ramp.reference(), ramp.width());
        EXPECT_NEAR(summary.parts.noise, 0.01, 2e-4) << count;
        EXPECT_LT(summary.rmse * summary.rmse - summary.parts.noise, 2e-4) << count;
        EXPECT_EQ(summary.dominant, "noise");
        EXPECT_THAT(summary.sentence, HasSubstr("four times the rays halve it"));
    }
}

TEST(Split, SeesPureBiasAsBias) {
    const Ramp ramp;
    const Image soft = ramp.image([](double t) { return std::clamp(2.0 * t - 0.5, 0.0, 1.0); });
    const ErrorSummary s = measure({soft, soft}, ramp.reference(), ramp.width());
    EXPECT_GT(s.parts.bias, 0.98 * s.rmse * s.rmse);  // the rest is the slope within a bin
    EXPECT_EQ(s.parts.noise, 0.0);
    EXPECT_EQ(s.parts.leak, 0.0);
    EXPECT_EQ(s.dominant, "bias");
    EXPECT_THAT(s.sentence, HasSubstr("0.5 times the true width"));
}

TEST(Split, FindsTheBiasUnderTheNoise) {
    const Ramp ramp{0, 256, 0, 64};
    const Image hard = ramp.image([](double t) { return t < 0.5 ? 0.0 : 1.0; });
    std::vector<Image> seeds;
    for (unsigned s = 0; s < 4; ++s) {
        seeds.push_back(with_noise(hard, 0.2, s));
    }
    const ErrorSummary summary = measure(seeds, ramp.reference(), ramp.width());
    EXPECT_NEAR(summary.parts.bias, 1.0 / 12.0, 1e-3);
    EXPECT_NEAR(summary.parts.noise, 0.04, 1e-3);
}

TEST(Split, SeesPureLeakAsLeakAndTellsWhetherEdgesCauseIt) {
    const Ramp ramp{256, 16, 256, 8};
    const Image everywhere = ramp.image([](double t) { return t < 0.0 ? 0.3 : std::min(t, 1.0); });
    const ErrorSummary far = measure({everywhere}, ramp.reference(), ramp.width());
    EXPECT_NEAR(far.parts.leak, far.rmse * far.rmse, 1e-12);
    EXPECT_EQ(far.dominant, "leak");
    EXPECT_NEAR(far.leak, 0.3, 1e-7);
    EXPECT_THAT(far.sentence, HasSubstr("away from shadow edges"));
    const Image beside = ramp.image([](double t) { return t < 0.0 ? (t > -0.2 ? 0.3 : 0.0) : std::min(t, 1.0); });
    EXPECT_THAT(measure({beside}, ramp.reference(), ramp.width()).sentence, HasSubstr("of a shadow edge"));
}

TEST(Split, SeesAcneAsOverDarkening) {
    const Ramp ramp{64, 0, 256, 8};
    Image striped = ramp.reference();
    for (std::size_t i = 0; i < striped.size(); i += 3) {
        striped[i] = 0.0F;
    }
    const ErrorSummary s = measure({striped}, ramp.reference(), ramp.width());
    EXPECT_EQ(s.dominant, "over_darkening");
    EXPECT_NEAR(s.over_darkening, 1.0 / 3.0, 0.01);
    EXPECT_THAT(s.sentence, HasSubstr("acne"));
}

TEST(Split, SeesAPureStaircaseAsAliasing) {
    // A wavy edge: its error changes sign from row to row, so no profile explains it.
    const Ramp ramp{64, 256, 64, 64};
    const Image wavy = ramp.image([](double t, int row) {
        return t <= 0.0 || t >= 1.0 ? std::clamp(t, 0.0, 1.0) : t + (row % 2 == 0 ? 0.05 : -0.05);
    });
    const ErrorSummary s = measure({wavy, wavy}, ramp.reference(), ramp.width());
    EXPECT_NEAR(s.parts.aliasing, s.rmse * s.rmse, 1e-9);
    EXPECT_EQ(s.dominant, "aliasing");
    EXPECT_THAT(s.sentence, HasSubstr("staircase"));
}

TEST(Split, CountsTheNoiseOfASingleImageAsAliasing) {
    const Ramp ramp{0, 256, 0, 16};
    const ErrorSummary s = measure({with_noise(ramp.reference(), 0.1, 1)}, ramp.reference(), ramp.width());
    EXPECT_EQ(s.parts.noise, 0.0);
    EXPECT_EQ(s.dominant, "aliasing");
}

}  // namespace
}  // namespace penumbra
