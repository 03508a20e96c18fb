#include "base/parallel.h"

#include <sched.h>

#include <algorithm>
#include <cstdlib>
#include <exception>
#include <mutex>
#include <thread>
#include <vector>

namespace penumbra {

namespace {

int cores_of_this_process() noexcept {
    cpu_set_t set;
    CPU_ZERO(&set);
    if (sched_getaffinity(0, sizeof(set), &set) == 0) {
        return std::max(1, CPU_COUNT(&set));
    }
    return static_cast<int>(std::max(1U, std::thread::hardware_concurrency()));
}

int chosen_thread_count() noexcept {
    if (const char* text = std::getenv("PENUMBRA_THREADS")) {
        const long wanted = std::strtol(text, nullptr, 10);
        if (wanted >= 1) {
            return static_cast<int>(std::min(wanted, 1024L));
        }
    }
    return cores_of_this_process();
}

std::atomic<int> set_count{0};

}  // namespace

int thread_count() noexcept {
    static const int count = chosen_thread_count();
    const int set = set_count.load(std::memory_order_relaxed);
    return set > 0 ? set : count;
}

void set_thread_count(int count) noexcept {
    set_count.store(std::clamp(count, 0, 1024), std::memory_order_relaxed);
}

void parallel_for(std::int64_t count, std::int64_t grain, const std::function<void(std::int64_t, std::int64_t)>& body,
                  Control& control) {
    grain = std::max<std::int64_t>(1, grain);
    std::atomic<std::int64_t> next{0};
    std::exception_ptr first_error;
    std::mutex error_mutex;
    const auto work = [&] {
        try {
            for (;;) {
                control.check();
                const std::int64_t begin = next.fetch_add(grain, std::memory_order_relaxed);
                if (begin >= count) {
                    return;
                }
                body(begin, std::min(count, begin + grain));
            }
        } catch (...) {
            const std::scoped_lock lock{error_mutex};
            if (!first_error) {
                first_error = std::current_exception();
            }
            next.store(count, std::memory_order_relaxed);
        }
    };
    const std::int64_t pieces = (count + grain - 1) / grain;
    const auto helpers = std::min<std::int64_t>(thread_count() - 1, pieces - 1);
    {
        std::vector<std::jthread> threads;
        threads.reserve(static_cast<std::size_t>(std::max<std::int64_t>(helpers, 0)));
        for (std::int64_t i = 0; i < helpers; ++i) {
            threads.emplace_back(work);
        }
        work();
    }
    if (first_error) {
        std::rethrow_exception(first_error);
    }
}

}  // namespace penumbra
