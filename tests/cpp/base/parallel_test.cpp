#include "base/parallel.h"

#include <gtest/gtest.h>

#include <atomic>
#include <mutex>
#include <set>
#include <stdexcept>
#include <thread>
#include <vector>

namespace penumbra {
namespace {

/// Runs each test with a given number of threads and puts the default back.
class ParallelFor : public testing::TestWithParam<int> {
protected:
    void SetUp() override { set_thread_count(GetParam()); }
    void TearDown() override { set_thread_count(0); }
    Control control;
};
INSTANTIATE_TEST_SUITE_P(Threads, ParallelFor, testing::Values(1, 2, 3, 8));

TEST_P(ParallelFor, VisitsEveryIndexExactlyOnce) {
    for (const std::int64_t count : {0, 1, 7, 64, 1001}) {
        for (const std::int64_t grain : {-3, 0, 1, 5, 64, 5000}) {
            std::vector<std::atomic<int>> visits(static_cast<std::size_t>(count));
            parallel_for(
                count, grain,
                [&](std::int64_t begin, std::int64_t end) {
                    for (std::int64_t i = begin; i < end; ++i) {
                        ++visits[i];
                    }
                },
                control);
            for (const auto& visit : visits) {
                ASSERT_EQ(visit, 1) << "count " << count << ", grain " << grain;
            }
        }
    }
}

TEST_P(ParallelFor, GivesNoPieceLongerThanTheGrain) {
    parallel_for(
        1000, 33, [](std::int64_t begin, std::int64_t end) { EXPECT_LE(end - begin, 33); }, control);
}

TEST_P(ParallelFor, UsesNoMoreThreadsThanItWasGiven) {
    std::set<std::thread::id> seen;
    std::mutex mutex;
    parallel_for(
        200, 1,
        [&](std::int64_t, std::int64_t) {
            const std::scoped_lock lock{mutex};
            seen.insert(std::this_thread::get_id());
        },
        control);
    EXPECT_LE(seen.size(), static_cast<std::size_t>(GetParam()));
}

TEST_P(ParallelFor, PassesOnTheExceptionOfABodyAndStartsNoFurtherPiecesOfItsOwn) {
    std::atomic<int> pieces{0};
    const auto run = [&] {
        parallel_for(
            1000000, 1,
            [&](std::int64_t, std::int64_t) {
                ++pieces;
                throw std::runtime_error("broken");
            },
            control);
    };
    EXPECT_THROW(run(), std::runtime_error);
    EXPECT_LE(pieces, GetParam());
}

TEST_P(ParallelFor, StopsWithCancelledSoonAfterCancel) {
    std::atomic<int> pieces{0};
    const auto run = [&] {
        parallel_for(
            1000000, 1,
            [&](std::int64_t, std::int64_t) {
                if (++pieces == 10) {
                    control.cancel();
                }
            },
            control);
    };
    EXPECT_THROW(run(), Cancelled);
    EXPECT_LT(pieces, 1000000);
}

TEST_P(ParallelFor, ACancelledControlStopsBeforeTheFirstPiece) {
    control.cancel();
    const auto run = [&] {
        parallel_for(
            5, 1, [](std::int64_t, std::int64_t) { FAIL(); }, control);
    };
    EXPECT_THROW(run(), Cancelled);
}

TEST_P(ParallelFor, NestsWithoutDeadlock) {
    std::atomic<int> visits{0};
    parallel_for(
        4, 1,
        [&](std::int64_t, std::int64_t) {
            parallel_for(
                4, 1, [&](std::int64_t begin, std::int64_t end) { visits += static_cast<int>(end - begin); }, control);
        },
        control);
    EXPECT_EQ(visits, 16);
}

TEST(ThreadCount, IsAtLeastOneAndFollowsTheSetter) {
    EXPECT_GE(thread_count(), 1);
    set_thread_count(5);
    EXPECT_EQ(thread_count(), 5);
    set_thread_count(0);
    EXPECT_GE(thread_count(), 1);
}

}  // namespace
}  // namespace penumbra
