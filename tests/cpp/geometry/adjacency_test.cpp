#include "geometry/adjacency.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <random>
#include <set>

#include "support/obj.h"
#include "support/scenes.h"

namespace penumbra {
namespace {

using testing::ElementsAre;

/// The sides of an edge, wherever they are kept.
std::vector<std::uint32_t> sides_of(const Adjacency& adjacency, const Adjacency::Edge& edge) {
    if (edge.side1 == Adjacency::kNone) {
        return {edge.side0};
    }
    if ((edge.side1 & Adjacency::kMany) == 0) {
        return {edge.side0, edge.side1};
    }
    const auto first = adjacency.more_sides.begin() + edge.side0;
    return {first, first + (edge.side1 & ~Adjacency::kMany)};
}

/// All that the header promises of any adjacency.
void expect_consistent(const Mesh& mesh, const Adjacency& adjacency) {
    ASSERT_EQ(adjacency.welded.size(), mesh.positions_local.size());
    ASSERT_EQ(adjacency.triangle_edges.size(), mesh.triangles.size());
    EXPECT_TRUE(std::is_sorted(adjacency.edges.begin(), adjacency.edges.end(), [](const auto& a, const auto& b) {
        return std::pair{a.v0, a.v1} < std::pair{b.v0, b.v1};
    }));
    std::multiset<std::uint32_t> seen;
    std::uint64_t border = 0, many = 0;
    for (std::size_t e = 0; e < adjacency.edges.size(); ++e) {
        const Adjacency::Edge& edge = adjacency.edges[e];
        EXPECT_LT(edge.v0, edge.v1);
        const auto sides = sides_of(adjacency, edge);
        border += sides.size() == 1 ? 1 : 0;
        many += sides.size() > 2 ? 1 : 0;
        for (const std::uint32_t side : sides) {
            const glm::uvec3& corners = mesh.triangles[side / 2];
            const std::uint32_t from = (side & 1U) != 0 ? edge.v1 : edge.v0;
            const std::uint32_t to = (side & 1U) != 0 ? edge.v0 : edge.v1;
            bool runs = false;
            for (int k = 0; k < 3; ++k) {
                if (adjacency.triangle_edges[side / 2][k] == e) {
                    runs = adjacency.welded[corners[k]] == from && adjacency.welded[corners[(k + 1) % 3]] == to;
                }
            }
            EXPECT_TRUE(runs) << "edge " << e << ", triangle " << side / 2;
            seen.insert(side / 2);
        }
    }
    EXPECT_EQ(border, adjacency.border_edges);
    EXPECT_EQ(many, adjacency.many_edges);
    for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t) {
        const glm::uvec3& v = mesh.triangles[t];
        const std::set<std::uint32_t> places{adjacency.welded[v.x], adjacency.welded[v.y], adjacency.welded[v.z]};
        EXPECT_EQ(seen.count(t), places.size() == 3 ? 3U : 0U) << "triangle " << t;
    }
}

std::size_t used_places(const Mesh& mesh, const Adjacency& adjacency) {
    std::set<std::uint32_t> places;
    for (const glm::uvec3& v : mesh.triangles) {
        places.insert({adjacency.welded[v.x], adjacency.welded[v.y], adjacency.welded[v.z]});
    }
    return places.size();
}

long euler_characteristic(const Mesh& mesh, const Adjacency& adjacency) {
    return static_cast<long>(used_places(mesh, adjacency)) - static_cast<long>(adjacency.edges.size()) +
           static_cast<long>(mesh.triangles.size());
}

TEST(Adjacency, ATetrahedronHasSixEdgesAndIsClosed) {
    const auto mesh =
        scenes::mesh("t", {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}}, {{0, 2, 1}, {0, 1, 3}, {1, 2, 3}, {0, 3, 2}});
    const Adjacency adjacency = make_adjacency(*mesh);
    EXPECT_EQ(adjacency.edges.size(), 6U);
    EXPECT_TRUE(adjacency.closed_manifold());
    expect_consistent(*mesh, adjacency);
}

TEST(Adjacency, ACubeOfTwentyFourVerticesIsWeldedToEighteenEdges) {
    const auto eight = scenes::box(glm::vec3{-1}, glm::vec3{1});
    auto mesh = std::make_shared<Mesh>();
    for (const glm::uvec3& v : eight->triangles) {
        const auto first = static_cast<std::uint32_t>(mesh->positions_local.size());
        for (int k = 0; k < 3; ++k) {
            mesh->positions_local.push_back(eight->positions_local[v[k]]);
        }
        mesh->triangles.emplace_back(first, first + 1, first + 2);
    }
    const Adjacency adjacency = make_adjacency(*mesh);
    EXPECT_EQ(adjacency.edges.size(), 18U);
    EXPECT_EQ(used_places(*mesh, adjacency), 8U);
    EXPECT_TRUE(adjacency.closed_manifold());
    expect_consistent(*mesh, adjacency);
}

TEST(Adjacency, AnOpenQuadHasFourBorderEdges) {
    const auto mesh = scenes::sheet(0, 1, 0, 1);
    const Adjacency adjacency = make_adjacency(*mesh);
    EXPECT_EQ(adjacency.edges.size(), 5U);
    EXPECT_EQ(adjacency.border_edges, 4U);
    EXPECT_FALSE(adjacency.closed_manifold());
    expect_consistent(*mesh, adjacency);
}

TEST(Adjacency, ThreeTrianglesOnOneEdgeAreAllKept) {
    const auto mesh = scenes::mesh("book", {{0, 0, 0}, {0, 0, 1}, {1, 0, 0}, {0, 1, 0}, {-1, -1, 0}},
                                   {{0, 1, 2}, {1, 0, 3}, {0, 1, 4}});
    const Adjacency adjacency = make_adjacency(*mesh);
    EXPECT_EQ(adjacency.edges.size(), 7U);
    EXPECT_EQ(adjacency.many_edges, 1U);
    EXPECT_EQ(adjacency.border_edges, 6U);
    EXPECT_THAT(sides_of(adjacency, adjacency.edges[0]), ElementsAre(0U, 3U, 4U));
    expect_consistent(*mesh, adjacency);
}

TEST(Adjacency, ATriangleThereTwiceHasNoBorder) {
    const auto mesh = scenes::mesh("twice", {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}, {{0, 1, 2}, {0, 1, 2}});
    const Adjacency adjacency = make_adjacency(*mesh);
    EXPECT_EQ(adjacency.edges.size(), 3U);
    EXPECT_TRUE(adjacency.closed_manifold());
    EXPECT_THAT(sides_of(adjacency, adjacency.edges[0]), ElementsAre(0U, 2U));
    expect_consistent(*mesh, adjacency);
}

TEST(Adjacency, ATriangleWithTwoCornersAtOnePlaceHasNoEdges) {
    // Corners 1 and 3 differ as numbers only.
    const auto mesh =
        scenes::mesh("needle", {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {1, 0, 0}}, {{0, 1, 3}, {0, 1, 2}, {2, 2, 0}});
    const Adjacency adjacency = make_adjacency(*mesh);
    EXPECT_EQ(adjacency.edges.size(), 3U);
    EXPECT_EQ(adjacency.triangle_edges[0], glm::uvec3{Adjacency::kNone});
    EXPECT_EQ(adjacency.triangle_edges[2], glm::uvec3{Adjacency::kNone});
    expect_consistent(*mesh, adjacency);
}

TEST(Adjacency, ATJunctionStaysOpen) {
    // A long edge 0-1 on one side, its halves 0-4 and 4-1 on the other.
    const auto mesh =
        scenes::mesh("t", {{0, 0, 0}, {2, 0, 0}, {1, 1, 0}, {1, -1, 0}, {1, 0, 0}}, {{0, 1, 2}, {0, 3, 4}, {4, 3, 1}});
    const Adjacency adjacency = make_adjacency(*mesh);
    EXPECT_EQ(adjacency.edges.size(), 8U);
    EXPECT_EQ(adjacency.border_edges, 7U);
    expect_consistent(*mesh, adjacency);
}

TEST(Adjacency, MinusZeroIsTheSamePlaceAsZero) {
    const auto mesh =
        scenes::mesh("z", {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {-0.0F, -0.0F, -0.0F}, {-1, 0, 0}}, {{0, 1, 2}, {3, 2, 4}});
    const Adjacency adjacency = make_adjacency(*mesh);
    EXPECT_EQ(adjacency.welded[3], 0U);
    EXPECT_EQ(adjacency.edges.size(), 5U);
    expect_consistent(*mesh, adjacency);
}

TEST(Adjacency, AnEmptyMeshHasNone) {
    const Adjacency adjacency = make_adjacency(Mesh{});
    EXPECT_TRUE(adjacency.edges.empty());
    EXPECT_TRUE(adjacency.closed_manifold());
}

TEST(Adjacency, EverySideOfARandomSoupIsKeptOnce) {
    std::mt19937 random{3};
    for (int run = 0; run < 50; ++run) {
        Mesh mesh;
        std::uniform_int_distribution<int> cell{0, 2};
        for (int i = 0; i < 30; ++i) {
            mesh.positions_local.emplace_back(cell(random), cell(random), cell(random));
        }
        std::uniform_int_distribution<std::uint32_t> vertex{0, 29};
        for (int t = 0; t < 60; ++t) {
            mesh.triangles.emplace_back(vertex(random), vertex(random), vertex(random));
        }
        expect_consistent(mesh, make_adjacency(mesh));
    }
}

struct Model {
    const char* file;
    std::size_t triangles;
    long euler;
    std::uint64_t border_edges, many_edges;
};
class AdjacencyOfModels : public testing::TestWithParam<Model> {};

TEST_P(AdjacencyOfModels, HasTheKnownCounts) {
    const auto mesh = read_model(GetParam().file);
    if (!mesh) {
        GTEST_SKIP() << GetParam().file << " is not here (PENUMBRA_MODELS names its folder)";
    }
    const Adjacency adjacency = make_adjacency(*mesh);
    EXPECT_EQ(mesh->triangles.size(), GetParam().triangles);
    EXPECT_EQ(euler_characteristic(*mesh, adjacency), GetParam().euler);
    EXPECT_EQ(adjacency.border_edges, GetParam().border_edges);
    EXPECT_EQ(adjacency.many_edges, GetParam().many_edges);
    expect_consistent(*mesh, adjacency);
}

// Spot and fandisk are spheres; the bunny is a sphere with five holes; the teapot's shells touch and stay open.
INSTANTIATE_TEST_SUITE_P(Known, AdjacencyOfModels,
                         testing::Values(Model{"stanford-bunny.obj", 69451, -3, 223, 0},
                                         Model{"spot.obj", 5856, 2, 0, 0}, Model{"fandisk.obj", 12946, 2, 0, 0},
                                         Model{"teapot.obj", 6320, 1, 160, 0}),
                         [](const auto& model) {
                             std::string name = model.param.file;
                             std::erase_if(name, [](char c) { return std::isalnum(c) == 0; });
                             return name;
                         });

}  // namespace
}  // namespace penumbra
