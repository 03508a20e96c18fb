#include "geometry/silhouettes.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <random>
#include <set>

#include "support/obj.h"
#include "support/scenes.h"

namespace penumbra {
namespace {

using Edges = std::vector<SilhouetteEdge>;

Edges find(const Mesh& mesh, const glm::dvec4& light, bool mirrored = false,
           EdgeChoice choice = EdgeChoice::Silhouettes) {
    return find_silhouettes(mesh, make_adjacency(mesh), light, mirrored, choice);
}

std::multiset<std::pair<std::uint32_t, std::uint32_t>> directions(const Edges& edges) {
    std::multiset<std::pair<std::uint32_t, std::uint32_t>> set;
    for (const SilhouetteEdge& edge : edges) {
        set.emplace(edge.a, edge.b);
    }
    return set;
}

/// c lies left of a->b as an observer at the light sees it.
bool left_of(const glm::dvec3& a, const glm::dvec3& b, const glm::dvec3& c, const glm::dvec4& light) {
    const glm::dvec3 to_light = light.w == 0.0 ? glm::dvec3{light} : glm::dvec3{light} - a;
    return glm::dot(glm::cross(b - a, c - a), to_light) > 0.0;
}

/// Every start is paired, with an edge that ends there, and no edge is paired twice: the edges are closed loops.
void expect_closed_loops(const Edges& edges) {
    auto ends = directions(edges);
    for (const SilhouetteEdge& edge : edges) {
        EXPECT_NE(edge.z, edge.a);
        const auto arriving = ends.find({edge.z, edge.a});
        ASSERT_NE(arriving, ends.end()) << edge.z << " -> " << edge.a << " -> " << edge.b;
        ends.erase(arriving);
    }
    EXPECT_TRUE(ends.empty());
}

int loops(const Edges& edges) {
    std::map<std::pair<std::uint32_t, std::uint32_t>, std::pair<std::uint32_t, std::uint32_t>> before;
    std::map<std::pair<std::uint32_t, std::uint32_t>, const SilhouetteEdge*> by_ends;
    for (const SilhouetteEdge& edge : edges) {
        by_ends[{edge.a, edge.b}] = &edge;
    }
    int count = 0;
    while (!by_ends.empty()) {
        ++count;
        for (auto at = by_ends.begin(); at != by_ends.end();) {
            const std::pair<std::uint32_t, std::uint32_t> next{at->second->z, at->second->a};
            by_ends.erase(at);
            at = by_ends.find(next);
        }
    }
    return count;
}

/// The definition once more, without adjacency: triangles collected by the places of their edges' ends.
std::multiset<std::pair<std::uint32_t, std::uint32_t>> naive(const Mesh& mesh, const glm::dvec4& light, bool mirrored) {
    std::map<std::array<float, 3>, std::uint32_t> places;
    std::vector<std::uint32_t> welded;
    for (std::uint32_t i = 0; i < mesh.positions_local.size(); ++i) {
        const glm::vec3 p = mesh.positions_local[i] + 0.0F;
        welded.push_back(places.emplace(std::array{p.x, p.y, p.z}, i).first->second);
    }
    struct Votes {
        int left = 0, right = 0;
    };
    std::map<std::pair<std::uint32_t, std::uint32_t>, Votes> votes;
    for (const glm::uvec3& t : mesh.triangles) {
        const std::array<std::uint32_t, 3> v{welded[t.x], welded[t.y], welded[t.z]};
        if (v[0] == v[1] || v[1] == v[2] || v[2] == v[0]) {
            continue;
        }
        const glm::dvec3 p[3] = {glm::dvec3{mesh.positions_local[v[0]]}, glm::dvec3{mesh.positions_local[v[1]]},
                                 glm::dvec3{mesh.positions_local[v[2]]}};
        const bool votes_at_all = facing_of(p[0], p[1], p[2], light) != 0;
        for (unsigned k = 0; k < 3; ++k) {
            const std::uint32_t a = std::min(v[k], v[(k + 1) % 3]), b = std::max(v[k], v[(k + 1) % 3]);
            Votes& edge = votes[{a, b}];
            if (votes_at_all) {
                const bool left = left_of(glm::dvec3{mesh.positions_local[a]}, glm::dvec3{mesh.positions_local[b]},
                                          p[(k + 2) % 3], light) != mirrored;
                ++(left ? edge.left : edge.right);
            }
        }
    }
    std::multiset<std::pair<std::uint32_t, std::uint32_t>> found;
    for (const auto& [ends, vote] : votes) {
        if (vote.right == 0) {
            found.insert(ends);
        }
        if (vote.left == 0) {
            found.emplace(ends.second, ends.first);
        }
    }
    return found;
}

/// scenes::sphere() with both poles closed: sin(pi) is not 0 there.
std::shared_ptr<Mesh> sphere(int rings) {
    auto mesh = scenes::sphere(rings, false);
    for (glm::vec3& p : mesh->positions_local) {
        if (std::abs(p.z) == 1.0F) {
            p = {0.0F, 0.0F, p.z};
        }
    }
    return mesh;
}

std::shared_ptr<Mesh> crumpled_sphere(int rings, unsigned seed) {
    auto mesh = sphere(rings);
    std::mt19937 random{seed};
    std::uniform_real_distribution<float> factor{0.5F, 1.5F};
    std::map<std::array<float, 3>, float> factors;
    for (glm::vec3& p : mesh->positions_local) {
        p *= factors.emplace(std::array{p.x, p.y, p.z}, factor(random)).first->second;
    }
    return mesh;
}

Mesh soup(std::mt19937& random, int triangles) {
    Mesh mesh;
    std::uniform_int_distribution<int> cell{-2, 2};
    for (int i = 0; i < triangles; ++i) {
        mesh.positions_local.emplace_back(cell(random), cell(random), cell(random));
    }
    std::uniform_int_distribution<std::uint32_t> vertex{0, static_cast<std::uint32_t>(triangles) - 1};
    for (int t = 0; t < triangles; ++t) {
        mesh.triangles.emplace_back(vertex(random), vertex(random), vertex(random));
    }
    return mesh;
}

glm::dvec4 random_light(std::mt19937& random) {
    std::uniform_real_distribution<double> at{-4.0, 4.0};
    std::uniform_int_distribution<int> cell{-4, 4}, kind{0, 3};
    switch (kind(random)) {
        case 0:
            return {at(random), at(random), at(random), 1.0};
        case 1:
            return {glm::normalize(glm::dvec3{at(random), at(random), at(random)}), 0.0};
        case 2:
            return {cell(random), cell(random), cell(random), 1.0};  // in the planes of many faces of a soup
        default:
            return {at(random) * 1e5, at(random) * 1e5, at(random) * 1e5, 1.0};
    }
}

TEST(Silhouettes, ACubeFromAGenericPointHasOneLoopOfSix) {
    const Edges edges = find(*scenes::box(glm::vec3{-1}, glm::vec3{1}), {4, 5, 6, 1});
    EXPECT_EQ(edges.size(), 6U);
    expect_closed_loops(edges);
    EXPECT_EQ(loops(edges), 1);
}

TEST(Silhouettes, ACubeFromInFrontOfOneFaceHasItsFourEdges) {
    const Edges edges = find(*scenes::box(glm::vec3{-1}, glm::vec3{1}), {0.1, 0.2, 6, 1});
    EXPECT_EQ(edges.size(), 4U);
    expect_closed_loops(edges);
}

TEST(Silhouettes, FromWithinAClosedMeshThereAreNone) {
    EXPECT_TRUE(find(*scenes::box(glm::vec3{-1}, glm::vec3{1}), {0.1, 0.2, 0.3, 1}).empty());
    EXPECT_TRUE(find(*sphere(20), {0.1, 0.2, 0.3, 1}).empty());
}

TEST(Silhouettes, ASphereHasOneClosedLoop) {
    for (const glm::dvec4& light : {glm::dvec4{3, 1.2345, 2, 1}, glm::dvec4{0.3, 0.7, -0.9, 0}}) {
        const Edges edges = find(*sphere(30), light);
        EXPECT_GT(edges.size(), 30U);
        expect_closed_loops(edges);
        EXPECT_EQ(loops(edges), 1);
    }
}

TEST(Silhouettes, OnAnyClosedManifoldEveryEdgeIsPairedOnce) {
    std::mt19937 random{5};
    for (unsigned seed = 0; seed < 20; ++seed) {
        const auto mesh = crumpled_sphere(10, seed);
        for (int run = 0; run < 10; ++run) {
            const glm::dvec4 light = random_light(random);
            const Edges edges = find(*mesh, light, seed % 2 == 1);
            expect_closed_loops(edges);
            std::map<std::uint32_t, int> count;
            for (const SilhouetteEdge& edge : edges) {
                ++count[edge.a];
                ++count[edge.b];
            }
            for (const auto& [vertex, n] : count) {
                EXPECT_EQ(n % 2, 0) << "vertex " << vertex;
            }
        }
    }
}

TEST(Silhouettes, WhatBlocksLiesOnTheLeft) {
    // One triangle from either side, wound either way, under a transform that mirrors or not.
    const glm::dmat4 mirror{{-1, 0, 0, 0}, {0, 2, 0, 0}, {0.3, 0, 1, 0}, {5, 6, 7, 1}};
    const glm::dmat4 straight{{0, 1, 0, 0}, {-1, 0, 0, 0}, {0, 0.5, 2, 0}, {1, 2, 3, 1}};
    for (const glm::dmat4& world_from_local : {glm::dmat4{1.0}, straight, mirror}) {
        for (const glm::uvec3& winding : {glm::uvec3{0, 1, 2}, glm::uvec3{0, 2, 1}}) {
            for (const double height : {3.0, -3.0}) {
                for (const double w : {1.0, 0.0}) {
                    const auto mesh = scenes::mesh("t", {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}, {winding});
                    const glm::dvec4 light_local{0.2, 0.4, height, w};
                    const bool mirrored = glm::determinant(glm::dmat3{world_from_local}) < 0.0;
                    const Edges edges = find(*mesh, light_local, mirrored);
                    ASSERT_EQ(edges.size(), 3U);
                    expect_closed_loops(edges);
                    const auto world = [&](std::uint32_t v) {
                        return glm::dvec3{world_from_local * glm::dvec4{glm::dvec3{mesh->positions_local[v]}, 1.0}};
                    };
                    for (const SilhouetteEdge& edge : edges) {
                        EXPECT_EQ(edge.a + edge.b + edge.z, 3U);  // 0, 1 and 2
                        EXPECT_TRUE(
                            left_of(world(edge.a), world(edge.b), world(edge.z), world_from_local * light_local));
                    }
                }
            }
        }
    }
}

TEST(Silhouettes, OfASheetWoundInconsistentlyAreItsBorder) {
    const auto mesh = scenes::mesh("quad", {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}}, {{0, 1, 2}, {0, 3, 2}});
    for (const double height : {2.0, -2.0}) {
        const Edges edges = find(*mesh, {0.3, 0.4, height, 1});
        EXPECT_EQ(edges.size(), 4U);
        expect_closed_loops(edges);
        EXPECT_EQ(loops(edges), 1);
        for (const SilhouetteEdge& edge : edges) {
            const auto p = [&](std::uint32_t v) { return glm::dvec3{mesh->positions_local[v]}; };
            EXPECT_TRUE(left_of(p(edge.a), p(edge.b), {0.5, 0.5, 0.0}, {0.3, 0.4, height, 1}));
        }
    }
}

TEST(Silhouettes, OfAnOpenSheetAreItsBorderFromEitherSide) {
    for (const double height : {2.0, -2.0}) {
        const Edges edges = find(*scenes::sheet(0, 1, 0, 1), {0.3, 0.4, height, 1});
        EXPECT_EQ(edges.size(), 4U);
        expect_closed_loops(edges);
    }
}

TEST(Silhouettes, AFoldInAnOpenSheetIsOneAndItsBordersAreTheRest) {
    // A roof: from the side one slope faces the light and the other is averted behind it.
    const auto mesh = scenes::mesh("roof", {{0, 0, 0}, {0, 1, 0}, {1, 0, 1}, {1, 1, 1}, {2, 0, 0}, {2, 1, 0}},
                                   {{0, 2, 1}, {1, 2, 3}, {2, 4, 3}, {3, 4, 5}});
    const Edges edges = find(*mesh, {-5, 0.4, 0.5, 1});
    EXPECT_EQ(edges.size(), 7U);  // the ridge, three borders of each slope
    EXPECT_EQ(directions(edges).count({3, 2}) + directions(edges).count({2, 3}), 1U);
    for (const SilhouetteEdge& edge : edges) {
        EXPECT_NE(edge.z, edge.a);
    }
}

TEST(Silhouettes, ThreeTrianglesAreOneIfAllLieOnOneSide) {
    const auto book = [](double x) {
        return scenes::mesh("book", {{0, 0, 0}, {0, 1, 0}, {1, 0, 0}, {1, 0, 0.2F}, {x, 0, -0.3F}},
                            {{0, 1, 2}, {1, 0, 3}, {0, 1, 4}});
    };
    const glm::dvec4 light{0, 0.5, 4, 1};
    EXPECT_EQ(directions(find(*book(1.0), light)).count({1, 0}) + directions(find(*book(1.0), light)).count({0, 1}),
              1U);
    EXPECT_EQ(directions(find(*book(-1.0), light)).count({1, 0}) + directions(find(*book(-1.0), light)).count({0, 1}),
              0U);
}

TEST(Silhouettes, WithTheLightInThePlaneOfAFaceThatFaceHasNoVote) {
    // z = 1 is the top's plane: the light-facing side wall and the averted rest keep their outlines, the top's edges
    // belong to both, and its diagonal, on which nobody votes, comes both ways round.
    const auto mesh = scenes::box(glm::vec3{-1}, glm::vec3{1});
    const Edges edges = find(*mesh, {4, 0.3, 1, 1});
    const auto set = directions(edges);
    EXPECT_EQ(set, naive(*mesh, {4, 0.3, 1, 1}, false));
    int doubled = 0;
    for (const auto& [a, b] : set) {
        doubled += set.contains({b, a}) ? 1 : 0;
    }
    EXPECT_EQ(doubled, 2);
}

TEST(Silhouettes, EdgeOnEndsAtOneMillionth) {
    // Seen from distance d along x the sine of the angle between plane and ray is height / d.
    const glm::dvec3 a{0, 0, 0}, b{0, 1, 0}, c{-1, 0, 0};
    for (const double scale : {1e-12, 1.0, 1e12}) {
        const auto facing = [&](double height, double w) {
            return facing_of(scale * a, scale * b, scale * c, {scale * 7.0, 0.0, scale * 7.0 * height, w});
        };
        for (const double w : {0.0, 1.0}) {
            EXPECT_EQ(facing(1.001e-6, w), 1);
            EXPECT_EQ(facing(0.999e-6, w), 0);
            EXPECT_EQ(facing(0.0, w), 0);
            EXPECT_EQ(facing(-0.999e-6, w), 0);
            EXPECT_EQ(facing(-1.001e-6, w), -1);
        }
    }
    EXPECT_EQ(facing_of(a, b, c, {0, 0, 0, 1}), 0) << "a light in the corner";
    EXPECT_EQ(facing_of(a, a, c, {0, 0, 1, 1}), 0) << "a triangle without area";
}

TEST(Silhouettes, OfSoupsAreThoseOfTheDefinition) {
    std::mt19937 random{11};
    for (int run = 0; run < 200; ++run) {
        const Mesh mesh = soup(random, 40);
        const glm::dvec4 light = random_light(random);
        const bool mirrored = run % 2 == 1;
        EXPECT_EQ(directions(find(mesh, light, mirrored)), naive(mesh, light, mirrored)) << "run " << run;
    }
}

TEST(Silhouettes, WhatIsPairedInASoupIsASilhouetteThatArrives) {
    std::mt19937 random{12};
    for (int run = 0; run < 100; ++run) {
        const Edges edges = find(soup(random, 40), random_light(random));
        const auto set = directions(edges);
        for (const SilhouetteEdge& edge : edges) {
            EXPECT_TRUE(edge.z == edge.a || set.contains({edge.z, edge.a})) << "run " << run;
        }
    }
}

TEST(Silhouettes, DoNotDependOnTheOrderOfTriangles) {
    std::mt19937 random{13};
    auto mesh = *crumpled_sphere(12, 1);
    const glm::dvec4 light{3, 1, 2, 1};
    const Edges before = find(mesh, light);
    std::shuffle(mesh.triangles.begin(), mesh.triangles.end(), random);
    for (glm::uvec3& t : mesh.triangles) {
        t = glm::uvec3{t.y, t.z, t.x};
    }
    EXPECT_THAT(find(mesh, light), testing::UnorderedElementsAreArray(before));
}

TEST(Silhouettes, AFanOfTooManyTrianglesIsNotPaired) {
    // A pyramid whose four walls are cut into many slices that meet at the tip; two walls face the light.
    for (const int slices : {2000, 2100}) {
        Mesh mesh;
        mesh.positions_local = {{0, 0, 1}, {0, 0, 0}};
        const glm::vec2 corners[4] = {{-1, -1}, {1, -1}, {1, 1}, {-1, 1}};
        for (int i = 0; i < 4 * slices; ++i) {
            const float t = static_cast<float>(i % slices) / static_cast<float>(slices);
            mesh.positions_local.emplace_back(glm::mix(corners[i / slices], corners[(i / slices + 1) % 4], t), 0.0F);
            const auto at = [&](int k) { return static_cast<std::uint32_t>(2 + k % (4 * slices)); };
            mesh.triangles.emplace_back(0U, at(i), at(i + 1));
            mesh.triangles.emplace_back(1U, at(i + 1), at(i));
        }
        const Edges edges = find(mesh, {-5, -4, 0.1, 1});
        ASSERT_EQ(edges.size(), 2U * slices + 2U);
        for (const SilhouetteEdge& edge : edges) {
            EXPECT_EQ(edge.z == edge.a, edge.a == 0 && 2 * slices > kMostFanSteps) << slices << " slices";
        }
    }
}

TEST(Silhouettes, LightFacingGivesThreeEdgesForEachLightFacingTriangle) {
    const auto mesh = scenes::box(glm::vec3{-1}, glm::vec3{1});
    for (const bool mirrored : {false, true}) {
        const Edges edges = find(*mesh, {4, 5, 6, 1}, mirrored, EdgeChoice::LightFacing);
        ASSERT_EQ(edges.size(), 18U);
        for (const SilhouetteEdge& edge : edges) {
            const auto p = [&](std::uint32_t v) {
                return glm::dvec3{mirrored ? -1 : 1, 1, 1} * glm::dvec3{mesh->positions_local[v]};
            };
            EXPECT_TRUE(left_of(p(edge.a), p(edge.b), p(edge.z), {mirrored ? -4 : 4, 5, 6, 1}));
        }
    }
}

TEST(Silhouettes, AllGivesEveryEdgeBothWaysRound) {
    const auto mesh = scenes::box(glm::vec3{-1}, glm::vec3{1});
    const Edges edges = find(*mesh, {4, 5, 6, 1}, false, EdgeChoice::All);
    EXPECT_EQ(edges.size(), 36U);
    const auto set = directions(edges);
    for (const SilhouetteEdge& edge : edges) {
        EXPECT_EQ(set.count({edge.b, edge.a}), 1U);
        EXPECT_EQ(edge.z, edge.a);
    }
}

void expect_flat_is_oracle(const Mesh& mesh, const std::vector<glm::dvec4>& lights) {
    const Adjacency adjacency = make_adjacency(mesh);
    FlatSilhouettes flat{mesh, adjacency};
    for (const glm::dvec4& light : lights) {
        for (const EdgeChoice choice : {EdgeChoice::Silhouettes, EdgeChoice::LightFacing, EdgeChoice::All}) {
            for (const bool mirrored : {false, true}) {
                Edges found;
                flat.find(light, mirrored, choice, found);
                ASSERT_EQ(found, find_silhouettes(mesh, adjacency, light, mirrored, choice))
                    << mesh.name << ", light " << light.x << ", " << light.y << ", " << light.z << ", " << light.w;
            }
        }
    }
}

TEST(FlatSilhouettes, AreTheOraclesForAnyLight) {
    std::mt19937 random{17};
    for (int run = 0; run < 100; ++run) {
        expect_flat_is_oracle(soup(random, 60), {random_light(random), random_light(random), random_light(random)});
    }
    expect_flat_is_oracle(*crumpled_sphere(15, 3), {random_light(random), random_light(random)});
}

TEST(FlatSilhouettes, AreTheOraclesWithTheLightInAFacesPlane) {
    // Lights in the planes of the first faces of a mesh at odd places, and a few millionths beside.
    auto mesh = *crumpled_sphere(15, 4);
    for (glm::vec3& p : mesh.positions_local) {
        p = p * 0.01F + glm::vec3{20.0F, -30.0F, 7.0F};
    }
    std::vector<glm::dvec4> lights;
    for (std::size_t t = 0; t < 60; ++t) {
        const glm::uvec3& v = mesh.triangles[7 * t];
        const glm::dvec3 a{mesh.positions_local[v.x]}, b{mesh.positions_local[v.y]}, c{mesh.positions_local[v.z]};
        if (glm::length(glm::cross(b - a, c - a)) > 0.0) {
            const glm::dvec3 in_plane = a + 40.0 * (b - a) - 13.0 * (c - a);
            const glm::dvec3 n = glm::normalize(glm::cross(b - a, c - a));
            for (const double beside : {-2e-6, -1e-6, 0.0, 1e-6, 2e-6}) {
                lights.emplace_back(in_plane + beside * glm::length(in_plane - a) * n, 1.0);
            }
        }
    }
    expect_flat_is_oracle(mesh, lights);
}

TEST(FlatSilhouettes, AreTheOraclesAtAnyScale) {
    for (const float scale : {1e-18F, 1e-6F, 1e6F, 1e18F}) {
        auto mesh = *crumpled_sphere(10, 5);
        for (glm::vec3& p : mesh.positions_local) {
            p *= scale;
        }
        const double s = scale;
        expect_flat_is_oracle(mesh,
                              {{3 * s, 2 * s, s, 1}, {1e30, 2e30, 3e30, 1}, {0.1 * s, 0, 0, 1}, {0.6, 0, 0.8, 0}});
    }
}

TEST(FlatSilhouettes, OfRealModelsAreTheOracles) {
    std::mt19937 random{19};
    for (const char* file : {"stanford-bunny.obj", "spot.obj", "fandisk.obj", "teapot.obj"}) {
        const auto mesh = read_model(file);
        if (!mesh) {
            GTEST_SKIP() << file << " is not here (PENUMBRA_MODELS names its folder)";
        }
        expect_flat_is_oracle(*mesh, {random_light(random), random_light(random), random_light(random)});
    }
}

}  // namespace
}  // namespace penumbra
