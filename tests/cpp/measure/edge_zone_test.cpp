#include "measure/edge_zone.h"

#include <gmock/gmock.h>

#include <cstdlib>

namespace penumbra {
namespace {

using enum PixelClass;

TEST(EdgeZone, ReachesItsRadiusAroundAPenumbraPixelAndNoFarther) {
    std::vector<PixelClass> classes(81, Lit);
    classes[40] = Penumbra;  // middle of 9 x 9
    const auto zone = edge_zone(classes, 9, 2);
    for (int y = 0; y < 9; ++y) {
        for (int x = 0; x < 9; ++x) {
            EXPECT_EQ(zone[static_cast<std::size_t>(y * 9 + x)], std::abs(x - 4) <= 2 && std::abs(y - 4) <= 2);
        }
    }
}

TEST(EdgeZone, FindsHardEdgesInBothDirections) {
    EXPECT_THAT(edge_zone(std::vector{Umbra, Umbra, Lit, Lit}, 4, 0), testing::ElementsAre(0, 1, 1, 0));
    EXPECT_THAT(edge_zone(std::vector{Umbra, Umbra, Lit, Lit}, 1, 0), testing::ElementsAre(0, 1, 1, 0));
}

TEST(EdgeZone, TakesNoEdgeFromWhatLiesOutside) {
    EXPECT_THAT(edge_zone(std::vector{Umbra, Outside, Lit, Outside}, 4, 3), testing::Each(0));
    EXPECT_TRUE(edge_zone({}, 1, 4).empty());
}

}  // namespace
}  // namespace penumbra
