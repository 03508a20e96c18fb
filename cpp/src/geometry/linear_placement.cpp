#include "geometry/linear_placement.h"

#include <algorithm>
#include <cmath>
#include <deque>
#include <limits>
#include <utility>

namespace penumbra {

namespace {

// A shadow test that is sure of it: against the deepest of 3 x 3 entries, with a wide bias.
constexpr double kSureBias = 5e-3;
constexpr double kChange = 0.1;
constexpr double kMostUnseen = 1e-4;
constexpr double kMostChanged = 0.02;

bool surely_hidden(const LinearMap& map, const LinearPoint& point, bool parallel) {
    std::size_t found = 0;
    if (!map.find({point.uv.x - map.along * point.d, point.uv.y}, found)) {
        return false;
    }
    const int x = static_cast<int>(found % static_cast<std::size_t>(map.width_px));
    const int y = static_cast<int>(found / static_cast<std::size_t>(map.width_px));
    double deepest = std::numeric_limits<double>::infinity();
    for (int dy = -1; dy <= 1; ++dy) {
        for (int dx = -1; dx <= 1; ++dx) {
            deepest = std::min(
                deepest,
                map.d[map.index(std::clamp(x + dx, 0, map.width_px - 1), std::clamp(y + dy, 0, map.height_px - 1))]);
        }
    }
    const double bias = parallel ? 8.0 * std::max(map.step.x, map.step.y) : point.d * kSureBias;
    return point.d + bias < deepest;
}

}  // namespace

void CandidateScore::add(const CandidateScore& other) noexcept {
    texels += other.texels;
    unseen += other.unseen;
    changed += other.changed;
    edges = edges || other.edges;
}

bool CandidateScore::triggers() const noexcept {
    const auto all = static_cast<double>(texels);
    return (unseen > 2 && static_cast<double>(unseen) > kMostUnseen * all) ||
           static_cast<double>(changed) > kMostChanged * all;
}

CandidateScore score_candidate(const LinearMap& first, const LinearMap& middle, const LinearMap& last,
                               const SkinRules& rules, const LinearLookup& lookup, const AskedPart& asked) {
    CandidateScore score;
    const LinearVisibility two{{first, last}, rules};
    if (two.skin_count() == 0) {
        return score;
    }
    score.edges = true;
    const LinearVisibility three{{first, middle, last}, rules};
    for (int y = 0; y < middle.height_px; ++y) {
        for (int x = 0; x < middle.width_px; ++x) {
            LinearPoint point;
            point.d = middle.d[middle.index(x, y)];
            if (!(point.d > 0.0) || middle.u_of(x) < asked.low_u || middle.u_of(x) > asked.high_u) {
                continue;
            }
            point.uv = {middle.u_of(x) + middle.along * point.d, middle.low.y + (y + 0.5) * middle.step.y};
            ++score.texels;
            const bool unseen =
                surely_hidden(first, point, lookup.parallel) && surely_hidden(last, point, lookup.parallel);
            score.unseen += unseen ? 1 : 0;
            score.changed += std::abs(two.at(point, lookup) - three.at(point, lookup)) > kChange ? 1 : 0;
        }
    }
    return score;
}

std::vector<double> place_samples(std::vector<double> places, std::size_t most, double least,
                                  const std::function<bool(double, double, double)>& triggers) {
    std::deque<std::pair<double, double>> open;
    for (std::size_t i = 0; i + 1 < places.size(); ++i) {
        open.emplace_back(places[i], places[i + 1]);
    }
    while (!open.empty() && places.size() < most) {
        const auto [from, to] = open.front();
        open.pop_front();
        if (!(to - from > least)) {
            continue;
        }
        const auto found = [&, from = from, to = to](double share) {
            return triggers(from, from + share * (to - from), to);
        };
        if (found(0.5) || found(0.25) || found(0.75)) {
            const double middle = 0.5 * (from + to);
            places.insert(std::ranges::upper_bound(places, middle), middle);
            open.emplace_back(from, middle);
            open.emplace_back(middle, to);
        }
    }
    return places;
}

}  // namespace penumbra
