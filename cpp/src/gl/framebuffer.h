#pragma once

#include <glm/glm.hpp>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "gl/texture.h"

namespace penumbra {

/// Where a pass draws to. Does not own its textures; they must outlive it.
class RenderTarget {
public:
    /// All layers of a texture, to be chosen by gl_Layer.
    static constexpr int kAllLayers = -1;

    RenderTarget() noexcept = default;
    /// @param what for messages: "G-buffer"
    explicit RenderTarget(std::string_view what);

    /// @param slot layout(location = slot) of the fragment shader, 0 .. 7
    void attach_colour(int slot, const TextureImage& texture, int layer = kAllLayers, int level = 0);
    /// Depth, or depth and stencil, by the texture's format.
    void attach_depth(const TextureImage& texture, int layer = kAllLayers, int level = 0);
    /// Draws nothing but side effects. @param width_px, height_px of the raster
    void set_size_without_attachment(int width_px, int height_px);

    /// @throws DeviceError that names the target, the fault and every attachment (format, size, layer)
    void check_complete() const;

    /// Binds for drawing and sets the viewport to the whole of it. Checks completeness once after a change.
    void bind();
    /// Clears obey the write masks and the scissor, as OpenGL has it.
    void clear_colour(int slot, const glm::vec4& value);
    void clear_colour(int slot, const glm::ivec4& value);
    void clear_colour(int slot, const glm::uvec4& value);
    void clear_depth(float value);
    void clear_depth_stencil(float depth, int stencil);

    [[nodiscard]] GLuint name() const noexcept { return framebuffer_.name(); }
    [[nodiscard]] explicit operator bool() const noexcept { return static_cast<bool>(framebuffer_); }
    [[nodiscard]] int width() const noexcept { return width_; }
    [[nodiscard]] int height() const noexcept { return height_; }

private:
    void attach(GLenum point, const TextureImage& texture, int layer, int level);

    Framebuffer framebuffer_;
    std::string what_;
    std::map<GLenum, std::string> attachments_;  ///< in words, for check_complete()
    std::vector<GLenum> draw_buffers_;
    int width_ = 0;
    int height_ = 0;
    bool checked_ = false;
};

}  // namespace penumbra
