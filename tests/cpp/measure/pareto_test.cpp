#include <gmock/gmock.h>

#include <cmath>
#include <limits>
#include <random>

#include "penumbra/error.h"
#include "penumbra/measure.h"

namespace penumbra {
namespace {

using testing::ElementsAre;

std::vector<bool> front(const std::vector<double>& times, const std::vector<double>& errors) {
    return pareto_front(times, errors);
}

TEST(ParetoFront, IsTheLowerLeftStaircase) {
    EXPECT_THAT(front({1, 2, 3, 4}, {0.4, 0.5, 0.2, 0.1}), ElementsAre(true, false, true, true));
}

TEST(ParetoFront, DropsTheSlowerOfTwoEqualErrorsAndTheWorseOfTwoEqualTimes) {
    EXPECT_THAT(front({1, 2}, {0.5, 0.5}), ElementsAre(true, false));
    EXPECT_THAT(front({1, 1}, {0.5, 0.4}), ElementsAre(false, true));
}

TEST(ParetoFront, KeepsEqualPoints) {
    EXPECT_THAT(front({2, 2, 1}, {0.1, 0.1, 0.2}), ElementsAre(true, true, true));
}

TEST(ParetoFront, LeavesOutWhatIsNotFinite) {
    const double nan = std::numeric_limits<double>::quiet_NaN();
    const double inf = std::numeric_limits<double>::infinity();
    EXPECT_THAT(front({nan, 1, 0, 5}, {0, 0.3, nan, -inf}), ElementsAre(false, true, false, false));
}

TEST(ParetoFront, OfNothingIsEmptyAndOfUnequalListsAnError) {
    EXPECT_TRUE(front({}, {}).empty());
    EXPECT_THROW(front({1}, {}), Error);
}

TEST(ParetoFront, KeepsWhatNothingDominatesAndDropsTheRest) {
    std::mt19937 random{5};
    for (int round = 0; round < 200; ++round) {
        std::vector<double> times;
        std::vector<double> errors;
        for (int i = 0; i < 40; ++i) {  // few distinct values, so that ties abound
            times.push_back(static_cast<double>(random() % 12));
            errors.push_back(static_cast<double>(random() % 12));
        }
        const std::vector<bool> kept = front(times, errors);
        for (std::size_t i = 0; i < kept.size(); ++i) {
            bool dominated = false;
            for (std::size_t j = 0; j < kept.size(); ++j) {
                dominated = dominated || (times[j] <= times[i] && errors[j] <= errors[i] &&
                                          (times[j] < times[i] || errors[j] < errors[i]));
            }
            ASSERT_EQ(kept[i], !dominated);
        }
    }
}

}  // namespace
}  // namespace penumbra
