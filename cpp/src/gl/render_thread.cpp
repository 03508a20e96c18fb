#include "gl/render_thread.h"

#include <pthread.h>
#include <unistd.h>
#include <csignal>

#include "base/assert.h"
#include "gl/egl.h"

namespace penumbra {
namespace {

/// Signals go to the caller's threads (Ctrl-C to Python's); the driver's helper threads inherit this from ours.
class AllSignalsBlocked {
public:
    AllSignalsBlocked() {
        sigset_t all;
        sigfillset(&all);
        pthread_sigmask(SIG_SETMASK, &all, &before_);
    }
    ~AllSignalsBlocked() { pthread_sigmask(SIG_SETMASK, &before_, nullptr); }
    AllSignalsBlocked(const AllSignalsBlocked&) = delete;
    AllSignalsBlocked& operator=(const AllSignalsBlocked&) = delete;

private:
    sigset_t before_{};
};

}  // namespace

RenderThread::RenderThread(const DeviceOptions& options) : process_id_{getpid()} {
    std::promise<void> ready;
    std::future<void> started = ready.get_future();
    {
        const AllSignalsBlocked blocked;
        // The thread owns both: the constructor may be gone while set_value() still returns.
        thread_ = std::thread(
            [this, options, promise = std::move(ready)]() mutable { work_loop(options, std::move(promise)); });
    }
    try {
        started.get();
    } catch (...) {
        thread_.join();
        throw;
    }
}

RenderThread::~RenderThread() {
    if (getpid() != process_id_) {
        thread_.detach();  // it was not copied by fork(): there is nothing to wait for
        return;
    }
    {
        const std::scoped_lock lock(mutex_);
        closing_ = true;
    }
    wake_.notify_one();
    PENUMBRA_ASSERT(std::this_thread::get_id() != thread_.get_id());  // work must not own its thread
    thread_.join();
}

void RenderThread::push(std::unique_ptr<Job> job) {
    if (getpid() != process_id_) {
        throw DeviceError(
            "the process was forked after the renderer was made, and a driver does not survive that; make a new "
            "renderer in a process started by spawn");
    }
    {
        const std::scoped_lock lock(mutex_);
        jobs_.push_back(std::move(job));
    }
    wake_.notify_one();
}

void RenderThread::work_loop(const DeviceOptions& options, std::promise<void> ready) {
    pthread_setname_np(pthread_self(), "penumbra-gl");
    try {
        Context context(options);
        info_ = context.info();
        workarounds_ = decide_workarounds(info_.vendor, info_.name, info_.gl_version);
        ProgramLibrary programs;
        Device device{context, programs, workarounds_};
        device_ = &device;
        ready.set_value();

        std::unique_lock lock(mutex_);
        while (true) {
            wake_.wait(lock, [&] { return closing_ || !jobs_.empty(); });
            if (jobs_.empty()) {
                break;
            }
            {
                const std::unique_ptr<Job> job = std::move(jobs_.front());
                jobs_.pop_front();
                Device* handed = closing_ ? nullptr : &device;
                lock.unlock();
                job->run(handed);
            }  // what the work captured dies here, with the context current and the queue open
            lock.lock();
        }
    } catch (...) {
        // Only the context can throw here: jobs keep their exceptions in their futures.
        ready.set_exception(std::current_exception());
    }
    egl::release_thread();
}

}  // namespace penumbra
