// Silhouettes: edges per second on one core in the flat layout (cpu_flat; asked for: 300 M on a smooth mesh), and what
// a whole extraction into a buffer takes (extract_gpu, extract_cpu: SilhouettePass by either source, to glFinish). kind
// 0: sphere, smooth, so that silhouettes grow with the square root of the triangles; 1: the same with every vertex
// shaken, the worst case, a third of all edges; 2: the bunny. The light turns, so that no run is like the last. CPU
// times are the thread's own and bear a busy machine; the device's are wall time and want a quiet one.

#include <benchmark/benchmark.h>

#include <map>
#include <memory>
#include <random>

#include "gl/render_thread.h"
#include "passes/silhouette_pass.h"
#include "support/bare_frame.h"
#include "support/obj.h"
#include "support/scenes.h"

namespace penumbra {
namespace {

/// nullptr: the bunny, where it is not.
std::shared_ptr<Mesh> make_mesh(int kind, std::int64_t triangles) {
    if (kind == 2) {
        return read_model("stanford-bunny.obj");
    }
    auto mesh = scenes::sphere(static_cast<int>(std::lround(std::sqrt(static_cast<double>(triangles) / 4.0))), false);
    if (kind == 1) {
        std::mt19937 random{7};
        std::uniform_real_distribution<float> shake{0.7F, 1.3F};
        const Adjacency adjacency = make_adjacency(*mesh);
        std::vector<float> factor(mesh->positions_local.size());
        for (float& f : factor) {
            f = shake(random);
        }
        for (std::size_t i = 0; i < factor.size(); ++i) {
            mesh->positions_local[i] *= factor[adjacency.welded[i]];
        }
    }
    return mesh;
}

glm::dvec4 light_at(int step) {
    const double a = 0.1 * step;
    return {3.0 * std::cos(a), 3.0 * std::sin(a), 2.0, 1.0};
}

struct Input {
    std::shared_ptr<Mesh> mesh;
    Adjacency adjacency;
};
const Input* input(benchmark::State& state) {
    static std::map<std::pair<std::int64_t, std::int64_t>, Input> kept;
    const auto key = std::pair{state.range(0), state.range(1)};
    auto found = kept.find(key);
    if (found == kept.end()) {
        auto mesh = make_mesh(static_cast<int>(key.first), key.second);
        if (!mesh) {
            state.SkipWithError("no bunny here");
            return nullptr;
        }
        Adjacency adjacency = make_adjacency(*mesh);
        found = kept.emplace(key, Input{std::move(mesh), std::move(adjacency)}).first;
    }
    return &found->second;
}

void report(benchmark::State& state, const Input& in, std::size_t found) {
    state.counters["edges"] = static_cast<double>(in.adjacency.edges.size());
    state.counters["found"] = static_cast<double>(found);
    state.counters["edges/s"] = benchmark::Counter(static_cast<double>(in.adjacency.edges.size()),
                                                   benchmark::Counter::kIsIterationInvariantRate);
}

void make(benchmark::State& state) {
    if (const Input* in = input(state)) {
        for (auto _ : state) {
            benchmark::DoNotOptimize(make_adjacency(*in->mesh));
        }
        report(state, *in, 0);
    }
}

void cpu_flat(benchmark::State& state) {
    if (const Input* in = input(state)) {
        FlatSilhouettes flat{*in->mesh, in->adjacency};
        std::vector<SilhouetteEdge> found;
        int step = 0;
        for (auto _ : state) {
            found.clear();
            flat.find(light_at(step++), false, EdgeChoice::Silhouettes, found);
            benchmark::DoNotOptimize(found.data());
        }
        report(state, *in, found.size());
    }
}

void cpu_oracle(benchmark::State& state) {
    if (const Input* in = input(state)) {
        std::size_t found = 0;
        int step = 0;
        for (auto _ : state) {
            found = find_silhouettes(*in->mesh, in->adjacency, light_at(step++), false).size();
        }
        report(state, *in, found);
    }
}

RenderThread& thread() {
    static RenderThread made;
    return made;
}

void extract(benchmark::State& state, SilhouettePass::Source source) {
    if (const Input* in = input(state)) {
        Scene scene;
        scene.instances.push_back(scenes::place(in->mesh, "it"));
        thread().run([&](Device& gl) {
            BareFrame frame{gl, scene};
            SilhouettePass pass{{.source = source}};
            const std::vector<std::uint32_t> instances{0};
            pass.prepare(frame, frame.gpu_scene, frame->adjacency(), instances);
            int step = 0;
            for (auto _ : state) {
                const glm::dvec4 light = light_at(step++);
                pass.extract(frame, light, glm::dvec3{light});
                glFinish();
            }
            report(state, *in, pass.read_count());
        });
    }
}

void extract_gpu(benchmark::State& state) {
    extract(state, SilhouettePass::Source::Gpu);
}
void extract_cpu(benchmark::State& state) {
    extract(state, SilhouettePass::Source::Cpu);
}

void sizes(benchmark::internal::Benchmark* bench) {
    bench->ArgNames({"kind", "triangles"})->Unit(benchmark::kMillisecond);
    for (const int kind : {0, 1}) {
        for (const std::int64_t triangles : {10'000, 50'000, 200'000, 1'000'000}) {
            bench->Args({kind, triangles});
        }
    }
    bench->Args({2, 0});
}

BENCHMARK(make)->Apply(sizes);
BENCHMARK(cpu_oracle)->Apply(sizes);
BENCHMARK(cpu_flat)->Apply(sizes);
BENCHMARK(extract_gpu)->Apply(sizes)->UseRealTime();
BENCHMARK(extract_cpu)->Apply(sizes)->UseRealTime();

}  // namespace
}  // namespace penumbra

BENCHMARK_MAIN();
