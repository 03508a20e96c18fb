#include "techniques/linear_light_maps/software_engine.h"

#include <algorithm>

#include "base/parallel.h"
#include "passes/frame.h"

namespace penumbra {

void SoftwareEngine::add(const LinearViews& views, double weight, const SkinRules& rules, std::span<const float> stored,
                         int first_layer, int size_px) {
    Rod rod{&views, weight, {}};
    for (std::size_t window = 0; window < views.windows.size(); ++window) {
        SkinRules own = rules;
        if (views.orthographic) {
            own.same_relative = 0.0;
            own.same_absolute = views.windows[window].step.x;
        }
        rod.windows.emplace_back(linear_maps(views, window, stored, first_layer, size_px), own);
    }
    rods_.push_back(std::move(rod));
}

void SoftwareEngine::resolve(Frame& frame, const LinearLookup& lookup, const Local& local,
                             std::span<const glm::vec2> rest, std::vector<float>& visibility) const {
    const View& view = frame.view();
    const LightSummary& summary = frame.summary();
    const bool all = summary.keeps("pixel-outside-mask");
    parallel_for(
        static_cast<std::int64_t>(view.size()), 1024,
        [&](std::int64_t begin, std::int64_t end) {
            std::vector<double> weights;
            for (auto i = static_cast<std::size_t>(begin); i < static_cast<std::size_t>(end); ++i) {
                visibility[i] = 1.0F;
                if (all ? !view.hit(i) : summary.mask[i] == 0) {
                    continue;
                }
                double sum = rest.empty() ? 0.0 : static_cast<double>(rest[i].x);
                double whole = rest.empty() ? 0.0 : static_cast<double>(rest[i].y);
                for (const Rod& rod : rods_) {
                    const glm::dvec3 p_rel = glm::dvec3{view.position_cr[i]} + (view.eye_ws - rod.views->origin_ws);
                    const glm::dvec3 n{view.normal_ws[i]};
                    const auto window = rod.views->window_of(p_rel);
                    if (!window) {
                        continue;
                    }
                    weights.clear();
                    for (int k = 0; local && k < rod.views->samples(); ++k) {
                        weights.push_back(local(rod.views->eye_ws(k), rod.views->u_ws,
                                                view.eye_ws + glm::dvec3{view.position_cr[i]}, n));
                    }
                    const LinearVisibility::Total total =
                        rod.windows[*window].total_at(rod.views->point_in(*window, p_rel, n), lookup, weights);
                    sum += rod.weight * std::min(total.seen, total.whole);
                    whole += rod.weight * total.whole;
                }
                visibility[i] = sum >= whole ? 1.0F : static_cast<float>(sum / whole);
            }
        },
        frame.control());
}

}  // namespace penumbra
