#pragma once

#include <cstddef>
#include <cstdint>
#include <glm/glm.hpp>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "gl/handles.h"

namespace penumbra {

/// How one value of a C++ type is handed to OpenGL: scalar type and number of components.
template <class T>
struct PixelTraits;
template <>
struct PixelTraits<float> {
    static constexpr GLenum kType = GL_FLOAT;
    static constexpr int kComponents = 1;
};
template <>
struct PixelTraits<std::uint8_t> {
    static constexpr GLenum kType = GL_UNSIGNED_BYTE;
    static constexpr int kComponents = 1;
};
template <>
struct PixelTraits<std::uint16_t> {
    static constexpr GLenum kType = GL_UNSIGNED_SHORT;
    static constexpr int kComponents = 1;
};
template <>
struct PixelTraits<std::uint32_t> {
    static constexpr GLenum kType = GL_UNSIGNED_INT;
    static constexpr int kComponents = 1;
};
template <>
struct PixelTraits<std::int32_t> {
    static constexpr GLenum kType = GL_INT;
    static constexpr int kComponents = 1;
};
template <glm::length_t N, class T, glm::qualifier Q>
struct PixelTraits<glm::vec<N, T, Q>> {
    static constexpr GLenum kType = PixelTraits<T>::kType;
    static constexpr int kComponents = N;
};

/// A texture with immutable storage: 2D, 2D array or cube map. Values cross the border as whole images, row 0 at the
/// bottom, layer after layer (cube faces in the order +x, -x, +y, -y, +z, -z).
///
/// Elements of upload() and read() are scalars (component count of the format per texel) or GLM vectors with exactly
/// that many components: R32F float; RG32F glm::vec2; RGBA32F glm::vec4; R32UI std::uint32_t; depth formats float;
/// 8-bit formats std::uint8_t or float; 16-bit float formats float.
class TextureImage {
public:
    TextureImage() noexcept = default;

    /// @param format a sized internal format (GL_R32F, GL_DEPTH_COMPONENT32F, ...); see texture_formats.cpp
    /// @param what named in error messages and to graphics debuggers: "shadow map"
    /// @throws InvalidSettings if a side or the layers exceed the device's limit; OutOfMemory if it is refused
    [[nodiscard]] static TextureImage make_2d(GLenum format, int width_px, int height_px, std::string_view what,
                                              int levels = 1);
    [[nodiscard]] static TextureImage make_array(GLenum format, int width_px, int height_px, int layers,
                                                 std::string_view what, int levels = 1);
    [[nodiscard]] static TextureImage make_cube(GLenum format, int size_px, std::string_view what, int levels = 1);
    /// Some layers of an array as an array of their own, sharing its memory, which lives as long as either. Filter and
    /// wrap are the view's own.
    [[nodiscard]] static TextureImage view_of(const TextureImage& array, int first_layer, int layers);

    [[nodiscard]] GLuint name() const noexcept { return texture_.name(); }
    [[nodiscard]] explicit operator bool() const noexcept { return static_cast<bool>(texture_); }
    [[nodiscard]] GLenum target() const noexcept { return target_; }
    [[nodiscard]] GLenum format() const noexcept { return format_; }
    [[nodiscard]] int width() const noexcept { return width_; }
    [[nodiscard]] int height() const noexcept { return height_; }
    /// 1 for 2D, 6 for a cube.
    [[nodiscard]] int layers() const noexcept { return layers_; }
    [[nodiscard]] int levels() const noexcept { return levels_; }
    [[nodiscard]] int components() const noexcept;
    /// Of all levels and layers, by the format's size; what the driver adds is not known.
    [[nodiscard]] std::size_t bytes() const noexcept;
    [[nodiscard]] const std::string& what() const noexcept { return what_; }

    /// @param minify one of GL_NEAREST, GL_LINEAR, GL_*_MIPMAP_*; @param magnify GL_NEAREST or GL_LINEAR
    /// New textures are GL_NEAREST, clamped to the edge, without comparison.
    void set_filter(GLenum minify, GLenum magnify);
    /// @param mode GL_CLAMP_TO_EDGE, GL_CLAMP_TO_BORDER, GL_REPEAT, ...
    void set_wrap(GLenum mode);
    void set_border(const glm::vec4& value);
    /// Depth formats: sampler2DShadow with this function (GL_LEQUAL); GL_NONE switches it off again.
    void set_compare(GLenum function);
    void make_mipmaps();

    /// All layers of level 0. @param texels width * height * layers texels
    template <class T>
    void upload(std::span<const T> texels) {
        upload_raw(texels.data(), texels.size() * PixelTraits<T>::kComponents, PixelTraits<T>::kType);
    }
    /// All layers of one level.
    template <class T>
    [[nodiscard]] std::vector<T> read(int level = 0) const {
        std::vector<T> texels(value_count(level) / PixelTraits<T>::kComponents);
        read_raw(texels.data(), texels.size() * PixelTraits<T>::kComponents, PixelTraits<T>::kType, level);
        return texels;
    }
    /// The same into memory of the caller's, of exactly that size.
    template <class T>
    void read_into(std::span<T> texels, int level = 0) const {
        read_raw(texels.data(), texels.size() * PixelTraits<T>::kComponents, PixelTraits<T>::kType, level);
    }
    /// Every texel of level 0 becomes this colour (or depth in x); integer formats take the integer overload.
    void clear(const glm::vec4& value);
    void clear(const glm::uvec4& value);
    void clear(const glm::ivec4& value);

    /// To a sampler: layout(binding = unit).
    void bind(GLuint unit) const;
    /// To an image variable: layout(binding = unit, <format>); all layers. @param access GL_READ_ONLY, ...
    void bind_image(GLuint unit, GLenum access, int level = 0) const;

private:
    [[nodiscard]] static TextureImage make(GLenum target, GLenum format, int width, int height, int layers, int levels,
                                           std::string_view what);
    [[nodiscard]] std::size_t value_count(int level) const noexcept;
    void upload_raw(const void* values, std::size_t count, GLenum type);
    void read_raw(void* values, std::size_t count, GLenum type, int level) const;

    Texture texture_;
    GLenum target_ = GL_TEXTURE_2D;
    GLenum format_ = 0;
    int width_ = 0;
    int height_ = 0;
    int layers_ = 0;
    int levels_ = 0;
    std::string what_;
};

}  // namespace penumbra
