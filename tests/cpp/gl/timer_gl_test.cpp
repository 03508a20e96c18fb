#include "gl/timer.h"

#include "gl/framebuffer.h"
#include "gl_fixture.h"

namespace penumbra {
namespace {

class TimerGl : public GlTest {
protected:
    /// Work that takes a time one can see: clears of a large target.
    static void work() {
        TextureImage image = TextureImage::make_2d(GL_RGBA32F, 1024, 1024, "load");
        for (int i = 0; i < 4; ++i) {
            image.clear(glm::vec4(static_cast<float>(i)));
        }
    }
};

TEST_F(TimerGl, StepsComeInOrderWithPositiveTimes) {
    gl().run([](Device& device) {
        StepClock clock(device.workarounds.time_by_wall_clock);
        clock.begin("first");
        work();
        clock.end();
        clock.step("second", work);
        const std::vector<StepTime> times = clock.collect();
        ASSERT_EQ(times.size(), 2U);
        EXPECT_EQ(times[0].name, "first");
        EXPECT_EQ(times[1].name, "second");
        EXPECT_GT(times[0].ms, 0.0);
        EXPECT_GT(times[1].ms, 0.0);
        EXPECT_TRUE(clock.collect().empty());
    });
}

TEST_F(TimerGl, TimestampsAreReadOnlyAtCollectAndTheirQueriesUsedAgain) {
    gl().run([](Device&) {
        StepClock clock(false);  // the way of hardware, which a software driver can walk too
        const long before = live_handle_count();
        for (int frame = 0; frame < 3; ++frame) {
            clock.begin("a");
            work();
            clock.end();
            clock.begin("b");
            clock.end();
            const std::vector<StepTime> times = clock.collect();
            ASSERT_EQ(times.size(), 2U);
            EXPECT_GE(times[0].ms, 0.0);
            EXPECT_EQ(live_handle_count(), before + 4);
        }
    });
}

TEST_F(TimerGl, SwitchedOffItMeasuresNothing) {
    gl().run([](Device&) {
        StepClock clock(true);
        clock.enable(false);
        clock.step("a", [] {});
        EXPECT_TRUE(clock.collect().empty());
    });
}

TEST_F(TimerGl, AStepThatThrowsIsClosed) {
    gl().run([](Device&) {
        StepClock clock(true);
        EXPECT_THROW(clock.step("a", [] { throw InvalidScene("no"); }), InvalidScene);
        EXPECT_THROW(clock.step("b", [] { glEnable(GL_TEXTURE_2D_ARRAY); }), DeviceError);
        EXPECT_EQ(clock.collect().size(), 2U);
    });
}

}  // namespace
}  // namespace penumbra
