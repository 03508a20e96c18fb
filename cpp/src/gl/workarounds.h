#pragma once

#include <string_view>
#include <vector>

namespace penumbra {

/// Every special case for a driver, by name. Code asks for the name, never for the vendor.
struct Workarounds {
    bool time_by_wall_clock = false;  ///< timer queries measure little: use the CPU's clock around glFinish

    struct Applied {
        std::string_view name;
        std::string_view reason;
    };
    std::vector<Applied> applied;  ///< those that are on, for `doctor` and the report's environment
};

/// True for rasterisers that run on the CPU: llvmpipe, softpipe, swrast, SWR, SwiftShader.
[[nodiscard]] bool is_software_renderer(std::string_view renderer) noexcept;

/// @param vendor GL_VENDOR, @param renderer GL_RENDERER, @param version GL_VERSION
[[nodiscard]] Workarounds decide_workarounds(std::string_view vendor, std::string_view renderer,
                                             std::string_view version);

}  // namespace penumbra
