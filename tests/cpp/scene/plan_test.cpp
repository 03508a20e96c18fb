#include "penumbra/plan.h"

#include <gtest/gtest.h>

namespace penumbra {
namespace {

TEST(Plan, KeepsStepsInTheOrderTheyWereDecided) {
    Plan plan;
    plan.run("depth map, face +x");
    plan.leave_out("depth map, face -x", "face_without_receivers", "no receiver lies in it", 0.0);
    plan.run("lookup");
    ASSERT_EQ(plan.steps.size(), 3U);
    EXPECT_EQ(plan.steps[1].rule, "face_without_receivers");
    EXPECT_EQ(plan.steps[1].reason, "no receiver lies in it");
    EXPECT_TRUE(plan.steps[2].run);
}

TEST(Plan, RunsOnlyWhatIsNeitherLeftOutNorUnknown) {
    Plan plan;
    plan.run("lookup");
    plan.leave_out("depth map", "rule", "reason");
    EXPECT_TRUE(plan.runs("lookup"));
    EXPECT_FALSE(plan.runs("depth map"));
    EXPECT_FALSE(plan.runs("unknown"));
}

TEST(Plan, AddsTimesOfStepsThatRunAndIgnoresOthers) {
    Plan plan;
    plan.leave_out("depth map", "rule", "reason");
    plan.run("lookup");
    plan.add_time("lookup", 1.5);
    plan.add_time("lookup", 0.5);
    plan.add_time("depth map", 9.0);
    plan.add_time("unknown", 9.0);
    EXPECT_EQ(plan.steps[0].time_ms, 0.0);
    EXPECT_EQ(plan.steps[1].time_ms, 2.0);
}

}  // namespace
}  // namespace penumbra
