#include "techniques/linear_light_maps/sample_placement.h"

#include <algorithm>
#include <map>

#include "passes/frame.h"

namespace penumbra {

namespace {

// Failures are wide: they need no finer maps, and these are judged on the processor.
constexpr int kMost_px = 512;
constexpr double kShortest = 2.0 / 16.0;  // of a rod from -1 to 1

}  // namespace

void render_linear_depths(Frame& frame, DepthMap& maps, MapSetup& setup, const LinearViews& views,
                          const glm::dvec3& axis_ws, int first_layer, int size_px, bool surfaces) {
    for (int sample = 0; sample < views.samples(); ++sample) {
        frame.control().check();
        for (const LinearViews::Group& group : views.groups()) {
            const MapFrustum frustum = views.frustum_of(sample, group);
            setup.bind_for_depth(frame.gpu_scene(), frustum,
                                 make_map_block(frustum, frame.light(), axis_ws, frame.summary().eye_ws, size_px));
            for (std::size_t face = 0; face < group.count; ++face) {
                const std::size_t window = group.first + face;
                const auto instances = surfaces ? views.windows[window].skin_casters[static_cast<std::size_t>(sample)]
                                                : casters_in(frame.summary(), frustum.faces[face]);
                maps.render(frame, frame.gpu_scene(), instances, face,
                            first_layer + static_cast<int>(window) * views.samples() + sample, Cull::None);
            }
        }
    }
}

SamplePlacement::Result SamplePlacement::find(Frame& frame, const LinearRod& rod, const glm::dvec3& aim_ws,
                                              std::vector<double> start, int most, int size_px,
                                              const SkinRules& rules) {
    Result result;
    const int small_px = std::min(size_px, kMost_px);
    std::map<std::pair<double, double>, CandidateScore> middles;
    const auto triggers = [&](double from, double at, double to) {
        const LinearViews views = fit_linear_views(frame.summary(), rod, {from, at, to}, aim_ws, small_px);
        if (views.windows.empty()) {
            return false;
        }
        const int layers = 3 * static_cast<int>(views.windows.size());
        maps_.allocate(small_px, layers, "candidate maps");
        render_linear_depths(frame, maps_, setup_, views, rod.centre_ws, 0, small_px, true);
        const std::vector<float> stored = maps_.texture().read<float>();
        CandidateScore score;
        for (std::size_t window = 0; window < views.windows.size(); ++window) {
            const std::vector<LinearMap> maps = linear_maps(views, window, stored, 0, small_px);
            LinearLookup lookup;
            lookup.parallel = views.orthographic;
            SkinRules own = rules;
            if (views.orthographic) {
                lookup.bias = 2.0 * maps[0].step.x;
                lookup.rim = 16.0 * maps[0].step.x;
                own.same_relative = 0.0;
                own.same_absolute = maps[0].step.x;
            }
            const glm::dvec2 asked = views.windows[window].receivers_u[1];
            score.add(score_candidate(maps[0], maps[1], maps[2], own, lookup, {asked.x, asked.y}));
        }
        ++result.candidates;
        if (at == 0.5 * (from + to)) {
            middles[{from, to}] = score;
        }
        return score.triggers();
    };
    result.places = place_samples(std::move(start), static_cast<std::size_t>(most), kShortest, triggers);
    std::size_t texels = 0;
    std::size_t unseen = 0;
    for (std::size_t i = 0; i + 1 < result.places.size(); ++i) {
        const auto found = middles.find({result.places[i], result.places[i + 1]});
        if (found != middles.end()) {
            texels += found->second.texels;
            unseen += found->second.unseen;
        }
    }
    result.undersampled = texels > 0 ? static_cast<double>(unseen) / static_cast<double>(texels) : 0.0;
    return result;
}

}  // namespace penumbra
