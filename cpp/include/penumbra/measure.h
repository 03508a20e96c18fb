#pragma once

#include <cstdint>
#include <functional>
#include <span>
#include <string>
#include <vector>

#include "penumbra/control.h"

namespace penumbra {

/// Errors of V against the reference over the mask; every figure is in units of V (0 .. 1) unless said otherwise.
/// Definitions: docs/measuring.md.
struct ErrorSummary {
    std::uint64_t pixels = 0;           ///< in the mask
    std::uint64_t penumbra_pixels = 0;  ///< 1e-4 < reference < 1 - 1e-4
    std::uint64_t non_finite = 0;  ///< values of V in the mask that were NaN or infinite; each counts as an error of 1
    double rmse = 0.0, mae = 0.0, bias = 0.0, p95 = 0.0, p99 = 0.0, max = 0.0;
    double penumbra_rmse = 0.0;   ///< the headline figure
    double leak = 0.0;            ///< mean V in the umbra
    double over_darkening = 0.0;  ///< mean 1 - V where fully lit
    /// Pixels of the mean image with 0.1 < V < 0.9 over those of the reference: in a band of parallel edges the ratio
    /// of widths, robust to noise and to edges that cross. 0 for hard shadows, and if the reference has no such pixel.
    double penumbra_width_ratio = 0.0;
    double reference_standard_error = 0.0;  ///< RMS of the reference's own over the mask
    bool within_reference_noise = false;    ///< rmse <= reference_standard_error

    /// Parts of the mean square error over the mask; they add up to rmse^2.
    struct Parts {
        double noise = 0.0;           ///< variance over seeds
        double leak = 0.0;            ///< error in the umbra
        double over_darkening = 0.0;  ///< error where fully lit
        double bias = 0.0;            ///< penumbra: systematic in V_reference (wrong profile)
        double aliasing = 0.0;        ///< penumbra: what is left (position dependent: staircase, acne, structure)
    } parts;
    std::string dominant;  ///< "noise", "leak", "over_darkening", "bias", "aliasing" or "none"
    std::string sentence;  ///< what dominates, with numbers, for the report
};

/// @param visibility one image per seed (at least one), each of reference.size() entries. With a single image there is
///        no variance to see: `noise` is 0 and what noise there is counts as aliasing
/// @param standard_error of the reference, per pixel; may be empty (exact)
/// @param mask 0 leaves the pixel out; an empty mask image-wide gives zeros and `dominant` "none"
/// @param width pixels per row
/// @throws Error if sizes disagree, or for a reference or standard error in the mask that is not finite
[[nodiscard]] ErrorSummary measure_errors(std::span<const std::span<const float>> visibility,
                                          std::span<const float> reference, std::span<const float> standard_error,
                                          std::span<const std::uint8_t> mask, int width);

struct TimeSummary {
    double median = 0.0, p10 = 0.0, p90 = 0.0;  ///< milliseconds
    double low = 0.0, high = 0.0;               ///< 95 % confidence interval of the median
    int runs = 0;
    bool tight = false;  ///< measure_interleaved() alone: it ended because the interval was narrow enough
};
[[nodiscard]] TimeSummary summarise_times(std::vector<double> samples_ms);

struct TimingOptions {
    int warm_up = 2;
    int min_runs = 5;
    int max_runs = 200;
    double max_seconds = 4.0;         ///< per job, soft: a run that has begun ends
    double relative_interval = 0.05;  ///< stop when (high - low) / median is below this
    std::uint32_t seed = 1;           ///< of the interleaving
};

/// Runs the jobs interleaved in random order until each one's median is tight or its cap is reached, so that drift
/// hits all alike. Each job returns the milliseconds it measured itself.
/// @throws InvalidSettings for limits below 0 (runs: 1) or not a number
[[nodiscard]] std::vector<TimeSummary> measure_interleaved(std::span<const std::function<double()>> jobs,
                                                           const TimingOptions& options, Control& control);

/// Marks the records that no other beats in both error and time; equal points are all kept.
[[nodiscard]] std::vector<bool> pareto_front(std::span<const double> times_ms, std::span<const double> errors);

}  // namespace penumbra
