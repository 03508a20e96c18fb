#include "gl/texture_formats.h"

#include <algorithm>
#include <array>
#include <string>

#include "penumbra/error.h"

namespace penumbra {
namespace {

#define PENUMBRA_FORMAT(name, pixel_format, components, bytes, integer, depth, stencil) \
    FormatInfo {                                                                        \
        GL_##name, #name, pixel_format, components, bytes, integer, depth, stencil      \
    }

const std::array kFormats{
    PENUMBRA_FORMAT(R8, GL_RED, 1, 1, false, false, false),
    PENUMBRA_FORMAT(RG8, GL_RG, 2, 2, false, false, false),
    PENUMBRA_FORMAT(RGBA8, GL_RGBA, 4, 4, false, false, false),
    PENUMBRA_FORMAT(R16, GL_RED, 1, 2, false, false, false),
    PENUMBRA_FORMAT(RG16, GL_RG, 2, 4, false, false, false),
    PENUMBRA_FORMAT(RGBA16, GL_RGBA, 4, 8, false, false, false),
    PENUMBRA_FORMAT(R16F, GL_RED, 1, 2, false, false, false),
    PENUMBRA_FORMAT(RG16F, GL_RG, 2, 4, false, false, false),
    PENUMBRA_FORMAT(RGBA16F, GL_RGBA, 4, 8, false, false, false),
    PENUMBRA_FORMAT(R32F, GL_RED, 1, 4, false, false, false),
    PENUMBRA_FORMAT(RG32F, GL_RG, 2, 8, false, false, false),
    PENUMBRA_FORMAT(RGBA32F, GL_RGBA, 4, 16, false, false, false),
    PENUMBRA_FORMAT(R8UI, GL_RED_INTEGER, 1, 1, true, false, false),
    PENUMBRA_FORMAT(R16UI, GL_RED_INTEGER, 1, 2, true, false, false),
    PENUMBRA_FORMAT(R32UI, GL_RED_INTEGER, 1, 4, true, false, false),
    PENUMBRA_FORMAT(RG32UI, GL_RG_INTEGER, 2, 8, true, false, false),
    PENUMBRA_FORMAT(RGBA32UI, GL_RGBA_INTEGER, 4, 16, true, false, false),
    PENUMBRA_FORMAT(R32I, GL_RED_INTEGER, 1, 4, true, false, false),
    PENUMBRA_FORMAT(RG32I, GL_RG_INTEGER, 2, 8, true, false, false),
    PENUMBRA_FORMAT(RGBA32I, GL_RGBA_INTEGER, 4, 16, true, false, false),
    PENUMBRA_FORMAT(DEPTH_COMPONENT16, GL_DEPTH_COMPONENT, 1, 2, false, true, false),
    PENUMBRA_FORMAT(DEPTH_COMPONENT24, GL_DEPTH_COMPONENT, 1, 4, false, true, false),
    PENUMBRA_FORMAT(DEPTH_COMPONENT32F, GL_DEPTH_COMPONENT, 1, 4, false, true, false),
    PENUMBRA_FORMAT(DEPTH24_STENCIL8, GL_DEPTH_COMPONENT, 1, 4, false, true, true),
    PENUMBRA_FORMAT(DEPTH32F_STENCIL8, GL_DEPTH_COMPONENT, 1, 8, false, true, true),
    PENUMBRA_FORMAT(STENCIL_INDEX8, GL_STENCIL_INDEX, 1, 1, false, false, true),
};

#undef PENUMBRA_FORMAT

}  // namespace

const FormatInfo& format_info(GLenum internal_format) {
    const auto found =
        std::ranges::find_if(kFormats, [&](const FormatInfo& info) { return info.format == internal_format; });
    if (found == kFormats.end()) {
        throw DeviceError("texture format " + std::to_string(internal_format) +
                          " is not in the table of texture_formats.cpp; add it there");
    }
    return *found;
}

}  // namespace penumbra
