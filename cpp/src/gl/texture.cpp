#include "gl/texture.h"

#include <algorithm>
#include <glm/gtc/type_ptr.hpp>

#include "base/assert.h"
#include "gl/context.h"
#include "gl/texture_formats.h"
#include "penumbra/error.h"

namespace penumbra {
namespace {

std::string size_text(int width, int height, int layers) {
    return std::to_string(width) + " x " + std::to_string(height) +
           (layers > 1 ? " x " + std::to_string(layers) : std::string()) + " texels";
}

int at_level(int size, int level) {
    return std::max(size >> level, 1);
}

std::size_t texel_count(int width, int height, int layers, int level) {
    return static_cast<std::size_t>(at_level(width, level)) * static_cast<std::size_t>(at_level(height, level)) *
           static_cast<std::size_t>(layers);
}

void require_size(GLenum target, int width, int height, int layers, int levels, std::string_view what) {
    const Context* context = Context::current();
    PENUMBRA_ASSERT(context != nullptr);
    const DeviceLimits& limits = context->limits();
    const int side = target == GL_TEXTURE_CUBE_MAP ? limits.max_cube_map_size_px : limits.max_texture_size_px;
    const std::string name(what);
    if (width < 1 || height < 1 || layers < 1) {
        throw InvalidSettings(name + ": a texture of " + size_text(width, height, layers) +
                              " holds nothing; every side must be at least 1");
    }
    if (width > side || height > side) {
        throw InvalidSettings(name + ": a texture of " + size_text(width, height, layers) + " exceeds " +
                              std::to_string(side) + " texels a side, the limit of " + context->info().name +
                              "; ask for a smaller one");
    }
    if (target == GL_TEXTURE_2D_ARRAY && layers > limits.max_array_layers) {
        throw InvalidSettings(name + ": a texture of " + std::to_string(layers) + " layers exceeds " +
                              std::to_string(limits.max_array_layers) + ", the limit of " + context->info().name +
                              "; ask for fewer");
    }
    PENUMBRA_ASSERT(levels >= 1 && (std::max(width, height) >> (levels - 1)) >= 1);
    static_cast<void>(levels);
}

// One depth and stencil value as GL_FLOAT_32_UNSIGNED_INT_24_8_REV has it.
struct DepthStencil {
    float depth;
    std::uint32_t stencil;
};

}  // namespace

TextureImage TextureImage::make_2d(GLenum format, int width_px, int height_px, std::string_view what, int levels) {
    return make(GL_TEXTURE_2D, format, width_px, height_px, 1, levels, what);
}

TextureImage TextureImage::make_array(GLenum format, int width_px, int height_px, int layers, std::string_view what,
                                      int levels) {
    return make(GL_TEXTURE_2D_ARRAY, format, width_px, height_px, layers, levels, what);
}

TextureImage TextureImage::make_cube(GLenum format, int size_px, std::string_view what, int levels) {
    return make(GL_TEXTURE_CUBE_MAP, format, size_px, size_px, 6, levels, what);
}

TextureImage TextureImage::make(GLenum target, GLenum format, int width, int height, int layers, int levels,
                                std::string_view what) {
    require_size(target, width, height, layers, levels, what);
    const FormatInfo& info = format_info(format);
    check_gl("before making " + std::string(what));

    TextureImage image;
    image.texture_ = Texture::create(target);
    image.target_ = target;
    image.format_ = format;
    image.width_ = width;
    image.height_ = height;
    image.layers_ = layers;
    image.levels_ = levels;
    image.what_ = what;
    if (target == GL_TEXTURE_2D_ARRAY) {
        glTextureStorage3D(image.name(), levels, format, width, height, layers);
    } else {
        glTextureStorage2D(image.name(), levels, format, width, height);
    }
    if (glGetError() == GL_OUT_OF_MEMORY) {
        Context& context = *Context::current();
        context.discard_errors();
        constexpr std::size_t kMebibyte = std::size_t{1} << 20U;
        throw OutOfMemory(image.what_ + ": a texture of " + size_text(width, height, layers) + " (" + info.name + ", " +
                          std::to_string(image.bytes() / kMebibyte) + " MiB) is more than " + context.info().name +
                          " gives; ask for a smaller one");
    }
    image.set_filter(GL_NEAREST, GL_NEAREST);
    image.set_wrap(GL_CLAMP_TO_EDGE);
    glObjectLabel(GL_TEXTURE, image.name(), static_cast<GLsizei>(what.size()), what.data());
    check_gl("making " + image.what_);
    return image;
}

TextureImage TextureImage::view_of(const TextureImage& array, int first_layer, int layers) {
    PENUMBRA_ASSERT(array.target_ == GL_TEXTURE_2D_ARRAY && first_layer >= 0 && layers >= 1 &&
                    first_layer + layers <= array.layers_);
    TextureImage image;
    image.texture_ = Texture::create();
    image.target_ = array.target_;
    image.format_ = array.format_;
    image.width_ = array.width_;
    image.height_ = array.height_;
    image.layers_ = layers;
    image.levels_ = array.levels_;
    image.what_ = array.what_;
    glTextureView(image.name(), array.target_, array.name(), array.format_, 0, static_cast<GLuint>(array.levels_),
                  static_cast<GLuint>(first_layer), static_cast<GLuint>(layers));
    image.set_filter(GL_NEAREST, GL_NEAREST);
    image.set_wrap(GL_CLAMP_TO_EDGE);
    check_gl("a view of " + image.what_);
    return image;
}

int TextureImage::components() const noexcept {
    return format_ == 0 ? 0 : format_info(format_).components;
}

std::size_t TextureImage::bytes() const noexcept {
    if (format_ == 0) {
        return 0;
    }
    std::size_t texels = 0;
    for (int level = 0; level < levels_; ++level) {
        texels += texel_count(width_, height_, layers_, level);
    }
    return texels * static_cast<std::size_t>(format_info(format_).bytes_per_texel);
}

void TextureImage::set_filter(GLenum minify, GLenum magnify) {
    glTextureParameteri(name(), GL_TEXTURE_MIN_FILTER, static_cast<GLint>(minify));
    glTextureParameteri(name(), GL_TEXTURE_MAG_FILTER, static_cast<GLint>(magnify));
}

void TextureImage::set_wrap(GLenum mode) {
    for (const GLenum axis : {GL_TEXTURE_WRAP_S, GL_TEXTURE_WRAP_T, GL_TEXTURE_WRAP_R}) {
        glTextureParameteri(name(), axis, static_cast<GLint>(mode));
    }
}

void TextureImage::set_border(const glm::vec4& value) {
    glTextureParameterfv(name(), GL_TEXTURE_BORDER_COLOR, glm::value_ptr(value));
}

void TextureImage::set_compare(GLenum function) {
    const bool on = function != GL_NONE;
    glTextureParameteri(name(), GL_TEXTURE_COMPARE_MODE, on ? GL_COMPARE_REF_TO_TEXTURE : GL_NONE);
    if (on) {
        glTextureParameteri(name(), GL_TEXTURE_COMPARE_FUNC, static_cast<GLint>(function));
    }
}

void TextureImage::make_mipmaps() {
    glGenerateTextureMipmap(name());
}

std::size_t TextureImage::value_count(int level) const noexcept {
    return texel_count(width_, height_, layers_, level) * static_cast<std::size_t>(components());
}

void TextureImage::upload_raw(const void* values, std::size_t count, GLenum type) {
    // Checked in release builds too: OpenGL would read past the caller's array.
    if (count != value_count(0)) {
        throw DeviceError(what_ + ": " + std::to_string(count) + " values given for a texture that holds " +
                          std::to_string(value_count(0)) + "; this is a fault of Penumbra, please report it");
    }
    const GLenum pixel_format = format_info(format_).pixel_format;
    if (target_ == GL_TEXTURE_2D) {
        glTextureSubImage2D(name(), 0, 0, 0, width_, height_, pixel_format, type, values);
    } else {
        glTextureSubImage3D(name(), 0, 0, 0, 0, width_, height_, layers_, pixel_format, type, values);
    }
}

void TextureImage::read_raw(void* values, std::size_t count, GLenum type, int level) const {
    const FormatInfo& info = format_info(format_);
    if (count != value_count(level)) {
        throw DeviceError(what_ + ": room for " + std::to_string(count) + " values given for a texture that holds " +
                          std::to_string(value_count(level)) + "; this is a fault of Penumbra, please report it");
    }
    // Bytes of a format with stencil are its stencil, floats its depth.
    const GLenum pixel_format = info.stencil && type == GL_UNSIGNED_BYTE ? GL_STENCIL_INDEX : info.pixel_format;
    std::size_t value_bytes = 4;
    if (type == GL_UNSIGNED_BYTE) {
        value_bytes = 1;
    } else if (type == GL_UNSIGNED_SHORT) {
        value_bytes = 2;
    }
    constexpr std::size_t kMostBytes = 0x7fffffff;  // what OpenGL's signed size can say
    const std::size_t bytes = count * value_bytes;
    if (bytes <= kMostBytes) {
        glGetTextureImage(name(), level, pixel_format, type, static_cast<GLsizei>(bytes), values);
        return;
    }
    const std::size_t layer_bytes = bytes / static_cast<std::size_t>(layers_);
    for (int layer = 0; layer < layers_; ++layer) {
        glGetTextureSubImage(name(), level, 0, 0, layer, at_level(width_, level), at_level(height_, level), 1,
                             pixel_format, type, static_cast<GLsizei>(std::min(layer_bytes, kMostBytes)),
                             static_cast<unsigned char*>(values) + layer_bytes * static_cast<std::size_t>(layer));
    }
}

void TextureImage::clear(const glm::vec4& value) {
    const FormatInfo& info = format_info(format_);
    PENUMBRA_ASSERT(!info.integer);
    if (info.depth && info.stencil) {
        const DepthStencil both{value.x, static_cast<std::uint32_t>(value.y)};
        glClearTexImage(name(), 0, GL_DEPTH_STENCIL, GL_FLOAT_32_UNSIGNED_INT_24_8_REV, &both);
    } else {
        glClearTexImage(name(), 0, info.depth ? GL_DEPTH_COMPONENT : GL_RGBA, GL_FLOAT, glm::value_ptr(value));
    }
}

void TextureImage::clear(const glm::uvec4& value) {
    PENUMBRA_ASSERT(format_info(format_).integer);
    glClearTexImage(name(), 0, GL_RGBA_INTEGER, GL_UNSIGNED_INT, glm::value_ptr(value));
}

void TextureImage::clear(const glm::ivec4& value) {
    PENUMBRA_ASSERT(format_info(format_).integer);
    glClearTexImage(name(), 0, GL_RGBA_INTEGER, GL_INT, glm::value_ptr(value));
}

void TextureImage::bind(GLuint unit) const {
    glBindTextureUnit(unit, name());
}

void TextureImage::bind_image(GLuint unit, GLenum access, int level) const {
    glBindImageTexture(unit, name(), level, layers_ > 1 ? GL_TRUE : GL_FALSE, 0, access, format_);
}

}  // namespace penumbra
