#pragma once

#include <map>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace penumbra {

/// Shader texts by key: "lib/depth.glsl", "shared/light.h", "passes/gbuffer.vert", "techniques/pcf/lookup.frag".
using ShaderSources = std::map<std::string, std::string, std::less<>>;

/// The texts that the build has put into this binary.
[[nodiscard]] const ShaderSources& embedded_shaders();

/// A preprocessor macro: `#define name value`.
struct Define {
    std::string name;
    std::string value = "1";
};
using Defines = std::vector<Define>;

/// One stage, ready for the driver: version line, defines, includes in their place.
struct ExpandedSource {
    struct Place {
        std::size_t file = 0;  ///< index into files
        int line = 0;          ///< from 1
    };
    std::string text;
    std::vector<std::string> files;
    std::vector<Place> places;  ///< where each line of `text` comes from
};

/// Puts `#include "key"` in place, each file once, and notes where each line came from. A table, and no `#line`: Mesa
/// 22.3 forgets the file number of `#line` in most of its messages.
/// `#pragma once` and regions for C++ only (`#ifdef __cplusplus` .. `#else` / `#endif`) are left out; `#include <...>`
/// outside of them is an error. The library writes `#version 450 core`; a file that brings its own is refused.
/// @throws DeviceError naming file and line of a missing include
[[nodiscard]] ExpandedSource expand(const ShaderSources& sources, std::string_view key,
                                    std::span<const Define> defines);

/// Leads the places in a driver's log ("0:12(5): error", "0(12) : error", "ERROR: 0:12:") back to file and line, and
/// puts the source line under each: "techniques/pcf/lookup.frag:12: error: ...\n    float x = y;".
[[nodiscard]] std::string readable_log(std::string_view log, const ExpandedSource& source);

}  // namespace penumbra
