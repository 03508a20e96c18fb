#include <gmock/gmock.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <random>
#include <thread>

#include "penumbra/error.h"
#include "penumbra/measure.h"

namespace penumbra {
namespace {

using Jobs = std::vector<std::function<double()>>;

std::vector<TimeSummary> run(const Jobs& jobs, const TimingOptions& options) {
    Control control;
    return measure_interleaved(jobs, options, control);
}

TEST(SummariseTimes, GivesMedianAndNearestRankPercentiles) {
    std::vector<double> samples(101);
    std::iota(samples.rbegin(), samples.rend(), 0.0);
    const TimeSummary s = summarise_times(samples);
    EXPECT_EQ(s.median, 50.0);
    EXPECT_EQ(s.p10, 10.0);
    EXPECT_EQ(s.p90, 90.0);
    EXPECT_EQ(s.runs, 101);
    EXPECT_EQ(summarise_times({1.0, 2.0, 3.0, 10.0}).median, 2.5);
}

TEST(SummariseTimes, OfNothingIsZeroAndOfOneSampleThatSample) {
    EXPECT_EQ(summarise_times({}).runs, 0);
    const TimeSummary one = summarise_times({3.0});
    EXPECT_EQ(one.low, 3.0);
    EXPECT_EQ(one.median, 3.0);
    EXPECT_EQ(one.high, 3.0);
}

TEST(SummariseTimes, UsesTheWholeRangeOfFewSamplesAndTheMiddleOfMany) {
    const TimeSummary five = summarise_times({5, 1, 4, 2, 3});
    EXPECT_EQ(five.low, 1.0);
    EXPECT_EQ(five.high, 5.0);
    std::vector<double> samples(100);
    std::iota(samples.begin(), samples.end(), 1.0);
    const TimeSummary hundred = summarise_times(samples);
    EXPECT_EQ(hundred.low, 40.0);   // 50 - 9.8
    EXPECT_EQ(hundred.high, 61.0);  // 50 + 9.8, and one
}

TEST(SummariseTimes, IntervalHoldsTheTrueMedianAtLeastNinetyFivePercentOfTheTime) {
    std::mt19937 random{1};
    for (const int n : {10, 30, 60, 200}) {
        constexpr int kRounds = 20000;
        int held = 0;
        for (int round = 0; round < kRounds; ++round) {
            std::vector<double> samples(static_cast<std::size_t>(n));
            for (double& sample : samples) {  // skewed like times; its median is log 2
                sample = std::exponential_distribution<double>{1.0}(random);
            }
            const TimeSummary s = summarise_times(samples);
            held += static_cast<int>(s.low <= std::log(2.0) && std::log(2.0) <= s.high);
        }
        // Whole ranks make it conservative; 0.004 is 2.5 standard deviations of the count.
        EXPECT_GT(held / static_cast<double>(kRounds), 0.95 - 0.004) << n;
        EXPECT_LT(held / static_cast<double>(kRounds), 0.985) << n;
    }
}

TEST(MeasureInterleaved, VisitsEveryJobOncePerRoundInAnOrderThatChanges) {
    std::vector<int> visits;
    Jobs jobs;
    for (int i = 0; i < 4; ++i) {
        jobs.emplace_back([&visits, i] {
            visits.push_back(i);
            return 1.0 + static_cast<double>(visits.size() % 7);
        });
    }
    TimingOptions options;
    options.warm_up = 2;
    options.max_runs = 8;
    options.relative_interval = 0.0;
    const auto summaries = run(jobs, options);
    ASSERT_EQ(visits.size(), 40U);
    bool order_changes = false;
    for (std::size_t round = 0; round < 10; ++round) {
        const std::vector<int> order(visits.begin() + static_cast<std::ptrdiff_t>(4 * round),
                                     visits.begin() + static_cast<std::ptrdiff_t>(4 * round + 4));
        EXPECT_THAT(order, testing::UnorderedElementsAre(0, 1, 2, 3));
        order_changes = order_changes || !std::equal(order.begin(), order.end(), visits.begin());
    }
    EXPECT_TRUE(order_changes);
    EXPECT_EQ(summaries[3].runs, 8);
}

TEST(MeasureInterleaved, KeepsTheOrderOfOneSeed) {
    const auto order_of = [](std::uint32_t seed) {
        std::vector<int> visits;
        Jobs jobs;
        for (int i = 0; i < 5; ++i) {
            jobs.emplace_back([&visits, i] {
                visits.push_back(i);
                return 1.0;
            });
        }
        TimingOptions options;
        options.seed = seed;
        static_cast<void>(run(jobs, options));
        return visits;
    };
    EXPECT_EQ(order_of(1), order_of(1));
    EXPECT_NE(order_of(1), order_of(2));
}

TEST(MeasureInterleaved, StopsASteadyJobAtTheMinimumAndGoesOnWithTheOther) {
    int calls = 0;
    const Jobs jobs{[] { return 2.0; }, [&calls] { return ++calls % 2 == 0 ? 1.0 : 9.0; }};
    TimingOptions options;
    options.min_runs = 6;
    options.max_runs = 20;
    const auto summaries = run(jobs, options);
    EXPECT_EQ(summaries[0].runs, 6);
    EXPECT_EQ(summaries[0].median, 2.0);
    EXPECT_EQ(summaries[1].runs, 20);
    EXPECT_TRUE(summaries[0].tight);
    EXPECT_FALSE(summaries[1].tight);
}

TEST(MeasureInterleaved, LeavesTheWarmUpOut) {
    int calls = 0;
    const Jobs jobs{[&calls] { return ++calls <= 3 ? 1000.0 : 1.0; }};
    TimingOptions options;
    options.warm_up = 3;
    EXPECT_EQ(run(jobs, options)[0].p90, 1.0);
}

TEST(MeasureInterleaved, RunsASlowJobAtLeastOnceThoughItsTimeIsUp) {
    int calls = 0;
    const Jobs jobs{[&calls] {
        ++calls;
        std::this_thread::sleep_for(std::chrono::milliseconds{5});
        return 5.0;
    }};
    TimingOptions options;
    options.max_seconds = 1e-6;
    const auto summaries = run(jobs, options);
    EXPECT_EQ(summaries[0].runs, 1);
    EXPECT_FALSE(summaries[0].tight);
    EXPECT_EQ(calls, 2);  // one warm-up already took more than its half
}

TEST(MeasureInterleaved, RefusesLimitsThatEndNothing) {
    const Jobs jobs{[] { return 1.0; }};
    TimingOptions endless;
    endless.max_seconds = std::nan("");
    EXPECT_THROW(static_cast<void>(run(jobs, endless)), InvalidSettings);
    TimingOptions never;
    never.max_runs = 0;
    EXPECT_THROW(static_cast<void>(run(jobs, never)), InvalidSettings);
    TimingOptions past;
    past.max_seconds = -1.0;
    EXPECT_THROW(static_cast<void>(run(jobs, past)), InvalidSettings);
}

TEST(MeasureInterleaved, StopsBetweenJobsWhenCancelled) {
    Control control;
    int calls = 0;
    const Jobs jobs{[&] {
        if (++calls == 3) {
            control.cancel();
        }
        return 1.0;
    }};
    EXPECT_THROW(static_cast<void>(measure_interleaved(jobs, {}, control)), Cancelled);
    EXPECT_EQ(calls, 3);
}

TEST(MeasureInterleaved, ReportsProgressThatNeverFallsAndEndsAtOne) {
    Control control;
    float last = 0.0F;
    int calls = 0;
    const auto job = [&] {
        EXPECT_GE(control.progress(), last);
        last = control.progress();
        return 1.0 + ++calls % 5;
    };
    static_cast<void>(measure_interleaved(Jobs{job, job}, {}, control));
    EXPECT_EQ(control.progress(), 1.0F);
}

TEST(MeasureInterleaved, OfNoJobsIsEmpty) {
    EXPECT_TRUE(run({}, {}).empty());
}

}  // namespace
}  // namespace penumbra
