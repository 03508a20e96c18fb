#pragma once

#include <chrono>
#include <string>
#include <string_view>
#include <vector>

#include "gl/context.h"
#include "gl/handles.h"

namespace penumbra {

struct StepTime {
    std::string name;
    double ms = 0.0;
};

/// Times the steps of a frame, one after the other, never nested. On hardware by pairs of GPU timestamps that are read
/// only in collect(), so that measuring does not stall; with `wall_clock` by the CPU's clock around glFinish, because a
/// software rasteriser's queries measure little (Workarounds::time_by_wall_clock).
class StepClock {
public:
    explicit StepClock(bool wall_clock) : wall_clock_{wall_clock} {}

    /// Off: begin and end cost nothing and collect() is empty. On at first.
    void enable(bool on) noexcept { enabled_ = on; }
    [[nodiscard]] bool enabled() const noexcept { return enabled_; }

    void begin(std::string_view name);
    void end();

    /// Steps since the last collect(), in the order they began; a name used twice stands twice. Waits for the GPU.
    [[nodiscard]] std::vector<StepTime> collect();

    /// begin() now, end() at the end of the block, also when an exception leaves it.
    class Scope {
    public:
        Scope(StepClock& clock, std::string_view name) : clock_{clock} { clock_.begin(name); }
        ~Scope() { clock_.end(); }
        Scope(const Scope&) = delete;
        Scope& operator=(const Scope&) = delete;

    private:
        StepClock& clock_;
    };
    [[nodiscard]] Scope scope(std::string_view name) { return {*this, name}; }

    /// begin(name), work(), end(), check_gl(name): a step as it should be.
    template <class F>
    void step(std::string_view name, const F& work) {
        {
            const Scope timed(*this, name);
            work();
        }
        check_gl(name);
    }

private:
    struct Measured {
        std::string name;
        Query begin, end;                               ///< hardware
        std::chrono::steady_clock::time_point started;  ///< wall clock
        double ms = 0.0;
    };
    [[nodiscard]] Query timestamp();

    bool wall_clock_;
    bool enabled_ = true;
    bool open_ = false;
    std::vector<Measured> steps_;
    std::vector<Query> spare_;
};

}  // namespace penumbra
