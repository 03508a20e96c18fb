#include "gl/workarounds.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <string>

namespace penumbra {
namespace {

std::string lower(std::string_view text) {
    std::string result(text);
    std::ranges::transform(result, result.begin(), [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
    return result;
}

}  // namespace

bool is_software_renderer(std::string_view renderer) noexcept {
    // "zink Vulkan 1.3 (llvmpipe ...)" is a software device too, hence a search and no comparison.
    constexpr std::array<std::string_view, 6> kNames{"llvmpipe",  "softpipe",    "swrast",
                                                     "swr (llvm", "swiftshader", "software rasterizer"};
    const std::string name = lower(renderer);
    return std::ranges::any_of(kNames, [&](std::string_view part) { return name.find(part) != std::string::npos; });
}

Workarounds decide_workarounds(std::string_view /*vendor*/, std::string_view renderer, std::string_view /*version*/) {
    Workarounds result;
    if (is_software_renderer(renderer)) {
        result.time_by_wall_clock = true;
        result.applied.push_back({"time_by_wall_clock",
                                  "a software rasteriser bins work first and does it at the next flush, so that "
                                  "timestamps between two draws measure little"});
    }
    return result;
}

}  // namespace penumbra
