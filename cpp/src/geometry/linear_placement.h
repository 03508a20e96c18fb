#pragma once

#include <functional>
#include <limits>
#include <vector>

#include "geometry/linear_light.h"

namespace penumbra {

/// Where a linear light needs more samples [C: linear-light-soft-shadow-maps 2.12]. Two neighbours are too few where a
/// part of the light between them is seen and neither end is, and where a third sample would change what they say.
struct CandidateScore {
    std::size_t texels = 0;   ///< of the candidate's map that see a surface
    std::size_t unseen = 0;   ///< U: of these, seen by neither neighbour
    std::size_t changed = 0;  ///< J: of these, where V of the segment changes by more than 0.1
    bool edges = false;       ///< there are skins between the neighbours at all

    void add(const CandidateScore& other) noexcept;
    /// More than 2 texels and 1e-4 of them unseen, or more than 2 % changed.
    [[nodiscard]] bool triggers() const noexcept;
};

/// What lies to either side of the part of the candidate's map that is asked.
struct AskedPart {
    double low_u = -std::numeric_limits<double>::infinity(), high_u = std::numeric_limits<double>::infinity();
};

/// @param first, middle, last  maps of one window, in the order of `along`
/// @param asked  where the candidate's map is judged: beyond the receivers its neighbours may not see the casters
[[nodiscard]] CandidateScore score_candidate(const LinearMap& first, const LinearMap& middle, const LinearMap& last,
                                             const SkinRules& rules, const LinearLookup& lookup,
                                             const AskedPart& asked = {});

/// Halves segments while `triggers(from, at, to)` holds for a candidate at their middle, else at a quarter or three
/// quarters. What is put in is always the middle: at the best candidate's place segments of odd lengths would stay.
/// @param places  ascending
/// @param most    samples
/// @param least   shortest segment that is halved
[[nodiscard]] std::vector<double> place_samples(std::vector<double> places, std::size_t most, double least,
                                                const std::function<bool(double, double, double)>& triggers);

}  // namespace penumbra
