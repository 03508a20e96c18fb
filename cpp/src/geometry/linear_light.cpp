#include "geometry/linear_light.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "base/assert.h"

namespace penumbra {

namespace {

double sigma_of(LogKernel kernel) noexcept {
    return kernel == LogKernel::Three ? 0.6 : 0.8;
}

}  // namespace

int radius_of(LogKernel kernel) noexcept {
    return kernel == LogKernel::Three ? 1 : 2;
}

std::vector<double> log_weights(LogKernel kernel) {
    const int radius = radius_of(kernel);
    const double s2 = sigma_of(kernel) * sigma_of(kernel);
    std::vector<double> weights;
    double sum = 0.0;
    for (int y = -radius; y <= radius; ++y) {
        for (int x = -radius; x <= radius; ++x) {
            const double r = (x * x + y * y) / (2.0 * s2);
            weights.push_back(-(1.0 - r) * std::exp(-r) / (std::numbers::pi * s2 * s2));
            sum += weights.back();
        }
    }
    for (double& weight : weights) {
        weight -= sum / static_cast<double>(weights.size());
    }
    return weights;
}

double least_step_response(LogKernel kernel) noexcept {
    return kernel == LogKernel::Three ? 1.77 : 0.47;
}

bool LinearMap::find(const glm::dvec2& uv, std::size_t& found) const noexcept {
    const glm::dvec2 texel = (uv - low) / step;
    if (!(texel.x >= 0.0 && texel.y >= 0.0 && texel.x <= width_px && texel.y <= height_px)) {
        return false;
    }
    found =
        index(std::min(static_cast<int>(texel.x), width_px - 1), std::min(static_cast<int>(texel.y), height_px - 1));
    return true;
}

std::vector<double> filter_log(const LinearMap& map, LogKernel kernel) {
    const int radius = radius_of(kernel);
    const std::vector<double> weights = log_weights(kernel);
    std::vector<double> filtered(map.d.size());
    for (int y = 0; y < map.height_px; ++y) {
        for (int x = 0; x < map.width_px; ++x) {
            const double middle = map.d[map.index(x, y)];
            double sum = 0.0;
            std::size_t k = 0;
            for (int dy = -radius; dy <= radius; ++dy) {
                for (int dx = -radius; dx <= radius; ++dx) {
                    const double value = map.d[map.index(std::clamp(x + dx, 0, map.width_px - 1),
                                                         std::clamp(y + dy, 0, map.height_px - 1))];
                    sum += weights[k++] * (value - middle);  // the weights' sum is 0: this takes off rounding alone
                }
            }
            filtered[map.index(x, y)] = sum;
        }
    }
    return filtered;
}

std::vector<Skin> find_skins(const LinearMap& from, const LinearMap& to, const SkinRules& rules) {
    std::vector<Skin> skins;
    const double base = from.along - to.along;
    if (base == 0.0) {  // coincident samples: a segment of no weight
        return skins;
    }
    const double least_jump = rules.least_skin_px * from.step.x / std::abs(base);
    const double least_log = rules.log_share * least_step_response(rules.kernel) * least_jump;
    const std::vector<double> log = filter_log(from, rules.kernel);
    for (int y = 0; y < from.height_px; ++y) {
        for (int x = 0; x + 1 < from.width_px; ++x) {
            const std::size_t a = from.index(x, y);
            const std::size_t b = a + 1;
            if (std::abs(from.d[a] - from.d[b]) <= least_jump || log[a] * log[b] >= 0.0 ||
                std::abs(log[a] - log[b]) <= least_log ||
                std::min(std::abs(log[a]), std::abs(log[b])) <= rules.dead_zone * least_log) {
                continue;
            }
            const bool caster_left = from.d[a] > from.d[b];
            if (caster_left != (base < 0.0)) {  // the gap folds shut in the other view
                continue;
            }
            const std::size_t caster = caster_left ? a : b;
            const std::size_t receiver = caster_left ? b : a;
            Skin skin;
            skin.row = y;
            skin.caster_d = from.d[caster];
            skin.receiver_d = from.d[receiver];
            skin.caster_u = from.u_of(caster_left ? x : x + 1) + base * skin.caster_d;
            skin.receiver_u = from.u_of(caster_left ? x + 1 : x) + base * skin.receiver_d;
            skins.push_back(skin);
        }
    }
    return skins;
}

std::vector<double> draw_skins(const std::vector<Skin>& skins, const LinearMap& from, const LinearMap& to,
                               const SkinRules& rules) {
    std::vector<double> entries(to.d.size(), 0.5);
    std::vector<double> order(to.d.size(), 0.0);
    std::vector<std::uint8_t> drawn(to.d.size(), 0);
    const double base = std::abs(from.along - to.along);
    for (const Skin& skin : skins) {
        const double length = skin.receiver_u - skin.caster_u;
        // The receiver's end goes on for half a texel, so that no texel centre falls between it and the lit side.
        const double end = skin.receiver_u + std::copysign(0.5 * to.step.x, length);
        const double first = (std::min(skin.caster_u, end) - to.low.x) / to.step.x - 0.5;
        const double last = (std::max(skin.caster_u, end) - to.low.x) / to.step.x - 0.5;
        const int x0 = static_cast<int>(std::ceil(std::clamp(first, -1.0, static_cast<double>(to.width_px))));
        const int x1 = static_cast<int>(std::ceil(std::clamp(last, -1.0, static_cast<double>(to.width_px))));
        for (int x = std::max(x0, 0); x < x1; ++x) {
            const std::size_t i = to.index(x, skin.row);
            const double t = (to.u_of(x) - skin.caster_u) / length;
            const double d = skin.caster_d + t * (skin.receiver_d - skin.caster_d);
            const double seen = to.d[i];
            if (seen >= skin.caster_d * (1.0 - rules.same_relative) - rules.same_absolute ||
                d < seen * (1.0 - rules.same_relative) - rules.same_absolute) {
                continue;
            }
            double v = t;
            if (rules.exact) {
                v = std::abs(to.u_of(x) - skin.caster_u) / std::max(base * (skin.caster_d - seen), 1e-9 * to.step.x);
            }
            if (rules.wall_rule && !rules.exact) {
                // Over a parallel receiver the height is 1 - t of the skin's own depth: nothing changes there.
                const double height = (d - seen) / std::max(skin.caster_d - skin.receiver_d, 1e-300);
                v = std::max(v, 1.0 - 10.0 * std::max(height, 0.0));
            }
            v = std::clamp(v, 0.0, 1.0);
            if (rules.darkest ? drawn[i] == 0 || v < entries[i] : d > order[i]) {
                entries[i] = v;
                order[i] = d;
                drawn[i] = 1;
            }
        }
    }
    return entries;
}

LinearVisibility::LinearVisibility(std::vector<LinearMap> maps, const SkinRules& rules) : maps_{std::move(maps)} {
    for (const LinearMap& map : maps_) {
        before_.emplace_back(map.d.size(), 0.5);
        after_.emplace_back(map.d.size(), 0.5);
    }
    for (std::size_t i = 0; i + 1 < maps_.size(); ++i) {
        const std::vector<Skin> forward = find_skins(maps_[i], maps_[i + 1], rules);
        const std::vector<Skin> backward = find_skins(maps_[i + 1], maps_[i], rules);
        before_[i + 1] = draw_skins(forward, maps_[i], maps_[i + 1], rules);
        after_[i] = draw_skins(backward, maps_[i + 1], maps_[i], rules);
        skins_ += forward.size() + backward.size();
    }
}

LinearVisibility::End LinearVisibility::end_at(std::size_t map, const LinearPoint& point,
                                               const LinearLookup& lookup) const {
    const LinearMap& seen = maps_[map];
    End end;
    end.towards = point.towards + seen.along * point.normal_uv.x;
    std::size_t i = 0;
    const glm::dvec2 uv{point.uv.x - seen.along * point.d, point.uv.y};
    if (!seen.find(uv, i)) {
        end.lit = !lookup.facing_test || end.towards > 0.0;
        return end;
    }
    const double stored = seen.d[i];
    const double widest = std::max(seen.step.x, seen.step.y);
    double biased = point.d;
    if (point.has_plane) {
        // On a plane d is affine: half a texel off the centre it differs by half of this at most.
        const double slope = (std::abs(point.normal_uv.x) * seen.step.x + std::abs(point.normal_uv.y) * seen.step.y) /
                             std::max(std::abs(end.towards), 1e-300);
        // A texel's width in depth, as a difference of d.
        const double texel_d = lookup.parallel ? widest : widest * point.d;
        biased += std::min(0.5 * slope, lookup.slope_cap_px * texel_d) + lookup.bias_px * texel_d;
    } else {
        biased += lookup.parallel ? lookup.bias : point.d * lookup.bias;
    }
    end.lit = biased >= stored && (!lookup.facing_test || end.towards > 0.0);
    const bool other =
        lookup.rim_rule && stored < (lookup.parallel ? point.d - lookup.rim : point.d * (1.0 - lookup.rim));
    if (!other) {
        end.before = before_[map][i];
        end.after = after_[map][i];
    }
    return end;
}

LinearVisibility::Segment LinearVisibility::segment_ends(std::size_t segment, const LinearPoint& point,
                                                         const LinearLookup& lookup) const {
    const End first = end_at(segment, point, lookup);
    const End second = end_at(segment + 1, point, lookup);
    Segment ends{first.lit ? first.after : 0.0, second.lit ? second.before : 0.0, 1.0};
    const double sum = ends.first + ends.second;
    if (lookup.facing_test && (first.towards > 0.0) != (second.towards > 0.0)) {
        // The surface's own plane hides the rest of a segment that crosses it.
        ends.facing = std::max(first.towards, second.towards) / std::abs(first.towards - second.towards);
        const double seen = std::max(ends.first, ends.second);
        const double only = std::min(seen == 0.5 ? 1.0 : seen, ends.facing);
        (first.towards > 0.0 ? ends.first : ends.second) = only;
    } else if (lookup.clamp && sum > 1.0) {
        ends.first /= sum;
        ends.second /= sum;
    }
    return ends;
}

double LinearVisibility::segment_at(std::size_t segment, const LinearPoint& point, const LinearLookup& lookup) const {
    const Segment ends = segment_ends(segment, point, lookup);
    return ends.first + ends.second;
}

double LinearVisibility::at(const LinearPoint& point, const LinearLookup& lookup, std::span<const double> local) const {
    const Total total = total_at(point, lookup, local);
    return total.seen >= total.whole ? 1.0 : total.seen / total.whole;
}

LinearVisibility::Total LinearVisibility::total_at(const LinearPoint& point, const LinearLookup& lookup,
                                                   std::span<const double> local) const {
    if (maps_.size() == 1) {
        const double whole = local.empty() ? 1.0 : local[0];
        return {end_at(0, point, lookup).lit ? whole : 0.0, whole};
    }
    double sum = 0.0;
    double whole = 0.0;
    for (std::size_t i = 0; i + 1 < maps_.size(); ++i) {
        // Samples that all coincide share the light evenly.
        const double length = maps_.back().along - maps_.front().along;
        const double share =
            length > 0.0 ? (maps_[i + 1].along - maps_[i].along) / length : 1.0 / static_cast<double>(maps_.size() - 1);
        const Segment ends = segment_ends(i, point, lookup);
        if (local.empty()) {
            sum += share * (ends.first + ends.second);
            whole += share;
        } else {
            // What lies behind the point's plane lights it neither with nor without casters.
            const double half = ends.facing < 1.0 ? 0.5 / ends.facing : 1.0;
            sum += share * half * (ends.first * local[i] + ends.second * local[i + 1]);
            whole += share * 0.5 * (local[i] + local[i + 1]);
        }
    }
    return {sum, whole};
}

}  // namespace penumbra
