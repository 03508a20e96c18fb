#include <gtest/gtest.h>

#include <cmath>
#include <memory>
#include <random>
#include <set>

#include "reference/shaft_bvh.h"

namespace penumbra {
namespace {

Scene random_scene(int triangles, unsigned seed) {
    std::mt19937 random{seed};
    std::uniform_real_distribution<float> in{-1.0F, 1.0F};
    auto mesh = std::make_shared<Mesh>();
    for (int i = 0; i < triangles; ++i) {
        const glm::vec3 at = 3.0F * glm::vec3{in(random), in(random), in(random)};
        for (int k = 0; k < 3; ++k) {
            mesh->positions_local.push_back(at + 0.2F * glm::vec3{in(random), in(random), in(random)});
        }
        mesh->triangles.emplace_back(3 * i, 3 * i + 1, 3 * i + 2);
    }
    Scene scene;
    Instance instance;
    instance.mesh = mesh;
    scene.instances.push_back(instance);
    return scene;
}

/// Any sample point of the triangle inside the hull of apex and quad?
bool touches(const CastingTriangle& t, const glm::dvec3& apex, const std::vector<glm::dvec3>& quad) {
    const glm::dvec3 normal = glm::cross(quad[1] - quad[0], quad[3] - quad[0]);
    const double height = glm::dot(normal, quad[0] - apex);
    for (int i = 0; i <= 12; ++i) {
        for (int j = 0; j + i <= 12; ++j) {
            const glm::dvec3 p = t.corner[0] + (i / 12.0) * (t.corner[1] - t.corner[0]) +
                                 (j / 12.0) * (t.corner[2] - t.corner[0]) - apex;
            const double share = glm::dot(normal, p) / height;
            bool inside = share >= 0.0 && share <= 1.0;
            for (std::size_t k = 0; k < 4 && inside; ++k) {
                const glm::dvec3 plane = glm::cross(quad[k] - apex, quad[(k + 1) % 4] - apex);
                inside = glm::dot(plane, p) * glm::dot(plane, quad[(k + 2) % 4] - apex) >= 0.0;
            }
            if (inside) {
                return true;
            }
        }
    }
    return false;
}

TEST(ShaftBvh, FindsEveryTriangleThatTouchesTheShaft) {
    const Scene scene = random_scene(3000, 1);
    const ShaftBvh bvh{scene, glm::dvec3{0.0}};
    ASSERT_EQ(bvh.triangle_count(), 3000U);
    std::mt19937 random{2};
    std::uniform_real_distribution<double> in{-3.0, 3.0};
    std::size_t found_all = 0;
    for (int round = 0; round < 40; ++round) {
        const glm::dvec3 apex{in(random), in(random), in(random)};
        const glm::dvec3 centre{in(random), in(random), in(random)};
        const glm::dvec3 u{0.2 * in(random), 0.2 * in(random), 0.2 * in(random)};
        const glm::dvec3 v{0.2 * in(random), 0.2 * in(random), 0.2 * in(random)};
        const std::vector<glm::dvec3> quad{centre - u - v, centre + u - v, centre + u + v, centre - u + v};
        std::set<double> found;  // by the first coordinate, which is unique
        bvh.visit_shaft(apex, quad, [&](const CastingTriangle& t) {
            found.insert(t.corner[0].x);
            return true;
        });
        found_all += found.size();
        const Mesh& mesh = *scene.instances[0].mesh;
        for (const glm::uvec3& t : mesh.triangles) {
            const CastingTriangle casting{{glm::dvec3{mesh.positions_local[t.x]}, glm::dvec3{mesh.positions_local[t.y]},
                                           glm::dvec3{mesh.positions_local[t.z]}}};
            if (touches(casting, apex, quad)) {
                EXPECT_EQ(found.count(casting.corner[0].x), 1U);
            }
        }
    }
    EXPECT_LT(found_all, 40U * 1500U) << "the tree leaves most of the scene out";
}

TEST(ShaftBvh, LeavesOutWhatDoesNotCastOrIsNotFinite) {
    Scene scene = random_scene(10, 3);
    auto broken = std::make_shared<Mesh>(*scene.instances[0].mesh);
    broken->positions_local[0].x = NAN;
    broken->positions_local[4].y = INFINITY;
    scene.instances[0].mesh = broken;
    EXPECT_EQ((ShaftBvh{scene, glm::dvec3{0.0}}.triangle_count()), 8U);
    scene.instances[0].casts = false;
    EXPECT_EQ((ShaftBvh{scene, glm::dvec3{0.0}}.triangle_count()), 0U);
    const ShaftBvh empty{Scene{}, glm::dvec3{0.0}};
    const std::vector<glm::dvec3> quad{{0, 0, 1}, {1, 0, 1}, {1, 1, 1}, {0, 1, 1}};
    empty.visit_shaft(glm::dvec3{0.0}, quad, [](const CastingTriangle&) {
        ADD_FAILURE();
        return true;
    });
}

TEST(ShaftBvh, ARegionKeepsWhatTouchesIt) {
    const Scene scene = random_scene(2000, 4);
    Bounds region;
    region.add({0.0, 0.0, 0.0});
    region.add({1.0, 1.0, 1.0});
    const ShaftBvh part{scene, {5.0, -7.0, 1.0}, region};
    std::size_t expected = 0;
    for (const glm::uvec3& t : scene.instances[0].mesh->triangles) {
        Bounds box;
        for (int i = 0; i < 3; ++i) {
            box.add(glm::dvec3{scene.instances[0].mesh->positions_local[t[i]]});
        }
        expected +=
            glm::all(glm::lessThanEqual(box.low, region.high)) && glm::all(glm::lessThanEqual(region.low, box.high));
    }
    EXPECT_EQ(part.triangle_count(), expected);
    EXPECT_GT(expected, 0U);
}

TEST(ShaftBvh, ManyEqualTrianglesBuildAndAreAllFound) {
    Scene scene = random_scene(1, 5);
    auto same = std::make_shared<Mesh>(*scene.instances[0].mesh);
    same->triangles.assign(1000, glm::uvec3{0, 1, 2});
    scene.instances[0].mesh = same;
    const ShaftBvh bvh{scene, glm::dvec3{0.0}};
    const glm::dvec3 at{same->positions_local[0]};
    const std::vector<glm::dvec3> quad{at + glm::dvec3{-1, -1, 1}, at + glm::dvec3{1, -1, 1}, at + glm::dvec3{1, 1, 1},
                                       at + glm::dvec3{-1, 1, 1}};
    int found = 0;
    bvh.visit_shaft(at - glm::dvec3{0, 0, 1}, quad, [&](const CastingTriangle&) {
        ++found;
        return true;
    });
    EXPECT_EQ(found, 1000);
}

}  // namespace
}  // namespace penumbra
