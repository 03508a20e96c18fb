#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <memory>
#include <random>
#include <set>

#include "passes/silhouette_pass.h"
#include "support/bare_frame.h"
#include "support/obj.h"
#include "support/scenes.h"
#include "support/skip.h"

namespace penumbra {
namespace {

using Source = SilhouettePass::Source;

Scene one(std::shared_ptr<const Mesh> mesh, const glm::dmat4& world_from_local = glm::dmat4{1.0}) {
    Scene scene;
    scene.instances.push_back(scenes::place(std::move(mesh), "it"));
    scene.instances[0].world_from_local = world_from_local;
    return scene;
}

/// Instance and vertices a, b, z.
using Triple = std::array<std::uint32_t, 4>;

std::vector<Triple> ids_of(const std::vector<gpu::SilhouetteRecord>& records) {
    std::vector<Triple> ids;
    for (const auto& record : records) {
        ids.push_back({record.ids.x, record.ids.y, record.ids.z, record.ids.w});
    }
    return ids;
}

bool finite(const gpu::SilhouetteRecord& record) {
    for (const glm::vec4& v : {record.a_rel, record.b_rel, record.z_rel}) {
        for (int k = 0; k < 4; ++k) {
            if (!std::isfinite(v[k])) {
                return false;
            }
        }
    }
    return true;
}

/// One context for all tests; each makes its own scene and pass on it.
class SilhouetteGl : public testing::Test {
protected:
    struct Found {
        std::vector<gpu::SilhouetteRecord> records;
        std::uint32_t count = 0;
        std::uint64_t edge_count = 0;
    };

    void SetUp() override {
        if (!thread()) {
            try {
                thread() = std::make_unique<RenderThread>();
            } catch (const DeviceError& error) {
                PENUMBRA_SKIP(error.what());
            }
        }
    }
    static std::unique_ptr<RenderThread>& thread() {
        static std::unique_ptr<RenderThread> made;
        return made;
    }

    /// Runs work(bench) on the render thread with the scene sent.
    template <class F>
    auto with(const Scene& scene, F&& work) {
        return thread()->run([&](Device& device) {
            BareFrame frame{device, scene};
            return work(frame);
        });
    }

    static std::vector<std::uint32_t> all_of(const Scene& scene) {
        std::vector<std::uint32_t> instances(scene.instances.size());
        for (std::uint32_t i = 0; i < instances.size(); ++i) {
            instances[i] = i;
        }
        return instances;
    }

    Found extract(const Scene& scene, const glm::dvec4& light_ws, const glm::dvec3& origin_ws,
                  const SilhouettePass::Options& options = {}) {
        return with(scene, [&](BareFrame& frame) {
            SilhouettePass pass{options};
            pass.prepare(frame, frame.gpu_scene, frame->adjacency(), all_of(scene));
            pass.extract(frame, light_ws, origin_ws);
            return Found{pass.read(), pass.read_count(), pass.edge_count()};
        });
    }

    /// Extraction for a few points and suns around the only instance equals the oracle's answer for the positions that
    /// the device has; edges and corners that touch a triangle within a few roundings of the edge-on band left out.
    void expect_oracle(const Scene& scene, std::mt19937& random, int lights) {
        with(scene, [&](BareFrame& frame) {
            const auto& range = frame.gpu_scene.mesh_ranges()[0];
            const glm::dmat4& matrix = frame.gpu_scene.world_from_recentred(0);
            Mesh mesh = *scene.instances[0].mesh;
            for (glm::vec3& p : mesh.positions_local) {
                p = glm::vec3{glm::dvec3{p} - range.centre_local};
            }
            const Adjacency adjacency = make_adjacency(mesh);
            SilhouettePass pass{{}};
            pass.prepare(frame, frame.gpu_scene, frame->adjacency(), all_of(scene));
            std::uniform_real_distribution<double> at{-1.0, 1.0};
            for (int run = 0; run < lights; ++run) {
                // Within two radii, far away, a sun, then on the grid of the soups' vertices.
                const glm::dvec3 p{at(random), at(random), at(random)};
                const double radius = range.bounds_local.radius();
                const glm::dvec4 light_local = run % 4 == 0   ? glm::dvec4{2.0 * radius * p, 1.0}
                                               : run % 4 == 1 ? glm::dvec4{1e4 * radius * p, 1.0}
                                               : run % 4 == 2 ? glm::dvec4{glm::normalize(p), 0.0}
                                                              : glm::dvec4{glm::round(4.0 * p) * radius, 1.0};
                const glm::dvec4 light_ws = matrix * light_local;
                const glm::dvec3 origin_ws = glm::dvec3{light_ws} + 0.1 * radius;
                pass.extract(frame, light_ws, origin_ws);
                const auto records = pass.read();
                EXPECT_TRUE(std::all_of(records.begin(), records.end(), finite));
                // What the rounding of the world's float64 has left of the light.
                const glm::dvec3 seen =
                    glm::inverse(glm::dmat3{matrix}) * (glm::dvec3{light_ws} - light_ws.w * glm::dvec3{matrix[3]});
                compare(mesh, adjacency, {light_ws.w == 0.0 ? glm::normalize(seen) : seen, light_ws.w},
                        glm::determinant(glm::dmat3{matrix}) < 0.0, records);
            }
            return 0;
        });
    }

    static void compare(const Mesh& mesh, const Adjacency& adjacency, const glm::dvec4& light, bool mirrored,
                        const std::vector<gpu::SilhouetteRecord>& records) {
        std::vector<bool> unsure(mesh.triangles.size()), unsure_vertex(mesh.positions_local.size());
        for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
            const glm::uvec3& v = mesh.triangles[t];
            const glm::dvec3 a{mesh.positions_local[v.x]};
            const glm::dvec3 u = glm::dvec3{mesh.positions_local[v.y]} - a,
                             w = glm::dvec3{mesh.positions_local[v.z]} - a;
            const glm::dvec3 to = light.w == 0.0 ? glm::dvec3{light} : glm::dvec3{light} - a;
            const double sine = std::abs(glm::dot(glm::cross(u, w), to));
            const double lengths = glm::length(u) * glm::length(w) * glm::length(to);
            // Exactly edge-on is sure, just around the band's border it is not.
            unsure[t] = sine > 0.3e-6 * lengths && sine < 1.7e-6 * lengths;
            for (int k = 0; k < 3; ++k) {
                unsure_vertex[adjacency.welded[v[k]]] = unsure_vertex[adjacency.welded[v[k]]] || unsure[t];
            }
        }
        const auto sure = [&](std::uint32_t a, std::uint32_t b) { return !unsure_vertex[a] && !unsure_vertex[b]; };
        std::vector<Triple> expected, found;
        for (const SilhouetteEdge& edge : find_silhouettes(mesh, adjacency, light, mirrored)) {
            if (sure(edge.a, edge.b)) {
                expected.push_back({0, edge.a, edge.b, edge.z});
            }
        }
        for (const Triple& ids : ids_of(records)) {
            if (sure(ids[1], ids[2])) {
                found.push_back(ids);
            }
        }
        std::sort(expected.begin(), expected.end());
        std::sort(found.begin(), found.end());
        EXPECT_TRUE(expected == found) << expected.size() << " expected, " << found.size() << " found, light "
                                       << light.x << ", " << light.y << ", " << light.z << ", " << light.w;
        EXPECT_GE(static_cast<double>(expected.size()) + 100.0, 0.99 * static_cast<double>(records.size()));
    }
};

TEST_F(SilhouetteGl, ACubeFromAGenericPointHasOneLoopOfSix) {
    const Found found = extract(one(scenes::box(glm::vec3{-1}, glm::vec3{1})), {4.0, 5.0, 6.0, 1.0}, {4.0, 5.0, 6.0});
    ASSERT_EQ(found.count, 6U);
    EXPECT_EQ(found.edge_count, 18U);
    std::map<std::uint32_t, const gpu::SilhouetteRecord*> by_start;
    for (const auto& record : found.records) {
        by_start[record.ids.y] = &record;
        EXPECT_EQ(record.a_rel.w, 1.0F);
    }
    ASSERT_EQ(by_start.size(), 6U);
    std::uint32_t at = found.records[0].ids.y;
    for (int i = 0; i < 6; ++i) {
        const auto* record = by_start.at(at);
        EXPECT_EQ(by_start.at(record->ids.z)->ids.w, at);
        EXPECT_EQ(by_start.at(record->ids.z)->a_rel.x, record->b_rel.x);
        at = record->ids.z;
    }
    EXPECT_EQ(at, found.records[0].ids.y);
}

std::shared_ptr<Mesh> soup(std::mt19937& random, int triangles) {
    auto mesh = std::make_shared<Mesh>();
    mesh->name = "soup";
    std::uniform_int_distribution<int> cell{-2, 2};
    for (int i = 0; i < triangles; ++i) {
        mesh->positions_local.emplace_back(cell(random), cell(random), cell(random));
    }
    std::uniform_int_distribution<std::uint32_t> vertex{0, static_cast<std::uint32_t>(triangles) - 1};
    for (int t = 0; t < triangles; ++t) {
        mesh->triangles.emplace_back(vertex(random), vertex(random), vertex(random));
    }
    return mesh;
}

std::shared_ptr<Mesh> crumpled_sphere(int rings, unsigned seed) {
    auto mesh = scenes::sphere(rings, false);
    std::mt19937 random{seed};
    std::uniform_real_distribution<float> factor{0.5F, 1.5F};
    for (glm::vec3& p : mesh->positions_local) {
        p = std::abs(p.z) == 1.0F ? glm::vec3{0.0F, 0.0F, p.z} : p * factor(random);
    }
    return mesh;
}

/// Where an instance stands in a test of placing.
struct Placing {
    const char* name;
    glm::dmat4 world_from_local;
};
std::vector<Placing> placings() {
    const auto with = [](glm::dmat3 linear, const glm::dvec3& move) {
        glm::dmat4 matrix{linear};
        matrix[3] = glm::dvec4{move, 1.0};
        return matrix;
    };
    const glm::dmat3 turn = scenes::odd_turn();
    const glm::dmat3 mirror{{-1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
    const glm::dmat3 shear{{1, 0, 0}, {0.7, 1, 0}, {-0.4, 0.9, 0.5}};
    return {{"as it is", glm::dmat4{1.0}},
            {"mirrored", with(mirror * turn, {1, 2, 3})},
            {"sheared", with(turn * shear, {0, 0, 1})},
            {"small", with(1e-4 * turn, {1e-4, 0, 0})},
            {"large", with(1e4 * turn * shear, {0, -1e4, 0})},
            {"far away", with(turn, {1e6, -2e6, 3e6})},
            {"small, mirrored and far away", with(1e-2 * (mirror * turn), {-1e6, 1e6, 1e6})}};
}

TEST_F(SilhouetteGl, AreTheOraclesWhereverTheInstanceStands) {
    std::mt19937 random{23};
    std::vector<std::shared_ptr<Mesh>> meshes{crumpled_sphere(12, 1), soup(random, 60), soup(random, 200)};
    for (const char* file : {"spot.obj", "fandisk.obj", "teapot.obj"}) {
        if (auto model = read_model(file)) {
            meshes.push_back(std::move(model));
        }
    }
    for (const auto& mesh : meshes) {
        for (const Placing& placing : placings()) {
            SCOPED_TRACE(mesh->name + ", " + placing.name);
            expect_oracle(one(mesh, placing.world_from_local), random, 4);
        }
    }
}

TEST_F(SilhouetteGl, OfTheBunnyAreTheOracles) {
    const auto bunny = read_model("stanford-bunny.obj");
    if (!bunny) {
        GTEST_SKIP() << "stanford-bunny.obj is not here (PENUMBRA_MODELS names its folder)";
    }
    std::mt19937 random{29};
    expect_oracle(one(bunny), random, 6);
}

TEST_F(SilhouetteGl, OfManySoupsAreTheOracles) {
    std::mt19937 random{31};
    for (int run = 0; run < 30; ++run) {
        SCOPED_TRACE(run);
        expect_oracle(one(soup(random, 30 + 10 * run)), random, 2);
    }
}

TEST_F(SilhouetteGl, TheCpuSourceGivesTheSameRecords) {
    std::mt19937 random{37};
    Scene scene;
    for (const Placing& placing : placings()) {
        scene.instances.push_back(one(crumpled_sphere(8, 7), placing.world_from_local).instances[0]);
    }
    const glm::dvec4 light{3.1, 2.2, 4.3, 1.0};
    const glm::dvec3 origin{3.1, 2.2, 4.3};
    for (const EdgeChoice choice : {EdgeChoice::Silhouettes, EdgeChoice::LightFacing, EdgeChoice::All}) {
        const Found gpu = extract(scene, light, origin, {.choice = choice});
        const Found cpu = extract(scene, light, origin, {.source = Source::Cpu, .choice = choice});
        ASSERT_EQ(gpu.count, cpu.count);
        EXPECT_EQ(extract(scene, light, origin, {.source = Source::Auto, .choice = choice}).count, cpu.count);
        const auto by_ids = [](const Found& found) {
            std::map<Triple, gpu::SilhouetteRecord> map;
            for (const auto& record : found.records) {
                map[{record.ids.x, record.ids.y, record.ids.z, record.ids.w}] = record;
            }
            return map;
        };
        const auto one_map = by_ids(gpu), other_map = by_ids(cpu);
        EXPECT_EQ(one_map.size(), gpu.count);
        for (const auto& [ids, record] : one_map) {
            const auto same = other_map.find(ids);
            ASSERT_NE(same, other_map.end());
            // Sums in float32 are off by the rounding of their parts, here the instance's place and its size.
            const glm::dmat4& m = scene.instances[ids[0]].world_from_local;
            const double parts = glm::length(glm::dvec3{m[3]} - origin) + 3.0 * glm::length(glm::dvec3{m[0]});
            const auto tolerance = static_cast<float>(4e-7 * parts);
            EXPECT_LE(glm::length(glm::vec3{record.a_rel - same->second.a_rel}), tolerance);
            EXPECT_EQ(record.a_rel.w, same->second.a_rel.w);
        }
    }
}

TEST_F(SilhouetteGl, PositionsAreThoseOfTheWorldRelativeToTheOrigin) {
    const auto mesh = crumpled_sphere(8, 9);
    for (const Placing& placing : placings()) {
        SCOPED_TRACE(placing.name);
        const Scene scene = one(mesh, placing.world_from_local);
        const glm::dvec3 near{placing.world_from_local * glm::dvec4{2.0, 1.5, 3.0, 1.0}};
        const Found found = extract(scene, {near, 1.0}, near);
        const double size = glm::length(glm::dvec3{placing.world_from_local[0]});
        ASSERT_GT(found.records.size(), 0U);
        for (const auto& record : found.records) {
            const auto check = [&](const glm::vec4& rel, std::uint32_t v) {
                const glm::dvec3 world{placing.world_from_local *
                                       glm::dvec4{glm::dvec3{mesh->positions_local[v]}, 1.0}};
                // Half a metre in 1e6 m leaves some 1e-10 m of float64 itself.
                EXPECT_LT(glm::length(glm::dvec3{glm::vec3{rel}} - (world - near)), 3e-6 * size + 4e-9);
            };
            check(record.a_rel, record.ids.y);
            check(record.b_rel, record.ids.z);
            check(record.z_rel, record.ids.w);
            EXPECT_EQ(record.a_rel.w, record.ids.w != record.ids.y ? 1.0F : 0.0F);
        }
    }
}

TEST_F(SilhouetteGl, WhatBlocksLiesOnTheLeftOfAnObserverAtTheLight) {
    for (const Placing& placing : placings()) {
        for (const double height : {2.0, -2.0}) {
            const auto mesh = scenes::mesh("t", {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}, {{0, 1, 2}});
            const glm::dvec3 light{placing.world_from_local * glm::dvec4{0.3, 0.2, height, 1.0}};
            const Found found = extract(one(mesh, placing.world_from_local), {light, 1.0}, light);
            ASSERT_EQ(found.count, 3U);
            for (const auto& record : found.records) {
                // The light is the origin: towards it from a is -a.
                const glm::dvec3 a{record.a_rel}, b{record.b_rel}, c{record.z_rel};
                EXPECT_GT(glm::dot(glm::cross(b - a, c - a), -a), 0.0) << placing.name << ", " << height;
            }
        }
    }
}

TEST_F(SilhouetteGl, PermutedTrianglesGiveTheSameRecords) {
    const auto mesh = crumpled_sphere(12, 11);
    auto permuted = std::make_shared<Mesh>(*mesh);
    std::mt19937 random{41};
    std::shuffle(permuted->triangles.begin(), permuted->triangles.end(), random);
    const glm::dvec4 light{3, 2, 1, 1};
    const auto bytes_of = [](const Found& found) {
        std::multiset<std::array<float, 12>> set;
        for (const auto& r : found.records) {
            set.insert({r.a_rel.x, r.a_rel.y, r.a_rel.z, r.a_rel.w, r.b_rel.x, r.b_rel.y, r.b_rel.z, r.b_rel.w,
                        r.z_rel.x, r.z_rel.y, r.z_rel.z, r.z_rel.w});
        }
        return set;
    };
    EXPECT_EQ(bytes_of(extract(one(mesh), light, {3, 2, 1})), bytes_of(extract(one(permuted), light, {3, 2, 1})));
}

TEST_F(SilhouetteGl, FromWithinAMeshThereAreNone) {
    EXPECT_EQ(extract(one(scenes::box(glm::vec3{-1}, glm::vec3{1})), {0.1, 0.2, 0.3, 1.0}, {}).count, 0U);
}

TEST_F(SilhouetteGl, ALightInAFacesPlaneGivesTheOraclesDoubledOutline) {
    const auto mesh = scenes::box(glm::vec3{-1}, glm::vec3{1});
    const glm::dvec4 light{4, 0.3, 1, 1};
    const auto edges = find_silhouettes(*mesh, make_adjacency(*mesh), light, false);
    std::vector<Triple> expected;
    for (const SilhouetteEdge& edge : edges) {
        expected.push_back({0, edge.a, edge.b, edge.z});
    }
    EXPECT_THAT(ids_of(extract(one(mesh), light, {}).records), testing::UnorderedElementsAreArray(expected));
}

TEST_F(SilhouetteGl, ChoicesCountAllEdgesAndLightFacingTriangles) {
    const auto mesh = scenes::box(glm::vec3{-1}, glm::vec3{1});
    const Found all = extract(one(mesh), {4, 5, 6, 1}, {}, {.choice = EdgeChoice::All});
    EXPECT_EQ(all.count, 36U);
    EXPECT_EQ(all.edge_count, 18U);
    const Found facing = extract(one(mesh), {4, 5, 6, 1}, {}, {.choice = EdgeChoice::LightFacing});
    EXPECT_EQ(facing.count, 18U);
    for (const auto& record : facing.records) {
        EXPECT_EQ(record.a_rel.w, 1.0F);
    }
}

TEST_F(SilhouetteGl, NothingComesOfNothing) {
    const Scene empty;
    for (const Source source : {Source::Gpu, Source::Cpu}) {
        EXPECT_EQ(extract(empty, {0, 0, 1, 1}, {}, {.source = source}).count, 0U);
    }
    // Triangles without area alone.
    const auto needle = scenes::mesh("needle", {{0, 0, 0}, {1, 0, 0}, {2, 0, 0}}, {{0, 1, 1}});
    EXPECT_EQ(extract(one(needle), {0, 0, 1, 1}, {}).count, 0U);
    // Not of one place, but of no area: no vote, so each edge comes both ways round, not paired.
    const auto line = scenes::mesh("line", {{0, 0, 0}, {1, 0, 0}, {2, 0, 0}}, {{0, 1, 2}});
    const Found found = extract(one(line), {0, 0, 1, 1}, {});
    EXPECT_EQ(found.count, 6U);
    for (const auto& record : found.records) {
        EXPECT_EQ(record.a_rel.w, 0.0F);
    }
}

TEST_F(SilhouetteGl, RoomGrowsWhereMoreIsFoundThanFits) {
    const auto mesh = crumpled_sphere(20, 13);
    const glm::dvec4 light{3, 2, 1, 1};
    for (const EdgeChoice choice : {EdgeChoice::Silhouettes, EdgeChoice::LightFacing, EdgeChoice::All}) {
        const Found roomy = extract(one(mesh), light, {}, {.choice = choice});
        const Found tight = extract(one(mesh), light, {}, {.choice = choice, .first_bytes = 64});
        EXPECT_GT(roomy.count, 100U);
        EXPECT_EQ(tight.count, roomy.count);
        EXPECT_THAT(ids_of(tight.records), testing::UnorderedElementsAreArray(ids_of(roomy.records)));
        const Found cpu = extract(one(mesh), light, {}, {.source = Source::Cpu, .choice = choice, .first_bytes = 64});
        EXPECT_EQ(cpu.records.size(), roomy.count);
    }
}

TEST_F(SilhouetteGl, ExtractingAgainForgetsWhatWasFoundBefore) {
    const Scene scene = one(scenes::box(glm::vec3{-1}, glm::vec3{1}));
    with(scene, [&](BareFrame& frame) {
        SilhouettePass pass{{}};
        pass.prepare(frame, frame.gpu_scene, frame->adjacency(), all_of(scene));
        pass.extract(frame, {4, 5, 6, 1}, {});
        EXPECT_EQ(pass.read_count(), 6U);
        pass.extract(frame, {0, 0.1, 6, 1}, {});
        EXPECT_EQ(pass.read_count(), 4U);
        pass.extract(frame, {0, 0.1, 0.2, 1}, {});
        EXPECT_EQ(pass.read_count(), 0U);
        return 0;
    });
}

TEST_F(SilhouetteGl, InstancesShareTheirMeshsAdjacency) {
    const auto mesh = crumpled_sphere(10, 17);
    const auto bytes = [&](int count) {
        Scene scene;
        for (int i = 0; i < count; ++i) {
            scene.instances.push_back(scenes::place(mesh, "copy", {3.0 * i, 0, 0}));
        }
        return with(scene, [&](BareFrame& frame) { return frame->adjacency().memory_bytes(); });
    };
    EXPECT_EQ(bytes(1), bytes(50));
}

TEST_F(SilhouetteGl, ManyThousandInstancesAreOneDispatch) {
    // More work groups than a row of them holds.
    const auto mesh =
        scenes::mesh("t", {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}}, {{0, 2, 1}, {0, 1, 3}, {1, 2, 3}, {0, 3, 2}});
    const Adjacency adjacency = make_adjacency(*mesh);
    const glm::dvec4 light{70.3, 80.4, 90.7, 1.0};
    Scene scene;
    std::vector<Triple> expected;
    for (std::uint32_t i = 0; i < 40000; ++i) {
        const glm::dvec3 at{i % 200, i / 200, 0.5 * (i % 7)};
        scene.instances.push_back(scenes::place(mesh, "copy", at));
        for (const SilhouetteEdge& edge : find_silhouettes(*mesh, adjacency, light - glm::dvec4{at, 0.0}, false)) {
            expected.push_back({i, edge.a, edge.b, edge.z});
        }
    }
    auto found = ids_of(extract(scene, light, {}).records);
    std::sort(found.begin(), found.end());
    std::sort(expected.begin(), expected.end());
    EXPECT_TRUE(found == expected) << found.size() << " and " << expected.size();
}

TEST_F(SilhouetteGl, DrawsAsManyVerticesAsAskedForEachRecord) {
    const Scene scene = one(scenes::box(glm::vec3{-1}, glm::vec3{1}));
    const ShaderSources sources{{"points.vert", "void main() { gl_Position = vec4(0.0, 0.0, 0.0, 1.0); }"}};
    with(scene, [&](BareFrame& frame) {
        ProgramLibrary programs{sources};
        TextureImage pixel = TextureImage::make_2d(GL_R8, 1, 1, "pixel");
        RenderTarget target{"pixel"};
        target.attach_colour(0, pixel);
        target.bind();
        SilhouettePass pass{{}};
        pass.prepare(frame, frame.gpu_scene, frame->adjacency(), all_of(scene));
        const auto drawn = [&](GLenum mode, int vertices) {
            programs.get({"points.vert"}).use();
            Query query = Query::create(GL_PRIMITIVES_GENERATED);
            glEnable(GL_RASTERIZER_DISCARD);
            glBeginQuery(GL_PRIMITIVES_GENERATED, query.name());
            pass.draw(frame, mode, vertices);
            glEndQuery(GL_PRIMITIVES_GENERATED);
            glDisable(GL_RASTERIZER_DISCARD);
            GLuint count = 0;
            glGetQueryObjectuiv(query.name(), GL_QUERY_RESULT, &count);
            return count;
        };
        EXPECT_EQ(drawn(GL_POINTS, 1), 0U) << "before anything was extracted";
        pass.extract(frame, {4, 5, 6, 1}, {});
        EXPECT_EQ(drawn(GL_POINTS, 1), 6U);
        EXPECT_EQ(drawn(GL_LINES, 2), 6U);
        EXPECT_EQ(drawn(GL_TRIANGLES, 6), 12U);
        EXPECT_EQ(drawn(GL_TRIANGLES, 255), 510U);
        EXPECT_EQ(drawn(GL_POINTS, PENUMBRA_MAX_VERTICES_PER_EDGE), 6U * PENUMBRA_MAX_VERTICES_PER_EDGE);
        pass.extract(frame, {0, 0.1, 6, 1}, {});
        EXPECT_EQ(drawn(GL_TRIANGLES, 6), 8U);
        return 0;
    });
}

}  // namespace
}  // namespace penumbra
