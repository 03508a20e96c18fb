#pragma once

#include <atomic>

#include "penumbra/error.h"

namespace penumbra {

/// Shared between the one who waits and the one who works: the first asks to stop, the second tells how far it is.
/// Both sides may call from any thread.
class Control {
public:
    Control() = default;
    /// For a piece of larger work: hears the cancel of `whole` too and keeps its progress to itself. `whole` outlives
    /// it.
    [[nodiscard]] static Control within(const Control& whole) noexcept { return Control{&whole}; }

    /// Asks the work to stop at its next check; idempotent.
    void cancel() noexcept { cancelled_.store(true, std::memory_order_relaxed); }
    [[nodiscard]] bool cancelled() const noexcept {
        return cancelled_.load(std::memory_order_relaxed) || (whole_ != nullptr && whole_->cancelled());
    }

    /// Called by the work at least ten times a second. @throws Cancelled once cancel() was called.
    void check() const {
        if (cancelled()) {
            throw Cancelled{};
        }
    }

    /// @param fraction share of the work that is done, 0 .. 1
    void report(float fraction) noexcept { progress_.store(fraction, std::memory_order_relaxed); }
    [[nodiscard]] float progress() const noexcept { return progress_.load(std::memory_order_relaxed); }

private:
    explicit Control(const Control* whole) noexcept : whole_{whole} {}

    const Control* whole_ = nullptr;
    std::atomic<bool> cancelled_{false};
    std::atomic<float> progress_{0.0F};
};

}  // namespace penumbra
