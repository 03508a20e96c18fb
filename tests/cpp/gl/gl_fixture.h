#pragma once

#include <gtest/gtest.h>

#include <memory>
#include <string>

#include "gl/render_thread.h"
#include "support/skip.h"

namespace penumbra {

/// Why there is no OpenGL here, or empty.
inline const std::string& missing_gl() {
    static const std::string reason = [] {
        std::string problem;
        for (const DeviceInfo& device : list_devices({}, &problem)) {
            if (device.usable) {
                return std::string();
            }
            problem = device.reason;
        }
        return problem.empty() ? std::string("no usable device") : problem;
    }();
    return reason;
}

/// A render thread for each test; skipped with a reason where there is no EGL. Handles must be gone at the end.
class GlTest : public testing::Test {
protected:
    void SetUp() override {
        if (!missing_gl().empty()) {
            PENUMBRA_SKIP(missing_gl());
        }
        handles_before_ = live_handle_count();
        thread_ = std::make_unique<RenderThread>();
    }
    void TearDown() override {
        if (thread_) {
            thread_.reset();
            EXPECT_EQ(live_handle_count(), handles_before_) << "OpenGL names outlive their render thread";
        }
    }
    [[nodiscard]] RenderThread& gl() { return *thread_; }

    /// The message of the exception of type E that `work` throws on the render thread; fails if it throws none.
    template <class E, class F>
    std::string message_of(F&& work) {
        try {
            gl().run(std::forward<F>(work));
        } catch (const E& error) {
            return error.what();
        }
        ADD_FAILURE() << "nothing of the expected type was thrown";
        return {};
    }

private:
    std::unique_ptr<RenderThread> thread_;
    long handles_before_ = 0;
};

}  // namespace penumbra
