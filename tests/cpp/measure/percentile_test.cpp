#include "measure/percentile.h"

#include <gtest/gtest.h>

#include <numeric>
#include <vector>

namespace penumbra {
namespace {

TEST(Percentile, IsTheNearestRank) {
    std::vector<int> values(100);
    std::iota(values.rbegin(), values.rend(), 1);  // 100 .. 1
    EXPECT_EQ(percentile(std::span{values}, 0.95), 95);
    EXPECT_EQ(percentile(std::span{values}, 0.951), 96);
    EXPECT_EQ(percentile(std::span{values}, 0.001), 1);
    EXPECT_EQ(percentile(std::span{values}, 1.0), 100);
}

TEST(Percentile, OfOneValueIsThatValueAndOfNoneZero) {
    std::vector<double> one{7.0};
    EXPECT_EQ(percentile(std::span{one}, 0.01), 7.0);
    std::vector<double> none;
    EXPECT_EQ(percentile(std::span{none}, 0.5), 0.0);
}

}  // namespace
}  // namespace penumbra
