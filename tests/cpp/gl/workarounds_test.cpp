#include "gl/workarounds.h"

#include <gtest/gtest.h>

namespace penumbra {
namespace {

TEST(Workarounds, SoftwareRasterisersAreTimedByTheWallClock) {
    for (const char* renderer :
         {"llvmpipe (LLVM 15.0.6, 256 bits)", "softpipe", "zink Vulkan 1.3(llvmpipe (LLVM 17.0.6, 256 bits))",
          "Google SwiftShader", "SWR (LLVM 12.0.0, 256 bits)", "Software Rasterizer"}) {
        EXPECT_TRUE(is_software_renderer(renderer)) << renderer;
        const Workarounds workarounds = decide_workarounds("Mesa", renderer, "4.5");
        EXPECT_TRUE(workarounds.time_by_wall_clock) << renderer;
        ASSERT_EQ(workarounds.applied.size(), 1U);
        EXPECT_FALSE(workarounds.applied[0].reason.empty());
    }
}

TEST(Workarounds, HardwareNeedsNone) {
    for (const char* renderer : {"NVIDIA GeForce RTX 4090/PCIe/SSE2", "AMD Radeon RX 7900 XTX (radeonsi, navi31)",
                                 "Mesa Intel(R) Arc(tm) A770 Graphics (DG2)"}) {
        EXPECT_FALSE(is_software_renderer(renderer)) << renderer;
        EXPECT_TRUE(decide_workarounds("vendor", renderer, "4.6").applied.empty()) << renderer;
    }
}

}  // namespace
}  // namespace penumbra
