#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <sstream>
#include <string>

#include "measure/classes.h"
#include "measure/edge_zone.h"
#include "measure/percentile.h"
#include "measure/sentence.h"
#include "penumbra/error.h"
#include "penumbra/measure.h"

// One pass gathers per pixel the mean error over seeds and its variance; the mean square error then splits as
//
//   (1/n) sum_s mean_p e_s^2  =  mean_p b_p^2 + mean_p var_p
//
// with b the error of an infinitely long average. The mean over n seeds still holds var/n of noise, so var/n is taken
// off its square, which leaves an unbiased estimate of b^2 and, for the noise, exactly the unbiased variance.
// In the penumbra b^2 splits once more, orthogonally, into the conditional mean given the reference (a wrong profile)
// and the rest (structure). Definitions for readers: docs/measuring.md. Source: [Pharr2023], section 2.1.

namespace penumbra {

namespace {

constexpr std::size_t kBins = 32;
constexpr double kSoftLow = 0.1;
constexpr double kSoftHigh = 0.9;

/// Sums over one set of pixels.
struct Sums {
    std::uint64_t pixels = 0;
    double reference = 0.0;
    double mean_error = 0.0;         ///< of the seeds' mean
    double mean_error_square = 0.0;  ///< of the seeds' mean
    double variance = 0.0;           ///< unbiased, over seeds
    double square = 0.0;             ///< of all seeds, divided by their number

    void add(double truth, double error, double pixel_variance, double pixel_square) noexcept {
        ++pixels;
        reference += truth;
        mean_error += error;
        mean_error_square += error * error;
        variance += pixel_variance;
        square += pixel_square;
    }
};

std::string place(std::size_t pixel, int width) {
    std::ostringstream out;
    out << "column " << pixel % static_cast<std::size_t>(width) << ", row " << pixel / static_cast<std::size_t>(width);
    return out.str();
}

void check_sizes(std::span<const std::span<const float>> visibility, std::span<const float> reference,
                 std::span<const float> standard_error, std::span<const std::uint8_t> mask, int width) {
    std::ostringstream out;
    if (visibility.empty()) {
        throw Error{"no visibility image to measure; give at least one"};
    }
    for (std::size_t s = 0; s < visibility.size(); ++s) {
        if (visibility[s].size() != reference.size()) {
            out << "visibility image " << s << " has " << visibility[s].size() << " pixels but the reference "
                << reference.size() << "; render both at one size";
            throw Error{out.str()};
        }
    }
    if (mask.size() != reference.size() || (!standard_error.empty() && standard_error.size() != reference.size())) {
        out << "mask has " << mask.size() << " and standard error " << standard_error.size()
            << " pixels but the reference " << reference.size() << "; give arrays of one size";
        throw Error{out.str()};
    }
    if (width < 1 || reference.size() % static_cast<std::size_t>(width) != 0) {
        out << "width is " << width << " for " << reference.size() << " pixels; give the length of a row";
        throw Error{out.str()};
    }
}

void check_reference(std::size_t pixel, int width, float reference, float standard_error) {
    if (!std::isfinite(reference) || !std::isfinite(standard_error)) {
        std::ostringstream out;
        out << "reference at " << place(pixel, width) << " is " << reference << " with standard error "
            << standard_error << "; only finite values can be compared with";
        throw Error{out.str()};
    }
}

/// V - reference; a value that is no number is wrong by 1, towards the farther end.
double error_of(float visibility, double reference, std::uint64_t& non_finite) noexcept {
    if (std::isfinite(visibility)) {
        return static_cast<double>(visibility) - reference;
    }
    ++non_finite;
    return reference > 0.5 ? -1.0 : 1.0;
}

/// Sum of squares of the true (noise-free) error, estimated without bias and never below 0.
double systematic_square(const Sums& sums, double seeds) noexcept {
    return std::max(0.0, sums.mean_error_square - sums.variance / seeds);
}

/// What of it the conditional mean over the bins explains. The mean over a bin of m pixels holds variance / (seeds m).
double explained_square(const std::array<Sums, kBins>& bins, double seeds) noexcept {
    double sum = 0.0;
    for (const Sums& bin : bins) {
        if (bin.pixels > 0) {
            sum += (bin.mean_error * bin.mean_error - bin.variance / seeds) / static_cast<double>(bin.pixels);
        }
    }
    return std::max(0.0, sum);
}

double mean_over(double sum, std::uint64_t pixels) noexcept {
    return pixels > 0 ? sum / static_cast<double>(pixels) : 0.0;
}

bool is_soft(double v) noexcept {
    return v > kSoftLow && v < kSoftHigh;
}

}  // namespace

ErrorSummary measure_errors(std::span<const std::span<const float>> visibility, std::span<const float> reference,
                            std::span<const float> standard_error, std::span<const std::uint8_t> mask, int width) {
    check_sizes(visibility, reference, standard_error, mask, width);
    const std::size_t seeds = visibility.size();
    const auto n = static_cast<double>(seeds);

    ErrorSummary summary;
    Sums umbra;
    Sums penumbra;
    Sums lit;
    std::array<Sums, kBins> bins{};
    std::vector<float> absolute_errors;
    std::vector<PixelClass> classes(reference.size(), PixelClass::Outside);
    std::vector<float> mean_squares(reference.size(), 0.0F);
    std::vector<double> of_seed(seeds);
    double absolute_sum = 0.0;
    double error_square_of_reference = 0.0;
    std::uint64_t soft_pixels = 0;
    std::uint64_t soft_reference_pixels = 0;

    for (std::size_t i = 0; i < reference.size(); ++i) {
        if (mask[i] == 0) {
            continue;
        }
        const float sigma = standard_error.empty() ? 0.0F : standard_error[i];
        check_reference(i, width, reference[i], sigma);
        const double truth = reference[i];
        error_square_of_reference += static_cast<double>(sigma) * sigma;

        double sum = 0.0;
        double square = 0.0;
        for (std::size_t s = 0; s < seeds; ++s) {
            const double error = error_of(visibility[s][i], truth, summary.non_finite);
            of_seed[s] = error;
            sum += error;
            square += error * error;
            absolute_sum += std::abs(error);
            absolute_errors.push_back(static_cast<float>(std::abs(error)));
        }
        const double mean = sum / n;
        double variance = 0.0;
        if (seeds > 1) {
            for (const double error : of_seed) {
                variance += (error - mean) * (error - mean);
            }
            variance /= n - 1.0;
        }
        mean_squares[i] = static_cast<float>(mean * mean);
        classes[i] = class_of(reference[i], true);
        soft_pixels += static_cast<std::uint64_t>(is_soft(truth + mean));
        soft_reference_pixels += static_cast<std::uint64_t>(is_soft(truth));
        switch (classes[i]) {
            case PixelClass::Umbra:
                umbra.add(truth, mean, variance, square / n);
                break;
            case PixelClass::Lit:
                lit.add(truth, mean, variance, square / n);
                break;
            default: {
                penumbra.add(truth, mean, variance, square / n);
                const auto bin = static_cast<std::size_t>(truth * static_cast<double>(kBins));
                bins[std::min(bin, kBins - 1)].add(truth, mean, variance, square / n);
                break;
            }
        }
    }

    const std::uint64_t pixels = umbra.pixels + penumbra.pixels + lit.pixels;
    summary.pixels = pixels;
    summary.penumbra_pixels = penumbra.pixels;
    const double mse = mean_over(umbra.square + penumbra.square + lit.square, pixels);
    summary.rmse = std::sqrt(mse);
    summary.mae = mean_over(absolute_sum / n, pixels);
    summary.bias = mean_over(umbra.mean_error + penumbra.mean_error + lit.mean_error, pixels);
    summary.p99 = static_cast<double>(percentile(std::span{absolute_errors}, 0.99));
    summary.p95 = static_cast<double>(percentile(std::span{absolute_errors}, 0.95));
    summary.max = static_cast<double>(percentile(std::span{absolute_errors}, 1.0));
    summary.penumbra_rmse = std::sqrt(mean_over(penumbra.square, penumbra.pixels));
    summary.leak = mean_over(umbra.reference + umbra.mean_error, umbra.pixels);
    summary.over_darkening = lit.pixels > 0 ? 1.0 - mean_over(lit.reference + lit.mean_error, lit.pixels) : 0.0;
    summary.penumbra_width_ratio =
        soft_reference_pixels > 0 ? static_cast<double>(soft_pixels) / static_cast<double>(soft_reference_pixels) : 0.0;
    summary.reference_standard_error = std::sqrt(mean_over(error_square_of_reference, pixels));
    summary.within_reference_noise = summary.rmse <= summary.reference_standard_error;

    const double systematic = systematic_square(penumbra, n);
    const double explained = std::min(explained_square(bins, n), systematic);
    summary.parts.leak = mean_over(systematic_square(umbra, n), pixels);
    summary.parts.over_darkening = mean_over(systematic_square(lit, n), pixels);
    summary.parts.bias = mean_over(explained, pixels);
    summary.parts.aliasing = mean_over(systematic - explained, pixels);
    // By difference, so that the parts add up; it equals the mean unbiased variance unless a clamp above took hold.
    const double named =
        summary.parts.leak + summary.parts.over_darkening + summary.parts.bias + summary.parts.aliasing;
    summary.parts.noise = seeds > 1 ? std::max(0.0, mse - named) : 0.0;

    summary.dominant = dominant_part(summary);
    double share_beside_edges = 0.0;
    if (summary.dominant == "leak" || summary.dominant == "over_darkening") {
        const PixelClass wanted = summary.dominant == "leak" ? PixelClass::Umbra : PixelClass::Lit;
        const std::vector<std::uint8_t> zone = edge_zone(classes, width, kEdgeRadius_px);
        double beside = 0.0;
        double all = 0.0;
        for (std::size_t i = 0; i < classes.size(); ++i) {
            if (classes[i] == wanted) {
                all += static_cast<double>(mean_squares[i]);
                beside += zone[i] != 0 ? static_cast<double>(mean_squares[i]) : 0.0;
            }
        }
        share_beside_edges = all > 0.0 ? beside / all : 0.0;
    }
    summary.sentence = error_sentence(summary, share_beside_edges);
    return summary;
}

}  // namespace penumbra
