#pragma once

#include <condition_variable>
#include <deque>
#include <functional>
#include <future>
#include <memory>
#include <mutex>
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
    /// @return its result or its exception; OpenGL errors that it leaves behind become its exception. After the context
    ///         was lost all work fails with DeviceError at once.
    template <class F>
    auto submit(F&& work) -> std::future<std::invoke_result_t<std::decay_t<F>&, Device&>> {
        using Result = std::invoke_result_t<std::decay_t<F>&, Device&>;
        std::packaged_task<Result(Device*)> task(
            [f = std::forward<F>(work)](Device* device) mutable -> Result { return guarded<Result>(f, device); });
        auto future = task.get_future();
        push([t = std::move(task)](Device* device) mutable { t(device); });
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
    using Job = std::packaged_task<void(Device*)>;  ///< nullptr: the thread is closing

    template <class Result, class F>
    static Result guarded(F& work, Device* device) {
        if (device == nullptr) {
            throw Cancelled{};
        }
        device->context.throw_if_lost();
        try {
            if constexpr (std::is_void_v<Result>) {
                work(*device);
                device->context.check("work on the render thread");
            } else {
                Result result = work(*device);
                device->context.check("work on the render thread");
                return result;
            }
        } catch (...) {
            device->context.discard_errors();  // the next work is not to be blamed for them
            throw;
        }
    }

    template <class F>
    void push(F&& job) {
        push_job(Job(std::forward<F>(job)));
    }
    void push_job(Job job);
    void work_loop(const DeviceOptions& options, std::promise<void> ready);

    DeviceInfo info_;
    Workarounds workarounds_;
    Device* device_ = nullptr;  ///< on the render thread's stack
    int process_id_ = 0;
    std::mutex mutex_;
    std::condition_variable wake_;
    std::deque<Job> jobs_;
    bool closing_ = false;
    std::thread thread_;
};

}  // namespace penumbra
