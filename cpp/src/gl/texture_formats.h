#pragma once

#include "gl/gl.h"

namespace penumbra {

/// What a sized internal format holds.
struct FormatInfo {
    GLenum format = 0;        ///< GL_R32F
    const char* name = "";    ///< "R32F"
    GLenum pixel_format = 0;  ///< for transfers: GL_RED, GL_RED_INTEGER, GL_DEPTH_COMPONENT, ...
    int components = 0;
    int bytes_per_texel = 0;
    bool integer = false;
    bool depth = false;
    bool stencil = false;
};

/// The formats that we use. @throws DeviceError for one that is not in the table (a bug of ours)
[[nodiscard]] const FormatInfo& format_info(GLenum internal_format);

}  // namespace penumbra
