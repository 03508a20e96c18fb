#include "geometry/shadow_volume.h"

#include <gtest/gtest.h>

#include <cstdlib>
#include <random>

#include "geometry/layer_bound.h"
#include "geometry/silhouettes.h"
#include "geometry/volume_tiles.h"
#include "support/scenes.h"

namespace penumbra {
namespace {

std::shared_ptr<Mesh> turned(const std::shared_ptr<Mesh>& mesh) {
    auto made = std::make_shared<Mesh>(*mesh);
    for (glm::uvec3& t : made->triangles) {
        std::swap(t.y, t.z);
    }
    return made;
}

std::shared_ptr<Mesh> soup(std::mt19937& random, unsigned triangles) {
    std::uniform_real_distribution<float> at{-1.0F, 1.0F};
    auto mesh = std::make_shared<Mesh>();
    mesh->name = "soup";
    for (unsigned i = 0; i < triangles; ++i) {
        mesh->positions_local.emplace_back(at(random), at(random), at(random));
    }
    std::uniform_int_distribution<unsigned> vertex{0, triangles - 1};
    for (unsigned i = 0; i < triangles; ++i) {
        mesh->triangles.emplace_back(vertex(random), vertex(random), vertex(random));
    }
    return mesh;
}

/// Signed crossings of an index list's triangles by the ray from p along `along`, oriented: leaving the volume +1.
int signed_crossings(const Mesh& mesh, const VolumeIndices& volume, const glm::dvec3& light, const glm::dvec3& p,
                     const glm::dvec3& along) {
    const auto corner = [&](std::uint32_t i) {
        const glm::dvec3 at{mesh.positions_local[i / 2]};
        return (i & 1U) == 0 ? at : light + 1e5 * (at - light);  // far enough for points within a few units
    };
    int sum = 0;
    const auto add = [&](const std::vector<std::uint32_t>& list, int sign) {
        for (std::size_t i = 0; i < list.size(); i += 3) {
            const glm::dvec3 a = corner(list[i]) - p, b = corner(list[i + 1]) - p, c = corner(list[i + 2]) - p;
            const double s0 = glm::dot(glm::cross(a, b), along), s1 = glm::dot(glm::cross(b, c), along),
                         s2 = glm::dot(glm::cross(c, a), along);
            const bool front = s0 > 0 && s1 > 0 && s2 > 0, back = s0 < 0 && s1 < 0 && s2 < 0;
            if ((front || back) && glm::dot(glm::cross(b - a, c - a), a) * (front ? 1.0 : -1.0) > 0.0) {
                sum += front ? sign : -sign;
            }
        }
    };
    add(volume.wound, 1);
    add(volume.flipped, -1);
    return sum;
}

TEST(ShadowVolume, ABoxIsOneShellWithNormalsOut) {
    const auto box = scenes::box(glm::vec3{-1}, glm::vec3{1});
    const Closure out = closure_of(*box, make_adjacency(*box));
    EXPECT_TRUE(out.closed);
    EXPECT_EQ(out.outwards, 1);
    EXPECT_EQ(out.shells, 1U);
    const auto in = turned(box);
    EXPECT_EQ(closure_of(*in, make_adjacency(*in)).outwards, -1);
    auto open = std::make_shared<Mesh>(*box);
    open->triangles.pop_back();
    EXPECT_FALSE(closure_of(*open, make_adjacency(*open)).closed);
}

TEST(ShadowVolume, WindingNumbersAreIntegers) {
    const auto ball = scenes::sphere(12, false);
    EXPECT_NEAR(winding_number(*ball, {0.1, 0.2, 0.3}), 1.0, 1e-12);
    EXPECT_NEAR(winding_number(*ball, {1.1, 0.2, 0.3}), 0.0, 1e-12);
    EXPECT_NEAR(winding_number(*turned(ball), {0.1, 0.2, 0.3}), -1.0, 1e-12);
}

TEST(ShadowVolume, TheFewestTrianglesThatTellTheTruthAreChosen) {
    const auto box = scenes::box(glm::vec3{-1}, glm::vec3{1});
    const auto faces = [](const Mesh& mesh, const glm::dvec4& light) {
        return volume_faces(closure_of(mesh, make_adjacency(mesh)), mesh, bounds_of(mesh), light);
    };
    EXPECT_EQ(faces(*box, {3, 1, 1, 1}), VolumeFaces::Towards);
    EXPECT_EQ(faces(*box, {0, 0.1, 0.2, 1}), VolumeFaces::Averted);
    EXPECT_EQ(faces(*box, {0, 0, 1, 0}), VolumeFaces::Towards);
    EXPECT_EQ(faces(*turned(box), {3, 1, 1, 1}), VolumeFaces::Averted);
    EXPECT_EQ(faces(*turned(box), {0, 0.1, 0.2, 1}), VolumeFaces::Towards);
    EXPECT_EQ(faces(*scenes::sheet(-1, 1, -1, 1), {3, 1, 1, 1}), VolumeFaces::All);
    EXPECT_EQ(faces(*box, {1, 0, 0, 1}), VolumeFaces::All) << "a light on the surface";
}

TEST(ShadowVolume, MultiplicityIsOneOnSilhouettesOfSolidsAndTwoWithAllTriangles) {
    const auto box = scenes::box(glm::vec3{-1}, glm::vec3{1});
    const Adjacency adjacency = make_adjacency(*box);
    std::vector<std::uint8_t> towards(box->triangles.size());
    for (std::size_t t = 0; t < towards.size(); ++t) {
        const glm::uvec3& v = box->triangles[t];
        towards[t] = facing_of(glm::dvec3{box->positions_local[v.x]}, glm::dvec3{box->positions_local[v.y]},
                               glm::dvec3{box->positions_local[v.z]}, {5, 4, 3, 1}) > 0
                         ? 1
                         : 0;
    }
    int towards_sum = 0, averted_sum = 0, all_sum = 0;
    for (const Adjacency::Edge& edge : adjacency.edges) {
        const int m = edge_multiplicity(adjacency, edge, towards.data(), VolumeFaces::Towards);
        const int n = edge_multiplicity(adjacency, edge, towards.data(), VolumeFaces::Averted);
        EXPECT_EQ(m, n) << "either half has the same outline";
        EXPECT_EQ(edge_multiplicity(adjacency, edge, towards.data(), VolumeFaces::All), m + n);
        towards_sum += std::abs(m);
        averted_sum += std::abs(n);
        all_sum += std::abs(m + n);
    }
    EXPECT_EQ(towards_sum, 6);
    EXPECT_EQ(averted_sum, 6);
    EXPECT_EQ(all_sum, 12);
}

TEST(ShadowVolume, LeavingTheVolumeAsOftenAsTheSegmentCrossesTriangles) {
    std::mt19937 random{3};
    std::uniform_real_distribution<double> at{-2.0, 2.0};
    for (int run = 0; run < 12; ++run) {
        const auto mesh = run < 6   ? soup(random, 20)
                          : run < 9 ? scenes::sphere(5, false)
                                    : scenes::box(glm::vec3{-1}, glm::vec3{1});
        const Adjacency adjacency = make_adjacency(*mesh);
        VolumeMaker maker{*mesh, adjacency};
        const glm::dvec3 light{at(random), at(random), 2.0 + at(random)};
        for (const VolumeFaces faces : {VolumeFaces::Towards, VolumeFaces::Averted, VolumeFaces::All}) {
            VolumeIndices volume;
            maker.append({light, 1.0}, faces, {}, 0, volume);
            std::uint64_t sides = 0;
            sides = (volume.wound.size() + volume.flipped.size()) / 3;
            EXPECT_LE(sides, 2 * mesh->triangles.size() + 2 * most_sides(adjacency, faces));
            for (int i = 0; i < 60; ++i) {
                const glm::dvec3 p{at(random), at(random), at(random)};
                const glm::dvec3 along{at(random), at(random), at(random)};
                ASSERT_EQ(signed_crossings(*mesh, volume, light, p, along),
                          count_crossings(*mesh, {light, 1.0}, p, faces))
                    << run << ", " << static_cast<int>(faces) << ", " << i;
            }
        }
    }
}

TEST(ShadowVolume, ChosenTrianglesBlockWhereAnyTriangleDoes) {
    std::mt19937 random{4};
    std::uniform_real_distribution<double> at{-2.0, 2.0};
    for (const auto& mesh : {scenes::sphere(6, false), turned(scenes::sphere(6, false)), soup(random, 12)}) {
        const Closure closure = closure_of(*mesh, make_adjacency(*mesh));
        for (int i = 0; i < 300; ++i) {
            const glm::dvec4 light{at(random), at(random), at(random), 1.0};
            const glm::dvec3 p{at(random), at(random), at(random)};
            const VolumeFaces faces = volume_faces(closure, *mesh, bounds_of(*mesh), light);
            EXPECT_EQ(count_crossings(*mesh, light, p, faces) != 0,
                      count_crossings(*mesh, light, p, VolumeFaces::All) != 0);
        }
    }
}

TEST(LayerBound, IsNoLessThanAnyRayCrosses) {
    std::mt19937 random{5};
    std::uniform_real_distribution<double> at{-2.0, 2.0};
    for (int run = 0; run < 8; ++run) {
        const auto mesh = soup(random, 80);
        // A window around a part of it is as safe.
        const std::vector<Bounds> boxes{run < 4 ? bounds_of(*mesh) : Bounds{{-0.3, -0.3, -0.3}, {0.3, 0.2, 0.3}}};
        const glm::dvec4 light = run % 2 == 0
                                     ? glm::dvec4{at(random), at(random), at(random), 1.0}
                                     : glm::dvec4{glm::normalize(glm::dvec3{at(random), at(random), 1.0}), 0.0};
        LayerBound bound{light, boxes};
        for (const glm::uvec3& t : mesh->triangles) {
            bound.add(glm::dvec3{mesh->positions_local[t.x]}, glm::dvec3{mesh->positions_local[t.y]},
                      glm::dvec3{mesh->positions_local[t.z]});
        }
        int most = 0;
        for (int i = 0; i < 400; ++i) {
            const glm::dvec3 p{at(random), at(random), at(random)};
            most = std::max(most, count_crossings(*mesh, light, p, VolumeFaces::All));
        }
        EXPECT_GE(bound.most(), static_cast<std::uint32_t>(most));
        EXPECT_LE(bound.most(), 80U);
    }
}

TEST(ShadowVolume, ConvexShellsAreKnown) {
    const auto shells = [](const Mesh& mesh) { return closure_of(mesh, make_adjacency(mesh)).convex_shell; };
    for (const auto& mesh :
         {scenes::box(glm::vec3{-1}, glm::vec3{1}), turned(scenes::box(glm::vec3{-1}, glm::vec3{1}))}) {
        for (const std::uint32_t shell : shells(*mesh)) {
            EXPECT_EQ(shell, shells(*mesh).front());
            EXPECT_NE(shell, 0U);
        }
    }
    auto dented = std::make_shared<Mesh>(*scenes::box(glm::vec3{-1}, glm::vec3{1}));
    dented->positions_local[7] = {-0.5F, -0.5F, -0.5F};
    for (const std::uint32_t shell : shells(*dented)) {
        EXPECT_EQ(shell, 0U);
    }
    EXPECT_TRUE(shells(*scenes::sheet(-1, 1, -1, 1)).empty());
}

TEST(LayerBound, AConvexShellIsOneLayer) {
    const auto box = scenes::box(glm::vec3{-1}, glm::vec3{1});
    const std::vector<Bounds> boxes{bounds_of(*box)};
    LayerBound bound{{3, 4, 5, 1}, boxes};
    for (std::uint32_t shell = 1; shell <= 3; ++shell) {
        for (const glm::uvec3& t : box->triangles) {
            bound.add(glm::dvec3{box->positions_local[t.x]}, glm::dvec3{box->positions_local[t.y]},
                      glm::dvec3{box->positions_local[t.z]}, shell);
        }
    }
    EXPECT_EQ(bound.most(), 3U);
}

TEST(LayerBound, CountsSheetsOverEachOther) {
    const std::vector<Bounds> boxes{Bounds{{-1, -1, 0}, {1, 1, 1}}};
    for (const glm::dvec4& light : {glm::dvec4{0.3, 0.2, 5, 1}, glm::dvec4{0, 0, 1, 0}, glm::dvec4{0, 0, 0.5, 1}}) {
        LayerBound bound{light, boxes};
        for (int i = 0; i < 10; ++i) {
            const double z = 0.1 * i + 0.05;
            bound.add({-1, -1, z}, {1, -1, z}, {1, 1, z});
        }
        EXPECT_LE(bound.most(), 10U);
        EXPECT_GE(bound.most(), (light.z == 0.5 ? 5U : 10U));
    }
}

TEST(VolumeTiles, RectanglesHoldEveryWantedTileOnce) {
    std::mt19937 random{6};
    TileGrid grid{330, 250};
    for (std::uint8_t& wanted : grid.wanted) {
        wanted = random() % 3 != 0 ? 1 : 0;
    }
    std::vector<std::int32_t> of;
    const auto rectangles = rectangles_of(grid, of);
    std::vector<int> times(grid.wanted.size(), 0);
    for (const TileRectangle& r : rectangles) {
        for (int y = r.row; y < r.row + r.rows; ++y) {
            for (int x = r.column; x < r.column + r.columns; ++x) {
                ++times[static_cast<std::size_t>(y * grid.columns + x)];
            }
        }
    }
    for (std::size_t i = 0; i < times.size(); ++i) {
        EXPECT_EQ(times[i], grid.wanted[i]);
        EXPECT_EQ(of[i] >= 0, grid.wanted[i] != 0);
    }
}

// Every pixel of a triangle, found from barycentric coordinates in float64, lies in a tile of the walk if its depth
// matters there.
TEST(VolumeTiles, NoFragmentThatMattersIsInATileLeftOut) {
    std::mt19937 random{7};
    std::uniform_real_distribution<double> at{-2.0, 2.0};
    std::uniform_real_distribution<double> unit{0.0, 1.0};
    constexpr int kSide = 160;
    for (int run = 0; run < 300; ++run) {
        TileGrid grid{kSide, kSide};
        for (std::size_t i = 0; i < grid.wanted.size(); ++i) {
            grid.wanted[i] = random() % 4 != 0 ? 1 : 0;
            grid.farthest[i] = static_cast<float>(0.5 * unit(random));
            grid.nearest[i] = static_cast<float>(grid.farthest[i] + 0.5 * unit(random));
        }
        TileWalker walker{grid};
        std::array<glm::dvec4, 3> v;
        for (glm::dvec4& p : v) {  // some behind the eye, some at infinity
            p = {at(random), at(random), unit(random), random() % 4 == 0 ? 0.0 : at(random)};
        }
        const bool z_pass = run % 2 == 0;
        std::vector<std::uint32_t> tiles;
        walker.walk(v[0], v[1], v[2], z_pass, tiles);
        std::vector<std::uint8_t> walked(grid.wanted.size(), 0);
        for (const std::uint32_t tile : tiles) {
            ASSERT_EQ(grid.wanted[tile], 1);
            ASSERT_EQ(walked[tile]++, 0) << "once each";
        }
        const glm::dmat3 m{glm::dvec3{v[0].x, v[0].y, v[0].w}, glm::dvec3{v[1].x, v[1].y, v[1].w},
                           glm::dvec3{v[2].x, v[2].y, v[2].w}};
        if (std::abs(glm::determinant(m)) < 1e-6) {
            continue;
        }
        const glm::dmat3 inverse = glm::inverse(m);
        for (int y = 0; y < kSide; ++y) {
            for (int x = 0; x < kSide; ++x) {
                // Shares of the corners, up to a factor: the point at (x, y, 1) on the eye's ray, w > 0.
                const glm::dvec3 share =
                    inverse * glm::dvec3{2.0 * (x + 0.5) / kSide - 1.0, 2.0 * (y + 0.5) / kSide - 1.0, 1.0};
                if (share.x < 0.0 || share.y < 0.0 || share.z < 0.0) {
                    continue;
                }
                const double depth = std::clamp(share.x * v[0].z + share.y * v[1].z + share.z * v[2].z, 0.0, 1.0);
                const std::size_t tile = grid.tile_of(x, y);
                const bool matters =
                    grid.wanted[tile] != 0 && (z_pass ? depth >= grid.farthest[tile] : depth <= grid.nearest[tile]);
                ASSERT_TRUE(!matters || walked[tile] != 0) << run << ": " << x << ", " << y << " depth " << depth;
            }
        }
    }
}

}  // namespace
}  // namespace penumbra
