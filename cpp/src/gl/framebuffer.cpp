#include "gl/framebuffer.h"

#include <algorithm>
#include <glm/gtc/type_ptr.hpp>

#include "gl/texture_formats.h"
#include "penumbra/error.h"

namespace penumbra {
namespace {

std::string status_text(GLenum status) {
    switch (status) {
        case GL_FRAMEBUFFER_INCOMPLETE_ATTACHMENT:
            return "an attachment cannot be drawn to";
        case GL_FRAMEBUFFER_INCOMPLETE_MISSING_ATTACHMENT:
            return "nothing is attached";
        case GL_FRAMEBUFFER_UNSUPPORTED:
            return "the driver does not support this combination of formats";
        case GL_FRAMEBUFFER_INCOMPLETE_MULTISAMPLE:
            return "the attachments differ in their number of samples";
        case GL_FRAMEBUFFER_INCOMPLETE_LAYER_TARGETS:
            return "some attachments are layered and some are not";
        default:
            return "status " + std::to_string(status);
    }
}

}  // namespace

RenderTarget::RenderTarget(std::string_view what) : framebuffer_{Framebuffer::create()}, what_{what} {
    glNamedFramebufferDrawBuffer(framebuffer_.name(), GL_NONE);
    glObjectLabel(GL_FRAMEBUFFER, framebuffer_.name(), static_cast<GLsizei>(what.size()), what.data());
}

void RenderTarget::attach(GLenum point, const TextureImage& texture, int layer, int level) {
    if (layer == kAllLayers) {
        glNamedFramebufferTexture(name(), point, texture.name(), level);
    } else if (texture.target() == GL_TEXTURE_2D) {
        PENUMBRA_ASSERT(layer == 0);
        glNamedFramebufferTexture(name(), point, texture.name(), level);
    } else {
        glNamedFramebufferTextureLayer(name(), point, texture.name(), level, layer);
    }
    width_ = std::max(texture.width() >> level, 1);
    height_ = std::max(texture.height() >> level, 1);
    checked_ = false;

    std::string text = texture.what() + " (" + format_info(texture.format()).name + ", " + std::to_string(width_) +
                       " x " + std::to_string(height_);
    if (texture.layers() > 1) {
        text += layer == kAllLayers ? ", all layers" : ", layer " + std::to_string(layer);
    }
    attachments_[point] = text + ")";
}

void RenderTarget::attach_colour(int slot, const TextureImage& texture, int layer, int level) {
    PENUMBRA_ASSERT(slot >= 0 && slot < 8);
    attach(GL_COLOR_ATTACHMENT0 + static_cast<GLenum>(slot), texture, layer, level);
    const auto index = static_cast<std::size_t>(slot);
    if (draw_buffers_.size() <= index) {
        draw_buffers_.resize(index + 1, GL_NONE);
    }
    draw_buffers_[index] = GL_COLOR_ATTACHMENT0 + static_cast<GLenum>(slot);
    glNamedFramebufferDrawBuffers(name(), static_cast<GLsizei>(draw_buffers_.size()), draw_buffers_.data());
}

void RenderTarget::attach_depth(const TextureImage& texture, int layer, int level) {
    const FormatInfo& info = format_info(texture.format());
    PENUMBRA_ASSERT(info.depth || info.stencil);
    GLenum point = GL_DEPTH_ATTACHMENT;
    if (info.stencil) {
        point = info.depth ? GL_DEPTH_STENCIL_ATTACHMENT : GL_STENCIL_ATTACHMENT;
    }
    attach(point, texture, layer, level);
}

void RenderTarget::set_size_without_attachment(int width_px, int height_px) {
    glNamedFramebufferParameteri(name(), GL_FRAMEBUFFER_DEFAULT_WIDTH, width_px);
    glNamedFramebufferParameteri(name(), GL_FRAMEBUFFER_DEFAULT_HEIGHT, height_px);
    width_ = width_px;
    height_ = height_px;
    checked_ = false;
}

void RenderTarget::check_complete() const {
    const GLenum status = glCheckNamedFramebufferStatus(name(), GL_DRAW_FRAMEBUFFER);
    if (status == GL_FRAMEBUFFER_COMPLETE) {
        return;
    }
    std::string text = what_ + ": the render target is not complete: " + status_text(status);
    const char* separator = "; attached: ";
    for (const auto& [point, attachment] : attachments_) {
        text += separator + attachment;
        separator = ", ";
    }
    throw DeviceError(text + "; this is a fault of Penumbra or of the driver, please report it");
}

void RenderTarget::bind() {
    if (!checked_) {
        check_complete();
        checked_ = true;
    }
    glBindFramebuffer(GL_FRAMEBUFFER, name());
    glViewport(0, 0, width_, height_);
}

void RenderTarget::clear_colour(int slot, const glm::vec4& value) {
    glClearNamedFramebufferfv(name(), GL_COLOR, slot, glm::value_ptr(value));
}

void RenderTarget::clear_colour(int slot, const glm::ivec4& value) {
    glClearNamedFramebufferiv(name(), GL_COLOR, slot, glm::value_ptr(value));
}

void RenderTarget::clear_colour(int slot, const glm::uvec4& value) {
    glClearNamedFramebufferuiv(name(), GL_COLOR, slot, glm::value_ptr(value));
}

void RenderTarget::clear_depth(float value) {
    glClearNamedFramebufferfv(name(), GL_DEPTH, 0, &value);
}

void RenderTarget::clear_depth_stencil(float depth, int stencil) {
    glClearNamedFramebufferfi(name(), GL_DEPTH_STENCIL, 0, depth, stencil);
}

}  // namespace penumbra
