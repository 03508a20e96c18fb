#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstddef>
#include <random>
#include <span>
#include <string>

#include "measure/percentile.h"
#include "penumbra/error.h"
#include "penumbra/measure.h"

namespace penumbra {

namespace {

double median_of_sorted(const std::vector<double>& sorted) noexcept {
    const std::size_t middle = sorted.size() / 2;
    return sorted.size() % 2 == 1 ? sorted[middle] : 0.5 * (sorted[middle - 1] + sorted[middle]);
}

struct JobState {
    std::vector<double> samples_ms;
    TimeSummary summary;
    int warm_ups = 0;
    double seconds = 0.0;  ///< spent on this job, warm-up included
    bool done = false;
};

bool is_tight(const TimeSummary& summary, const TimingOptions& options) noexcept {
    return summary.runs >= options.min_runs && summary.high - summary.low <= options.relative_interval * summary.median;
}

bool needs_warm_up(const JobState& job, const TimingOptions& options) noexcept {
    return job.warm_ups < options.warm_up && job.seconds <= 0.5 * options.max_seconds;
}

void run_once(const std::function<double()>& job, JobState& state, const TimingOptions& options) {
    const bool warm_up = needs_warm_up(state, options);
    const auto begin = std::chrono::steady_clock::now();
    const double measured_ms = job();
    state.seconds += std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
    if (warm_up) {
        ++state.warm_ups;
        return;
    }
    state.samples_ms.push_back(measured_ms);
    state.summary = summarise_times(state.samples_ms);
    state.summary.tight = is_tight(state.summary, options);
    state.done = state.summary.tight || state.summary.runs >= options.max_runs || state.seconds >= options.max_seconds;
}

double share_done(const JobState& state, const TimingOptions& options) noexcept {
    if (state.done) {
        return 1.0;
    }
    const double by_runs = static_cast<double>(state.summary.runs) / std::max(1, options.max_runs);
    const double by_time = options.max_seconds > 0.0 ? state.seconds / options.max_seconds : 0.0;
    return std::min(1.0, std::max(by_runs, by_time));
}

void check(const TimingOptions& options) {
    if (!(options.max_seconds >= 0.0)) {  // not a number: no run would ever be the last
        throw InvalidSettings{"timing: max_seconds is " + std::to_string(options.max_seconds) + "; give 0 or more"};
    }
    if (options.min_runs < 1 || options.max_runs < 1) {
        throw InvalidSettings{"timing: from " + std::to_string(options.min_runs) + " to " +
                              std::to_string(options.max_runs) + " runs; give 1 or more"};
    }
}

/// Fisher-Yates with a generator and a mapping that the standard fixes, so that a seed means one order everywhere.
void shuffle(std::vector<std::size_t>& order, std::mt19937& random) {
    for (std::size_t i = order.size(); i > 1; --i) {
        std::swap(order[i - 1], order[random() % i]);
    }
}

}  // namespace

TimeSummary summarise_times(std::vector<double> samples_ms) {
    TimeSummary summary;
    if (samples_ms.empty()) {
        return summary;
    }
    std::ranges::sort(samples_ms);
    const auto n = static_cast<double>(samples_ms.size());
    // How many of n samples fall below the median is binomial(n, 1/2): its standard deviation is sqrt(n) / 2, 1.96 of
    // those either side hold 95 %, and a half corrects for whole ranks. Five samples or fewer give their whole range,
    // which holds 94 % at best.
    const double low_rank = std::max(1.0, std::floor(0.5 * n - 0.98 * std::sqrt(n) + 0.5));
    const double high_rank = n + 1.0 - low_rank;
    summary.low = samples_ms[static_cast<std::size_t>(low_rank) - 1];
    summary.high = samples_ms[static_cast<std::size_t>(high_rank) - 1];
    summary.median = median_of_sorted(samples_ms);
    summary.p10 = percentile(std::span{samples_ms}, 0.10);
    summary.p90 = percentile(std::span{samples_ms}, 0.90);
    summary.runs = static_cast<int>(samples_ms.size());
    return summary;
}

std::vector<TimeSummary> measure_interleaved(std::span<const std::function<double()>> jobs,
                                             const TimingOptions& options, Control& control) {
    check(options);
    std::vector<JobState> states(jobs.size());
    std::mt19937 random{options.seed};
    for (;;) {
        std::vector<std::size_t> order;
        for (std::size_t i = 0; i < states.size(); ++i) {
            if (!states[i].done) {
                order.push_back(i);
            }
        }
        if (order.empty()) {
            break;
        }
        shuffle(order, random);
        for (const std::size_t i : order) {
            control.check();
            run_once(jobs[i], states[i], options);
            double done = 0.0;
            for (const JobState& state : states) {
                done += share_done(state, options);
            }
            control.report(static_cast<float>(done / static_cast<double>(states.size())));
        }
    }
    std::vector<TimeSummary> summaries;
    summaries.reserve(states.size());
    for (const JobState& state : states) {
        summaries.push_back(state.summary);
    }
    return summaries;
}

}  // namespace penumbra
