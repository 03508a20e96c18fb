#include "passes/receiver_texel.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <vector>

namespace penumbra {
namespace {

/// What lib/receiver.glsl makes of it.
glm::dvec3 unpacked(std::uint32_t bits) {
    const glm::dvec2 o = glm::dvec2{bits & 0xffffU, bits >> 16U} / 65535.0 * 2.0 - 1.0;
    glm::dvec3 n{o, 1.0 - std::abs(o.x) - std::abs(o.y)};
    const double fold = std::max(-n.z, 0.0);
    n.x += n.x >= 0.0 ? -fold : fold;
    n.y += n.y >= 0.0 ? -fold : fold;
    return glm::normalize(n);
}

TEST(ReceiverTexel, HoldsNormalsOfAllDirectionsToHalfAStepOfTheOctahedron) {
    // Half a step h = 1/65535 an axis moves a face's point by (h, h, -2 h), across the direction of length 1/sqrt 3 at
    // the face's centre; the rest is float32.
    const double most = std::sqrt(18.0) / 65535.0 + 4e-7;
    std::mt19937 random{1};
    std::normal_distribution<float> normal;
    std::vector<glm::vec3> all{{1, 0, 0}, {-1, 0, 0}, {0, 1, 0}, {0, -1, 0}, {0, 0, 1}, {0, 0, -1}};
    for (int i = 0; i < 10000; ++i) {
        all.push_back(glm::normalize(glm::vec3{normal(random), normal(random), normal(random)}));
    }
    for (const glm::vec3& n : all) {
        const glm::uvec4 texel = receiver_texel({1.5F, -2.0F, 3e-7F}, n);
        EXPECT_NE(texel.w, 0U) << "0 is nothing";
        EXPECT_LT(glm::length(unpacked(texel.w) - glm::dvec3{n}), most) << n.x << " " << n.y << " " << n.z;
        EXPECT_EQ(glm::uintBitsToFloat(glm::uvec3{texel}), (glm::vec3{1.5F, -2.0F, 3e-7F})) << "to the bit";
    }
}

TEST(ReceiverTexel, OfAViewAreThoseOfItsPixelsAndNoneWhereNothingIsSeen) {
    View view;
    view.width = 3;
    view.height = 1;
    view.position_cr = {{1, 2, 3}, {0, 0, 0}, {4, 5, 6}};
    view.normal_ws = {{0, 0, 1}, {0, 0, 0}, {1, 0, 0}};
    view.instance = {0, -1, 1};
    view.triangle = {0, -1, 0};
    std::vector<glm::uvec4> texels(3, glm::uvec4{7U});
    Control control;
    receiver_texels(view, texels, control);
    EXPECT_EQ(texels[0], receiver_texel({1, 2, 3}, {0, 0, 1}));
    EXPECT_EQ(texels[1], glm::uvec4{0U});
    EXPECT_EQ(texels[2], receiver_texel({4, 5, 6}, {1, 0, 0}));
}

}  // namespace
}  // namespace penumbra
