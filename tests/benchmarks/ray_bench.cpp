// What trace_visibility costs beyond the rays themselves. The bare loops cast exactly the rays that trace_visibility
// casts (captured beforehand, so that they make none) and do nothing else but count what is hit: single rays, packets
// of 16 and, where Embree has them, streams. All use the same threads. Ours makes its rays from nothing but the View
// and the mask, and keeps nothing from frame to frame: what a frame costs after the camera moved. Column `ratio` is
// ours over the best bare loop: target 1.15.

#include <benchmark/benchmark.h>
#include <time.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <map>
#include <memory>
#include <numbers>
#include <string>
#include <vector>

#include "base/parallel.h"
#include "reference/embree_library.h"
#include "reference/light_mask.h"
#include "reference/light_points.h"
#include "reference/ray_reference.h"
#include "reference/sampling.h"
#include "reference/visibility_tracer.h"

namespace penumbra {
namespace {

constexpr double kPi = std::numbers::pi;
constexpr int kSide_px = 512;

/// Torus knot (2, 3) over the ground; 2 around * along triangles.
std::shared_ptr<Mesh> torus_knot(int around, int along) {
    auto mesh = std::make_shared<Mesh>();
    mesh->name = "torus knot";
    const auto centre = [](double t) {
        const double r = 1.0 + 0.4 * std::cos(3.0 * t);
        return glm::dvec3(r * std::cos(2.0 * t), r * std::sin(2.0 * t), 0.9 + 0.4 * std::sin(3.0 * t));
    };
    for (int i = 0; i < along; ++i) {
        const double t = 2.0 * kPi * i / along;
        const glm::dvec3 tangent = glm::normalize(centre(t + 1e-4) - centre(t - 1e-4));
        const glm::dvec3 side = glm::normalize(glm::cross(tangent, glm::dvec3(0, 0, 1)));
        const glm::dvec3 up = glm::cross(side, tangent);
        for (int j = 0; j < around; ++j) {
            const double a = 2.0 * kPi * j / around;
            mesh->positions_local.emplace_back(centre(t) + 0.16 * (std::cos(a) * side + std::sin(a) * up));
            const auto at = [&](int u, int v) { return static_cast<unsigned>(u % along * around + v % around); };
            mesh->triangles.emplace_back(at(i, j), at(i + 1, j), at(i + 1, j + 1));
            mesh->triangles.emplace_back(at(i, j), at(i + 1, j + 1), at(i, j + 1));
        }
    }
    return mesh;
}

std::shared_ptr<Mesh> ground() {
    auto mesh = std::make_shared<Mesh>();
    mesh->name = "ground";
    mesh->positions_local = {{-4, -4, 0}, {4, -4, 0}, {4, 4, 0}, {-4, 4, 0}};
    mesh->triangles = {{0, 1, 2}, {0, 2, 3}};
    return mesh;
}

struct Setup {
    Scene scene;
    View view;
    std::unique_ptr<RayScene> rays;
    std::vector<Light> lights;
    std::vector<std::vector<std::uint8_t>> masks;  ///< one per light
};

/// First hits of a pinhole camera, found by bisecting occlusion (the core has no closest-hit query): slow, but exact
/// enough to put receivers on the visible surfaces, knot and ground alike.
View make_view(const Scene& scene, const RayScene& rays) {
    View view;
    view.width = kSide_px;
    view.height = kSide_px;
    view.eye_ws = {3.2, -3.2, 3.0};
    view.position_cr.resize(view.size());
    view.normal_ws.resize(view.size());
    view.shading_normal_ws.resize(view.size());
    view.instance.assign(view.size(), -1);
    view.triangle.assign(view.size(), -1);
    const glm::dvec3 forward = glm::normalize(glm::dvec3(0, 0, 0.5) - view.eye_ws);
    const glm::dvec3 right = glm::normalize(glm::cross(forward, glm::dvec3(0, 0, 1)));
    const glm::dvec3 up = glm::cross(right, forward);
    const AnchorFrame& frame = rays.frame();
    const embree::Table& table = embree::library();
    const auto blocked = [&](const glm::dvec3& direction, double from, double to) {
        embree::Ray ray{};
        const glm::vec3 o{frame.point(view.eye_ws)};
        const glm::vec3 d{frame.vector(direction)};
        ray.org_x = o.x, ray.org_y = o.y, ray.org_z = o.z;
        ray.dir_x = d.x, ray.dir_y = d.y, ray.dir_z = d.z;
        ray.tnear = static_cast<float>(from);
        ray.tfar = static_cast<float>(to);
        ray.mask = ~0U;
        table.occluded1(rays.handle(), &ray);
        return ray.tfar < 0.0F;
    };
    Control control;
    parallel_for(
        kSide_px, 4,
        [&](std::int64_t begin, std::int64_t end) {
            for (std::int64_t i = begin * kSide_px; i < end * kSide_px; ++i) {
                const double x = ((static_cast<double>(i % kSide_px) + 0.5) / kSide_px - 0.5) * 0.9;
                const double y = ((static_cast<double>(i / kSide_px) + 0.5) / kSide_px - 0.5) * 0.9;
                const glm::dvec3 direction = glm::normalize(forward + x * right + y * up);
                double near = 0.0;
                double far = 20.0;
                if (!blocked(direction, near, far)) {
                    continue;
                }
                for (int step = 0; step < 24; ++step) {
                    const double middle = 0.5 * (near + far);
                    (blocked(direction, near, middle) ? far : near) = middle;
                }
                const glm::dvec3 p = view.eye_ws + direction * near;
                const bool on_ground = p.z < 1e-3;
                view.position_cr[i] = glm::vec3(direction * near);
                // On the knot any plausible normal will do: the ray loop does not care.
                view.normal_ws[i] = on_ground ? glm::vec3(0, 0, 1) : glm::vec3(-direction);
                view.shading_normal_ws[i] = view.normal_ws[i];
                view.instance[i] = on_ground ? 0 : 1;
                view.triangle[i] = 0;
            }
        },
        control);
    static_cast<void>(scene);
    return view;
}

const Setup& setup(int triangles) {
    static std::map<int, Setup> setups;
    const auto found = setups.find(triangles);
    if (found != setups.end()) {
        return found->second;
    }
    Setup& s = setups[triangles];
    const int around = static_cast<int>(std::lround(std::sqrt(triangles / 2.0 / 12.0)));
    for (const auto& mesh : {ground(), torus_knot(around, 12 * around)}) {
        Instance instance;
        instance.name = mesh->name;
        instance.mesh = mesh;
        s.scene.instances.push_back(instance);
    }
    Control control;
    s.rays = std::make_unique<RayScene>(s.scene, control);
    s.view = make_view(s.scene, *s.rays);
    Light light;
    light.kind = LightKind::Rectangle;
    light.name = "rectangle";
    light.position_ws = {0.5, 0.3, 3.5};
    light.half_u_ws = {0.5, 0, 0};
    light.half_v_ws = {0, 0.5, 0};
    s.lights.push_back(light);
    light.kind = LightKind::Point;
    light.name = "sphere";
    light.radius_m = 0.5;
    s.lights.push_back(light);
    for (const Light& each : s.lights) {
        s.masks.push_back(light_mask(s.scene, s.view, each));
    }
    return s;
}

/// The rays of trace_visibility in packets, in the order in which it casts them, tile by tile.
struct Captured {
    std::vector<RayPacket> packets;
    std::vector<embree::Ray> singles;
    std::vector<std::array<int, kRayLanes>> valid;
};

Captured capture(const Setup& s, int light_index, int count) {
    const Light& light = s.lights[light_index];
    const std::vector<std::uint8_t>& mask = s.masks[light_index];
    Captured captured;
    const LightPoints points{light, s.rays->frame()};
    const Strata strata = make_strata(count, false);
    const Tiles tiles{*s.rays, s.view};
    TileReceivers receivers;
    for (std::int64_t tile = 0; tile < tiles.count(); ++tile) {
        tiles.collect(mask, tile, receivers);
        const auto total = static_cast<std::int64_t>(receivers.count()) * count;
        for (std::int64_t first = 0; first < total; first += kRayLanes) {
            ReceiverLanes lanes{};
            SampleLanes samples{};
            std::array<int, kRayLanes> valid{};
            for (int i = 0; i < kRayLanes; ++i) {
                const std::int64_t ray = std::min(first + i, total - 1);
                const Receiver r = receivers[static_cast<int>(ray / count)];
                const auto sample = static_cast<int>(ray % count);
                lanes.px[i] = r.position_an.x, lanes.py[i] = r.position_an.y, lanes.pz[i] = r.position_an.z;
                lanes.nx[i] = r.normal.x, lanes.ny[i] = r.normal.y, lanes.nz[i] = r.normal.z;
                lanes.offset[i] = r.offset;
                float a;
                float b;
                uniform_pair(sequence_key(r.pixel, sequence_base(1, 0)), static_cast<std::uint32_t>(sample), a, b);
                samples.u[i] = strata.u[sample] + strata.width[sample] * a;
                samples.v[i] = strata.v[sample] + strata.height[sample] * b;
                valid[static_cast<std::size_t>(i)] = first + i < total ? -1 : 0;
            }
            RayPacket rays{};
            std::fill(std::begin(rays.mask), std::end(rays.mask), ~0U);
            points.aim(lanes, samples, rays);
            captured.packets.push_back(rays);
            captured.valid.push_back(valid);
            for (int i = 0; i < kRayLanes; ++i) {
                if (valid[static_cast<std::size_t>(i)] != 0) {
                    captured.singles.push_back({rays.org_x[i], rays.org_y[i], rays.org_z[i], 0.0F, rays.dir_x[i],
                                                rays.dir_y[i], rays.dir_z[i], 0.0F, rays.tfar[i], ~0U, 0U, 0U});
                }
            }
        }
    }
    return captured;
}

/// Captured rays are costly to keep (1 GB at 64 rays); one set at a time.
const Captured& captured_rays(int triangles, int light, int count) {
    static std::string held;
    static std::unique_ptr<Captured> kept;
    const std::string key = std::to_string(triangles) + "/" + std::to_string(light) + "/" + std::to_string(count);
    if (key != held) {
        kept.reset();
        const Setup& s = setup(triangles);
        kept = std::make_unique<Captured>(capture(s, light, count));
        held = key;
    }
    return *kept;
}

enum class Method { Ours, Single, Packet16, Stream };
const char* name_of(Method method) {
    switch (method) {
        case Method::Ours:
            return "ours";
        case Method::Single:
            return "single";
        case Method::Packet16:
            return "packet";
        case Method::Stream:
            return "stream";
    }
    return "";
}

/// One frame; returns the share of rays that are blocked, as a check that all methods cast the same ones.
double frame(Method method, int triangles, int light_index, int count) {
    const Setup& s = setup(triangles);
    const Light& light = s.lights[light_index];
    const embree::Table& table = embree::library();
    Control control;
    std::atomic<std::uint64_t> blocked{0};
    if (method == Method::Ours) {
        static std::vector<float> visibility(s.view.size());  // the caller's, kept between frames
        TraceOptions options;
        options.rays_per_pixel = count;
        trace_visibility(*s.rays, s.scene, s.view, light, s.masks[light_index], options, visibility, control);
        benchmark::DoNotOptimize(visibility.data());
        return 0.0;
    }
    const Captured& rays = captured_rays(triangles, light_index, count);
    if (method == Method::Packet16) {
        parallel_for(
            static_cast<std::int64_t>(rays.packets.size()), 16 * count,
            [&](std::int64_t begin, std::int64_t end) {
                std::uint64_t mine = 0;
                for (std::int64_t i = begin; i < end; ++i) {
                    RayPacket packet = rays.packets[i];  // Embree writes into it
                    alignas(64) std::array<int, kRayLanes> valid = rays.valid[i];
                    table.occluded16(valid.data(), s.rays->handle(), &packet);
                    for (int lane = 0; lane < kRayLanes; ++lane) {
                        mine += packet.tfar[lane] < 0.0F ? 1U : 0U;
                    }
                }
                blocked += mine;
            },
            control);
    } else {
        parallel_for(
            static_cast<std::int64_t>(rays.singles.size()), 256 * count,
            [&](std::int64_t begin, std::int64_t end) {
                std::uint64_t mine = 0;
                if (method == Method::Single) {
                    for (std::int64_t i = begin; i < end; ++i) {
                        embree::Ray ray = rays.singles[i];
                        table.occluded1(s.rays->handle(), &ray);
                        mine += ray.tfar < 0.0F ? 1U : 0U;
                    }
                } else {
                    constexpr std::int64_t kBatch = 256;
                    std::array<embree::Ray, kBatch> batch;
                    for (std::int64_t i = begin; i < end; i += kBatch) {
                        const std::int64_t n = std::min(kBatch, end - i);
                        std::copy_n(rays.singles.begin() + i, n, batch.begin());
                        table.occluded_stream(s.rays->handle(), batch.data(), static_cast<unsigned>(n));
                        for (std::int64_t j = 0; j < n; ++j) {
                            mine += batch[j].tfar < 0.0F ? 1U : 0U;
                        }
                    }
                }
                blocked += mine;
            },
            control);
    }
    benchmark::DoNotOptimize(blocked);
    return static_cast<double>(blocked) / static_cast<double>(rays.singles.size());
}

/// Seconds of processor time this process has used, all threads.
double cpu_seconds() {
    timespec now{};
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &now);
    return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

double median(std::vector<double> values) {
    const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
    std::nth_element(values.begin(), middle, values.end());
    return *middle;
}

/// Ours and each bare loop, measured in turns so that drift hits all alike. `ratio` compares the medians of wall times,
/// as a user sees them; `cpu_ratio` those of processor times; `best_ratio` the least processor times, which tell most
/// on a machine that is busy with other things.
void ratio(benchmark::State& state) {
    const auto triangles = static_cast<int>(state.range(0));
    const auto light = static_cast<int>(state.range(1));
    const auto count = static_cast<int>(state.range(2));
    std::vector<Method> methods{Method::Ours, Method::Single, Method::Packet16};
    if (embree::library().occluded_stream != nullptr) {
        methods.push_back(Method::Stream);
    }
    std::vector<std::vector<double>> wall(methods.size());
    std::vector<std::vector<double>> cpu(methods.size());
    for (const Method method : methods) {
        frame(method, triangles, light, count);  // warm up
    }
    for (auto _ : state) {
        for (std::size_t m = 0; m < methods.size(); ++m) {
            const double cpu_start = cpu_seconds();
            const auto start = std::chrono::steady_clock::now();
            frame(methods[m], triangles, light, count);
            wall[m].push_back(std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count());
            cpu[m].push_back(cpu_seconds() - cpu_start);
        }
        state.SetIterationTime(wall[0].back());
    }
    double best_wall = 1e300;
    double best_cpu = 1e300;
    double least_cpu = 1e300;
    for (std::size_t m = 0; m < methods.size(); ++m) {
        state.counters[std::string{name_of(methods[m])} + " ms"] = 1000.0 * median(wall[m]);
        if (m > 0) {
            best_wall = std::min(best_wall, median(wall[m]));
            best_cpu = std::min(best_cpu, median(cpu[m]));
            least_cpu = std::min(least_cpu, *std::min_element(cpu[m].begin(), cpu[m].end()));
        }
    }
    const auto rays = static_cast<double>(captured_rays(triangles, light, count).singles.size());
    state.counters["Mrays/s"] = rays / median(wall[0]) / 1e6;
    state.counters["ratio"] = median(wall[0]) / best_wall;
    state.counters["cpu_ratio"] = median(cpu[0]) / best_cpu;
    state.counters["best_ratio"] = *std::min_element(cpu[0].begin(), cpu[0].end()) / least_cpu;
    state.SetLabel(setup(triangles).lights[light].name);
}

BENCHMARK(ratio)
    ->Name("trace_visibility_over_bare")
    ->ArgNames({"triangles", "light", "rays"})
    ->ArgsProduct({{12000, 50000}, {0, 1}, {1, 4, 16, 64}})
    ->Unit(benchmark::kMillisecond)
    ->UseManualTime()
    ->Iterations(15);

/// The adaptive reference at its default standard error, 512 x 512.
void reference(benchmark::State& state) {
    const Setup& s = setup(static_cast<int>(state.range(0)));
    const Light& light = s.lights[static_cast<std::size_t>(state.range(1))];
    for (auto _ : state) {
        Control control;
        const Reference result = trace_reference(*s.rays, s.scene, s.view, light, ReferenceOptions{}, control);
        state.counters["rays_per_pixel"] = result.mean_rays_per_pixel;
        state.counters["Mrays/s"] = static_cast<double>(result.rays) / result.time_ms / 1e3;
    }
    state.SetLabel(light.name);
}

BENCHMARK(reference)
    ->ArgNames({"triangles", "light"})
    ->ArgsProduct({{12000, 50000}, {0, 1}})
    ->Unit(benchmark::kMillisecond)
    ->UseRealTime()
    ->Iterations(1);

}  // namespace
}  // namespace penumbra

BENCHMARK_MAIN();
