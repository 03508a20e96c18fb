#include "measure/sentence.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <sstream>
#include <utility>

namespace penumbra {

namespace {

/// All parts one after another; numbers with two significant digits, which is what a person compares.
template <typename... Parts>
std::string join(const Parts&... parts) {
    std::ostringstream out;
    out.precision(2);
    ((out << parts), ...);
    return out.str();
}

std::string percent(double share) {
    return join(std::lround(100.0 * share), " %");
}

/// "(0.21 of 0.24 RMSE)"
std::string share_of_rmse(double part, double rmse) {
    return join('(', std::sqrt(part), " of ", rmse, " RMSE)");
}

std::string width_in_words(double ratio) {
    if (ratio == 0.0) {
        return "hard edges where the truth is soft";
    }
    if (std::abs(ratio - 1.0) < 0.05) {
        return "the right width but the wrong profile";
    }
    return join("the wrong profile, ", ratio, " times the true width");
}

std::string noise_sentence(const ErrorSummary& s) {
    return join("Noise dominates ", share_of_rmse(s.parts.noise, s.rmse), ": four times the rays halve it.");
}

std::string bias_sentence(const ErrorSummary& s) {
    return join("Bias dominates: its penumbrae have ", width_in_words(s.penumbra_width_ratio), ' ',
                share_of_rmse(s.parts.bias, s.rmse), "; more resolution or samples will not change that.");
}

std::string leak_sentence(const ErrorSummary& s, double beside) {
    const std::string head = join("Leak dominates: light reaches the umbra ", share_of_rmse(s.parts.leak, s.rmse),
                                  ", mean V there ", s.leak, "; ");
    if (beside >= 0.5) {
        return join(head, percent(beside), " of it lies within ", kEdgeRadius_px,
                    " pixels of a shadow edge, so its edges sit too far in or its blur is too wide.");
    }
    return join(head, percent(1.0 - beside),
                " of it lies away from shadow edges, so blockers are missed (bias too large, map too coarse for thin "
                "parts).");
}

std::string over_darkening_sentence(const ErrorSummary& s, double beside) {
    const std::string head = join("Over-darkening dominates: lit surfaces lose ", s.over_darkening,
                                  " of their light on average ", share_of_rmse(s.parts.over_darkening, s.rmse), "; ");
    if (beside >= 0.5) {
        return join(head, percent(beside), " of it lies within ", kEdgeRadius_px,
                    " pixels of a shadow edge, so its shadows reach too far out.");
    }
    return join(head, percent(1.0 - beside),
                " of it lies away from shadow edges, so surfaces shadow themselves (acne; a larger bias helps).");
}

std::string aliasing_sentence(const ErrorSummary& s) {
    return join(
        "Aliasing dominates: errors that depend on where a pixel lies, such as staircase edges, bands, acne, or hard "
        "edges where penumbrae overlap ",
        share_of_rmse(s.parts.aliasing, s.rmse),
        "; a finer map or more samples help against all but the last, as a sweep tells.");
}

std::string sentence_of_the_dominant(const ErrorSummary& summary, double share_beside_edges) {
    if (summary.dominant == "noise") {
        return noise_sentence(summary);
    }
    if (summary.dominant == "bias") {
        return bias_sentence(summary);
    }
    if (summary.dominant == "leak") {
        return leak_sentence(summary, share_beside_edges);
    }
    if (summary.dominant == "over_darkening") {
        return over_darkening_sentence(summary, share_beside_edges);
    }
    return aliasing_sentence(summary);
}

}  // namespace

std::string dominant_part(const ErrorSummary& summary) {
    if (summary.within_reference_noise || !(summary.rmse > 0.0)) {
        return "none";
    }
    const std::array<std::pair<double, const char*>, 5> parts{{{summary.parts.noise, "noise"},
                                                               {summary.parts.leak, "leak"},
                                                               {summary.parts.over_darkening, "over_darkening"},
                                                               {summary.parts.bias, "bias"},
                                                               {summary.parts.aliasing, "aliasing"}}};
    return std::ranges::max_element(parts, {}, [](const auto& part) { return part.first; })->second;
}

std::string error_sentence(const ErrorSummary& summary, double share_beside_edges) {
    if (summary.pixels == 0) {
        return "Nothing to compare: no pixel is inside the mask.";
    }
    if (summary.rmse == 0.0) {
        return "No error: every pixel equals the reference.";
    }
    if (summary.within_reference_noise) {
        return join("Within the reference's noise: an RMSE of ", summary.rmse,
                    " is not above the reference's own standard error of ", summary.reference_standard_error, '.');
    }
    std::string text = sentence_of_the_dominant(summary, share_beside_edges);
    if (summary.non_finite == 0) {
        return text;
    }
    return join(text, ' ', summary.non_finite, summary.non_finite == 1 ? " value was" : " values were",
                " not a number and counted as an error of 1.");
}

}  // namespace penumbra
