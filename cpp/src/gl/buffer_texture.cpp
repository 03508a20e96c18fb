#include "gl/buffer_texture.h"

#include <string>

#include "base/assert.h"
#include "gl/context.h"
#include "penumbra/error.h"

namespace penumbra {

namespace {

std::size_t texel_bytes(GLenum format) {
    switch (format) {
        case GL_R32UI:
            return 4;
        case GL_RGB32F:
        case GL_RGB32UI:
            return 12;
        default:
            PENUMBRA_ASSERT(format == GL_RGBA32F || format == GL_RGBA32UI);
            return 16;
    }
}

}  // namespace

BufferTexture::BufferTexture(GLenum format, const StorageBuffer& buffer, std::string_view what)
    : texture_{Texture::create(GL_TEXTURE_BUFFER)} {
    GLint most = 0;
    glGetIntegerv(GL_MAX_TEXTURE_BUFFER_SIZE, &most);
    const std::size_t texels = buffer.bytes() / texel_bytes(format);
    if (texels > static_cast<std::size_t>(most)) {
        throw OutOfMemory(std::string(what) + ": " + std::to_string(texels) + " of them are more than the " +
                          std::to_string(most) + " that " + Context::current()->info().name +
                          " can read as texels; use fewer triangles");
    }
    glTextureBuffer(texture_.name(), format, buffer.name());
    check_gl(std::string("reading as texels: ") + std::string(what));
}

}  // namespace penumbra
