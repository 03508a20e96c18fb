#include "reference/sampling.h"

#include <gtest/gtest.h>

#include <cmath>

namespace penumbra {
namespace {

TEST(Strata, OfAnyCountHaveEqualAreasAndTileTheSquare) {
    for (const int count : {1, 2, 3, 5, 7, 8, 16, 20, 31, 64, 100, 1000}) {
        const Strata strata = make_strata(count, false);
        ASSERT_EQ(strata.count(), count);
        double area = 0.0;
        double u = 0.0;
        double v = 0.0;
        for (int i = 0; i < count; ++i) {
            const double cell = static_cast<double>(strata.width[i]) * strata.height[i];
            EXPECT_NEAR(cell, 1.0 / count, 1e-6 / count) << "cell " << i << " of " << count;
            area += cell;
            u += cell * (strata.u[i] + 0.5 * strata.width[i]);
            v += cell * (strata.v[i] + 0.5 * strata.height[i]);
            EXPECT_LE(strata.u[i] + strata.width[i], 1.0F + 1e-6F);
            EXPECT_LE(strata.v[i] + strata.height[i], 1.0F + 1e-6F);
        }
        EXPECT_NEAR(area, 1.0, 1e-6);
        EXPECT_NEAR(u, 0.5, 1e-6);
        EXPECT_NEAR(v, 0.5, 1e-6);
    }
}

TEST(Strata, OfASquareNumberAreTheSquareGrid) {
    const Strata strata = make_strata(16, false);
    for (int i = 0; i < 16; ++i) {
        EXPECT_FLOAT_EQ(strata.u[i], 0.25F * static_cast<float>(i % 4));
        EXPECT_FLOAT_EQ(strata.v[i], 0.25F * static_cast<float>(i / 4));
    }
}

TEST(Strata, OfALineAreIntervals) {
    const Strata strata = make_strata(10, true);
    for (int i = 0; i < 10; ++i) {
        EXPECT_NEAR(strata.u[i], 0.1 * i, 1e-6);
        EXPECT_FLOAT_EQ(strata.height[i], 1.0F);
    }
}

TEST(UniformPair, HasTheMomentsOfIndependentUniformNumbers) {
    constexpr int kSamples = 200000;
    double a1 = 0.0;
    double a2 = 0.0;
    double b1 = 0.0;
    double ab = 0.0;
    double lag = 0.0;
    float previous = 0.5F;
    for (int i = 0; i < kSamples; ++i) {
        float a;
        float b;
        uniform_pair(sequence_key(static_cast<std::uint32_t>(i / 16), sequence_base(7, 0)),
                     static_cast<std::uint32_t>(i % 16), a, b);
        ASSERT_GT(a, 0.0F);
        ASSERT_LT(a, 1.0F);
        ASSERT_GT(b, 0.0F);
        ASSERT_LT(b, 1.0F);
        a1 += a;
        a2 += static_cast<double>(a) * a;
        b1 += b;
        ab += static_cast<double>(a) * b;
        lag += static_cast<double>(a) * previous;
        previous = a;
    }
    // Five standard deviations of each mean.
    const double five_sigma = 5.0 * 0.2887 / std::sqrt(kSamples);
    EXPECT_NEAR(a1 / kSamples, 0.5, five_sigma);
    EXPECT_NEAR(b1 / kSamples, 0.5, five_sigma);
    EXPECT_NEAR(a2 / kSamples, 1.0 / 3.0, five_sigma);
    EXPECT_NEAR(ab / kSamples, 0.25, five_sigma);
    EXPECT_NEAR(lag / kSamples, 0.25, five_sigma);
}

TEST(SequenceKey, DiffersBetweenPixelsSeedsAndStreams) {
    EXPECT_NE(sequence_key(0, sequence_base(1, 0)), sequence_key(1, sequence_base(1, 0)));
    EXPECT_NE(sequence_key(0, sequence_base(1, 0)), sequence_key(0, sequence_base(2, 0)));
    EXPECT_NE(sequence_key(0, sequence_base(1, 0)), sequence_key(0, sequence_base(1, 1)));
}

}  // namespace
}  // namespace penumbra
