#pragma once

#include <condition_variable>
#include <deque>
#include <future>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <type_traits>
#include <utility>

#include "gl/context.h"
#include "gl/program.h"
#include "gl/workarounds.h"
#include "penumbra/error.h"

namespace penumbra {

/// What work on the render thread finds there.
struct Device {
    Context& context;
    ProgramLibrary& programs;
    const Workarounds& workarounds;
};

/// One thread with one OpenGL context, on which all OpenGL of ours runs. Work is done in the order it was submitted.
/// Objects that own OpenGL names are made and destroyed inside submitted work.
///
/// Two of them may live in one process. A RenderThread does not survive fork(): in the child every call throws.
/// Work is cancelled through a Control (penumbra/control.h) that the work itself checks.
class RenderThread {
public:
    /// Returns once the context stands. @throws DeviceError as Context
    explicit RenderThread(const DeviceOptions& options = {});
    /// Lets the work that is being done finish (cancel it first if that may take long); what still waits fails with
    /// Cancelled. Then context and thread end.
    ~RenderThread();
    RenderThread(const RenderThread&) = delete;
    RenderThread& operator=(const RenderThread&) = delete;

    /// @param work called as work(Device&) on the render thread; need not be copyable
    ///        What it captured is gone, on the render thread, before the result can be seen.
    /// @return its result or its exception; OpenGL errors that it leaves behind become its exception. After the context
    ///         was lost all work fails with DeviceError at once.
    template <class F>
    auto submit(F&& work) -> std::future<std::invoke_result_t<std::decay_t<F>&, Device&>> {
        using Work = std::decay_t<F>;
        auto job = std::make_unique<JobOf<Work>>(std::forward<F>(work));
        auto future = job->promise.get_future();
        push(std::move(job));
        return future;
    }

    /// submit() and wait. Called on the render thread itself it runs at once.
    template <class F>
    auto run(F&& work) -> std::invoke_result_t<std::decay_t<F>&, Device&> {
        if (std::this_thread::get_id() == thread_.get_id()) {
            return work(*device_);
        }
        return submit(std::forward<F>(work)).get();
    }

    /// Of the device in use; never changes, may be read from any thread.
    [[nodiscard]] const DeviceInfo& info() const noexcept { return info_; }
    [[nodiscard]] const Workarounds& workarounds() const noexcept { return workarounds_; }

private:
    struct Job {
        virtual ~Job() = default;
        /// @param device nullptr: the thread is closing
        virtual void run(Device* device) = 0;
    };

    // No std::packaged_task: it would keep the work, and what the work captured, as long as the caller's future.
    template <class Work>
    struct JobOf final : Job {
        using Result = std::invoke_result_t<Work&, Device&>;
        static_assert(!std::is_reference_v<Result>, "results leave the render thread by value");

        explicit JobOf(Work w) : work(std::move(w)) {}

        void run(Device* device) override {
            Work& mine = *work;  // NOLINT(bugprone-unchecked-optional-access): full until run(), which is called once
            try {
                if constexpr (std::is_void_v<Result>) {
                    guarded(mine, device);
                    work.reset();
                    promise.set_value();
                } else {
                    Result result = guarded(mine, device);
                    work.reset();
                    promise.set_value(std::move(result));
                }
            } catch (...) {
                work.reset();
                promise.set_exception(std::current_exception());
            }
        }

        std::optional<Work> work;
        std::promise<Result> promise;
    };

    template <class Work>
    static auto guarded(Work& work, Device* device) -> std::invoke_result_t<Work&, Device&> {
        if (device == nullptr) {
            throw Cancelled{};
        }
        device->context.throw_if_lost();
        try {
            if constexpr (std::is_void_v<std::invoke_result_t<Work&, Device&>>) {
                work(*device);
                device->context.check("work on the render thread");
            } else {
                auto result = work(*device);
                device->context.check("work on the render thread");
                return result;
            }
        } catch (...) {
            device->context.discard_errors();  // the next work is not to be blamed for them
            throw;
        }
    }

    void push(std::unique_ptr<Job> job);
    void work_loop(const DeviceOptions& options, std::promise<void> ready);

    DeviceInfo info_;
    Workarounds workarounds_;
    Device* device_ = nullptr;  ///< on the render thread's stack
    int process_id_ = 0;
    std::mutex mutex_;
    std::condition_variable wake_;
    std::deque<std::unique_ptr<Job>> jobs_;
    bool closing_ = false;
    std::thread thread_;
};

}  // namespace penumbra
