#pragma once

#include <cstdint>
#include <functional>

#include "penumbra/control.h"

namespace penumbra {

/// Threads that parallel_for uses, the caller included: PENUMBRA_THREADS, else the cores this process may use.
[[nodiscard]] int thread_count() noexcept;

/// Lets parallel_for use exactly this many threads from now on, 0: thread_count()'s own choice again. For tests that
/// compare thread counts, and for hosts that share the machine. Any thread may call it.
void set_thread_count(int count) noexcept;

/// Calls body(begin, end) over [0, count) in pieces of at most `grain`, on thread_count() threads, and returns when
/// all are done. Which thread gets which piece varies, so a body must depend on its indices alone.
/// Checks `control` before each piece. @throws Cancelled, or the first exception of a body.
void parallel_for(std::int64_t count, std::int64_t grain, const std::function<void(std::int64_t, std::int64_t)>& body,
                  Control& control);

}  // namespace penumbra
