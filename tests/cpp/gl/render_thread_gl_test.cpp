#include "gl/render_thread.h"

#include <sys/wait.h>
#include <unistd.h>

#include <atomic>
#include <chrono>
#include <vector>

#include "gl_fixture.h"
#include "penumbra/control.h"
#include "support/skip.h"

namespace penumbra {
namespace {

class RenderThreadGl : public GlTest {};

TEST_F(RenderThreadGl, WorkIsDoneInTheOrderOfSubmission) {
    std::vector<int> order;
    std::vector<std::future<void>> futures;
    for (int i = 0; i < 100; ++i) {
        futures.push_back(gl().submit([&order, i](Device&) { order.push_back(i); }));
    }
    for (std::future<void>& future : futures) {
        future.get();
    }
    for (int i = 0; i < 100; ++i) {
        ASSERT_EQ(order.at(static_cast<std::size_t>(i)), i);
    }
}

TEST_F(RenderThreadGl, ExceptionsTravelWithTheirTypeAndWorkGoesOnAfterwards) {
    EXPECT_THROW(gl().run([](Device&) { throw InvalidScene("bad"); }), InvalidScene);
    EXPECT_THROW(gl().run([](Device&) -> int { throw OutOfMemory("bad"); }), OutOfMemory);
    EXPECT_EQ(gl().run([](Device&) { return 7; }), 7);
}

TEST_F(RenderThreadGl, WorkAndResultsNeedNotBeCopyable) {
    auto owned = std::make_unique<int>(5);
    const std::unique_ptr<int> back = gl().run([p = std::move(owned)](Device&) mutable { return std::move(p); });
    EXPECT_EQ(*back, 5);
}

TEST_F(RenderThreadGl, RunFromInsideRunsAtOnce) {
    EXPECT_EQ(gl().run([&](Device&) { return gl().run([](Device&) { return 3; }) + 1; }), 4);
}

TEST_F(RenderThreadGl, TwoThreadsWorkAtOnce) {
    RenderThread other;
    std::atomic<int> inside{0};
    const auto meet = [&](Device& device) {
        // Ends only if both are inside at the same time.
        ++inside;
        while (inside < 2) {
            std::this_thread::yield();
        }
        return device.context.info().name;
    };
    std::future<std::string> first = gl().submit(meet);
    std::future<std::string> second = other.submit(meet);
    ASSERT_EQ(first.wait_for(std::chrono::seconds(60)), std::future_status::ready);
    EXPECT_EQ(first.get(), second.get());
}

TEST_F(RenderThreadGl, CancelStopsWorkThatChecks) {
    Control control;
    std::future<void> work = gl().submit([&](Device&) {
        while (true) {
            control.report(0.5F);
            control.check();
            std::this_thread::yield();
        }
    });
    while (control.progress() < 0.5F) {
        std::this_thread::yield();
    }
    control.cancel();
    EXPECT_THROW(work.get(), Cancelled);
}

TEST_F(RenderThreadGl, WhatStillWaitsWhenItEndsIsCancelled) {
    auto thread = std::make_unique<RenderThread>();
    std::atomic<bool> started{false};
    std::atomic<bool> go{false};
    std::future<void> running = thread->submit([&](Device&) {
        started = true;
        while (!go) {
            std::this_thread::yield();
        }
    });
    while (!started) {
        std::this_thread::yield();
    }
    std::future<void> waiting = thread->submit([](Device&) { ADD_FAILURE() << "must not run"; });
    std::thread closer([&] { thread.reset(); });
    std::this_thread::sleep_for(std::chrono::milliseconds(50));  // lets the destructor begin
    go = true;
    closer.join();
    EXPECT_NO_THROW(running.get());
    EXPECT_THROW(waiting.get(), Cancelled);
}

TEST_F(RenderThreadGl, WhatWorkCapturesDiesOnTheRenderThread) {
    struct Witness {
        std::thread::id* died_on;
        explicit Witness(std::thread::id* out) : died_on{out} {}
        ~Witness() { *died_on = std::this_thread::get_id(); }
    };
    std::thread::id died_on;
    const auto id = gl().run([w = std::make_unique<Witness>(&died_on)](Device&) { return std::this_thread::get_id(); });
    EXPECT_EQ(died_on, id);
}

TEST_F(RenderThreadGl, AForkedChildIsToldAndEndsWithoutHanging) {
    const pid_t child = fork();
    ASSERT_GE(child, 0);
    if (child == 0) {
        int status = 1;
        try {
            gl().run([](Device&) {});
        } catch (const DeviceError&) {
            status = 0;
        } catch (...) {
            status = 2;
        }
        _exit(status);
    }
    int status = -1;
    ASSERT_EQ(waitpid(child, &status, 0), child);
    EXPECT_TRUE(WIFEXITED(status));
    EXPECT_EQ(WEXITSTATUS(status), 0);
    EXPECT_EQ(gl().run([](Device&) { return 1; }), 1);
}

TEST(RenderThreadExit, AProcessThatLeavesOneAliveEndsCleanly) {
    if (!missing_gl().empty()) {
        PENUMBRA_SKIP(missing_gl());
    }
    testing::GTEST_FLAG(death_test_style) = "threadsafe";
    EXPECT_EXIT(
        {
            static auto* const leaked = new RenderThread;
            leaked->run([](Device&) { check_gl("leaked"); });
            std::exit(0);
        },
        testing::ExitedWithCode(0), "");
    EXPECT_EXIT(
        {
            static RenderThread dies_at_exit;
            dies_at_exit.run([](Device&) { check_gl("static"); });
            std::exit(0);
        },
        testing::ExitedWithCode(0), "");
}

}  // namespace
}  // namespace penumbra
