#pragma once

#include <string>

#include "penumbra/measure.h"

namespace penumbra {

/// Pixels around a shadow edge that count as "beside" it in the sentence.
inline constexpr int kEdgeRadius_px = 4;

/// Name of the largest part, or "none" if there is no error or it is within the reference's noise.
[[nodiscard]] std::string dominant_part(const ErrorSummary& summary);

/// One plain sentence: which part dominates, how much of the RMSE it is, what it looks like and what would change it.
/// @param share_beside_edges how much of the dominant part's square error (leak or over-darkening) lies at most
///        kEdgeRadius_px from a shadow edge of the reference, 0 .. 1
[[nodiscard]] std::string error_sentence(const ErrorSummary& summary, double share_beside_edges);

}  // namespace penumbra
