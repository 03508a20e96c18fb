// The hybrid against full shadow volumes and the hard shadow map, on scenes in the spirit of its thesis [Chan2004]:
// 1024 x 768, dynamic frames in turns in one run, so that ratios hold on a busy machine; and what the thesis counts.
// The thesis: 30 to more than 100 % more frames per second than volumes, overdraw 79 and 5 % tagged pixels in the cage.
//
//     hybrid_bench [SCENE ...] [TECHNIQUE[,setting=value...] ...]
//
// Scenes: cubes, cage, tree; all of them if none is named.

#include <cstdio>
#include <map>
#include <string>
#include <vector>

#include "benchmarks/job_words.h"
#include "penumbra/renderer.h"
#include "support/thesis_scenes.h"

namespace penumbra {
namespace {

void compare(const std::string& name, const Scene& scene, const std::vector<std::string>& words) {
    Renderer renderer;
    Control control;
    renderer.set_scene(scene);
    std::vector<Job> jobs{{"shadow_volume", {}}};
    for (const std::string& word : words) {
        jobs.push_back(job_from(word));
    }
    TimingOptions timing;
    timing.warm_up = 2;
    timing.min_runs = timing.max_runs = 11;
    const std::vector<Measurement> measured = renderer.measure(0, jobs, false, timing, control);
    const double volumes_ms = measured.front().dynamic_frame.median;
    std::printf("%s, %zu triangles\n", name.c_str(), scene.instances[1].mesh->triangles.size());
    for (std::size_t i = 0; i < jobs.size(); ++i) {
        const Measurement& m = measured[i];
        std::printf("  %-40s dynamic %7.2f ms (%.2f of shadow_volume), static %7.2f ms\n",
                    i == 0 ? "shadow_volume" : words[i - 1].c_str(), m.dynamic_frame.median,
                    m.dynamic_frame.median / volumes_ms, m.static_frame.median);
        for (const Step& step : m.plan.steps) {
            if (step.run) {
                std::printf("      %-30s %7.2f ms\n", step.name.c_str(), step.time_ms);
            }
        }
        for (const Statistic& s : renderer.visibility(0, jobs[i], false, control).statistics) {
            std::printf("      %-60s %.6g %s\n", s.label.c_str(), s.value, s.unit.c_str());
        }
    }
}

}  // namespace
}  // namespace penumbra

int main(int argc, char** argv) {
    try {
        const std::map<std::string, penumbra::Scene (*)()> scenes{
            {"cubes", penumbra::scenes::cubes}, {"cage", penumbra::scenes::cage}, {"tree", penumbra::scenes::tree}};
        std::vector<std::string> names, words;
        for (const std::string word : std::vector<std::string>(argv + 1, argv + argc)) {
            (scenes.contains(word) ? names : words).push_back(word);
        }
        if (names.empty()) {
            names = {"cubes", "cage", "tree"};
        }
        if (words.empty()) {
            words = {"hybrid,map_size=256", "hybrid,map_size=512", "hybrid,map_size=1024", "shadow_map,map_size=512"};
        }
        for (const std::string& name : names) {
            penumbra::compare(name, scenes.at(name)(), words);
        }
    } catch (const penumbra::Error& error) {
        std::fprintf(stderr, "hybrid_bench: %s\n", error.what());
        return 1;
    }
    return 0;
}
