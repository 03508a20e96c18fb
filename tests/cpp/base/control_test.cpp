#include "penumbra/control.h"

#include <gtest/gtest.h>

namespace penumbra {
namespace {

TEST(Control, CheckPassesUntilItIsCancelledAndThenThrowsEachTime) {
    Control control;
    EXPECT_NO_THROW(control.check());
    control.cancel();
    control.cancel();
    EXPECT_THROW(control.check(), Cancelled);
    EXPECT_THROW(control.check(), Cancelled);
}

TEST(Control, ProgressIsWhatWasReportedLast) {
    Control control;
    EXPECT_EQ(control.progress(), 0.0F);
    control.report(0.25F);
    EXPECT_EQ(control.progress(), 0.25F);
}

TEST(Control, CancelledIsAnErrorOfOurs) {
    try {
        throw Cancelled{};
    } catch (const Error& error) {
        EXPECT_STREQ(error.what(), "cancelled");
    }
}

}  // namespace
}  // namespace penumbra
