#pragma once

#include <string_view>

#include "gl/buffer.h"
#include "gl/handles.h"

namespace penumbra {

/// A buffer read as texels: samplerBuffer in shaders.
class BufferTexture {
public:
    BufferTexture() noexcept = default;
    /// @param format  of a texel: GL_RGBA32F, GL_RGB32UI ...
    /// @param buffer  all of it, without a copy. Make this anew when the buffer's name has changed.
    /// @throws OutOfMemory if it holds more texels than the device can address
    BufferTexture(GLenum format, const StorageBuffer& buffer, std::string_view what);

    void bind(GLuint unit) const { glBindTextureUnit(unit, texture_.name()); }

private:
    Texture texture_;
};

}  // namespace penumbra
