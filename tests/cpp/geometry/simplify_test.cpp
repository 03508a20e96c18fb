#include "geometry/simplify.h"

#include <gtest/gtest.h>

#include "support/scenes.h"

namespace penumbra {
namespace {

TEST(Simplify, AMeshWithFewTrianglesIsHandedBack) {
    const auto box = scenes::box({-1, -1, -1}, {1, 1, 1});
    const SimplifiedMesh simplified = simplify(box, 12);
    EXPECT_EQ(simplified.mesh, box);
    EXPECT_EQ(simplified.deviation, 0.0);
}

TEST(Simplify, ASphereKeepsItsShapeWithinTheDeviationThatIsReported) {
    const auto ball = scenes::sphere(64, false);
    const SimplifiedMesh simplified = simplify(ball, 2000);
    EXPECT_LE(simplified.mesh->triangles.size(), 2100U);
    EXPECT_GE(simplified.mesh->triangles.size(), 1000U);
    EXPECT_GT(simplified.deviation, 0.0);
    EXPECT_LT(simplified.deviation, 0.02);
    for (const glm::vec3& p : simplified.mesh->positions_local) {
        EXPECT_NEAR(glm::length(p), 1.0F, 1e-5F);  // left out, never moved
    }
    for (const glm::uvec3& t : simplified.mesh->triangles) {
        const glm::vec3 centre = (simplified.mesh->positions_local[t.x] + simplified.mesh->positions_local[t.y] +
                                  simplified.mesh->positions_local[t.z]) /
                                 3.0F;
        EXPECT_GE(glm::length(centre), 1.0 - simplified.deviation - 1e-3);
    }
}

TEST(Simplify, VerticesDoubledForNormalsAreNoBorders) {
    const auto ball = scenes::sphere(32, false);
    auto torn = std::make_shared<Mesh>();
    for (const glm::uvec3& t : ball->triangles) {
        const auto first = static_cast<std::uint32_t>(torn->positions_local.size());
        for (int k = 0; k < 3; ++k) {
            torn->positions_local.push_back(ball->positions_local[t[k]]);
        }
        torn->triangles.emplace_back(first, first + 1, first + 2);
    }
    EXPECT_LE(simplify(torn, 500).mesh->triangles.size(), 520U);
}

}  // namespace
}  // namespace penumbra
