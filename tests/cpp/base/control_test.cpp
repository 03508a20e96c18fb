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

TEST(Control, WithinLargerWorkHearsItsCancelAndKeepsProgressToItself) {
    Control whole;
    whole.report(0.5F);
    Control part = Control::within(whole);
    part.report(1.0F);
    EXPECT_EQ(whole.progress(), 0.5F);
    EXPECT_EQ(part.progress(), 1.0F);
    EXPECT_NO_THROW(part.check());
    whole.cancel();
    EXPECT_THROW(part.check(), Cancelled);

    Control other;
    Control stopped = Control::within(other);
    stopped.cancel();
    EXPECT_THROW(stopped.check(), Cancelled);
    EXPECT_NO_THROW(other.check());
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
