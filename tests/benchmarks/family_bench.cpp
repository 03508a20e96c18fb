// The silhouette family against the hard shadow map: dynamic frames in turns in one run, and what each step takes.
// The published settings: view and map 1024 x 1024, one light; the Stanford bunny reduced to 10 000 triangles and in
// full. The papers' ratios: penumbra maps 2.3 to 3.3, smoothies 1.15 to 1.5; ours to reach: 1.6 and 1.3.
//
//     family_bench [TECHNIQUE[,setting=value...] ...]

#include <cmath>
#include <cstdio>
#include <memory>
#include <string>
#include <vector>

#include "benchmarks/job_words.h"
#include "geometry/simplify.h"
#include "penumbra/renderer.h"
#include "support/obj.h"
#include "support/scenes.h"

namespace penumbra {
namespace {

constexpr int kSide_px = 1024;
constexpr int kMap_px = 1024;

/// A model, made one metre high, over a ground, under a lamp, filling about a third of the view as the papers' do.
Scene over_ground(const std::shared_ptr<const Mesh>& mesh) {
    glm::vec3 low{1e30F}, high{-1e30F};
    for (const glm::vec3& p : mesh->positions_local) {
        low = glm::min(low, p);
        high = glm::max(high, p);
    }
    const double scale = 1.0 / (high.y - low.y);
    Scene scene;
    scene.instances.push_back(scenes::place(scenes::sheet(-20, 20, -20, 20), "ground"));
    Instance model = scenes::place(mesh, "model");
    // y up in the file, z up here
    model.world_from_local = glm::dmat4{{scale, 0, 0, 0}, {0, 0, scale, 0}, {0, -scale, 0, 0}, {0, 0, 0, 1}};
    const glm::dvec3 middle = 0.5 * (glm::dvec3{low} + glm::dvec3{high});
    model.world_from_local[3] = glm::dvec4{-scale * middle.x, scale * middle.z, -scale * low.y, 1.0};
    scene.instances.push_back(model);
    scene.lights.push_back(scenes::point_light({1.0, -1.0, 3.0}, 0.1));
    const double a = 0.9;
    const glm::dmat4 tilt{
        {1, 0, 0, 0}, {0, std::cos(a), std::sin(a), 0}, {0, -std::sin(a), std::cos(a), 0}, {0, 0, 0, 1}};
    scene.camera.world_from_camera = tilt;
    scene.camera.world_from_camera[3] = tilt * glm::dvec4{0, 0, 4, 1} + glm::dvec4{0, 0, 0.4, 0};
    scene.camera.tan_half_width = 0.4;
    scene.camera.width_px = scene.camera.height_px = kSide_px;
    return scene;
}

void compare(const std::string& name, const std::shared_ptr<const Mesh>& mesh, const std::vector<std::string>& words) {
    Renderer renderer;
    Control control;
    renderer.set_scene(over_ground(mesh));
    std::vector<Job> jobs{{"shadow_map", {}}};
    for (const std::string& word : words) {
        jobs.push_back(job_from(word));
    }
    for (Job& job : jobs) {
        job.settings.insert({"map_size", kMap_px});
    }
    TimingOptions timing;
    timing.warm_up = 2;
    timing.min_runs = timing.max_runs = 25;
    const std::vector<Measurement> measured = renderer.measure(0, jobs, false, timing, control);
    const double hard_ms = measured.front().dynamic_frame.median;
    std::printf("%s, %zu triangles\n", name.c_str(), mesh->triangles.size());
    for (std::size_t i = 0; i < jobs.size(); ++i) {
        const Measurement& m = measured[i];
        std::printf("  %-40s dynamic %6.2f ms (%.2f of shadow_map), static %6.2f ms, %.1f MiB\n",
                    i == 0 ? "shadow_map" : words[i - 1].c_str(), m.dynamic_frame.median,
                    m.dynamic_frame.median / hard_ms, m.static_frame.median,
                    static_cast<double>(m.memory_bytes) / (1 << 20));
        for (const Step& step : m.plan.steps) {
            if (step.run) {
                std::printf("      %-30s %6.2f ms\n", step.name.c_str(), step.time_ms);
            }
        }
    }
}

}  // namespace
}  // namespace penumbra

int main(int argc, char** argv) {
    try {
        std::vector<std::string> words(argv + 1, argv + argc);
        if (words.empty()) {
            words = {"penumbra_maps", "penumbra_maps,mode=literal", "penumbra_maps,sides=both"};
        }
        const auto bunny = penumbra::read_model("stanford-bunny.obj");
        const std::shared_ptr<const penumbra::Mesh> full = bunny ? bunny : penumbra::scenes::sphere(131, false);
        std::printf("view and map %d x %d%s\n", penumbra::kSide_px, penumbra::kMap_px,
                    bunny ? "" : "; no bunny here, a sphere instead");
        penumbra::compare("reduced", penumbra::simplify(full, 10000).mesh, words);
        penumbra::compare("full", full, words);
    } catch (const penumbra::Error& error) {
        std::fprintf(stderr, "family_bench: %s\n", error.what());
        return 1;
    }
    return 0;
}
