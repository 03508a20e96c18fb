#pragma once

#include <atomic>
#include <utility>

#include "base/assert.h"
#include "gl/gl.h"

namespace penumbra {

namespace detail {
/// Names that live in the whole process, all kinds together.
inline std::atomic<long> live_handles{0};
/// False on a thread without a current Context: a name that dies there is a bug of ours.
[[nodiscard]] bool has_current_context() noexcept;
}  // namespace detail

/// Number of OpenGL names owned by handles in this process; tests prove that it returns to where it was.
[[nodiscard]] inline long live_handle_count() noexcept {
    return detail::live_handles.load(std::memory_order_relaxed);
}

/// Sole owner of one OpenGL name; 0 means none. Movable, never copied. Lives and dies on its render thread.
/// A default-made handle owns nothing, so that a technique can hold it before prepare().
template <class Traits>
class Handle {
public:
    Handle() noexcept = default;
    /// Makes the object (direct state access: it exists at once, nothing is bound).
    /// Arguments: Texture the target or none, Query the target, ShaderObject the stage, others none.
    template <class... Args>
    [[nodiscard]] static Handle create(Args... args) {
        PENUMBRA_ASSERT(detail::has_current_context());
        Handle handle;
        handle.name_ = Traits::create(args...);
        detail::live_handles.fetch_add(1, std::memory_order_relaxed);
        return handle;
    }
    Handle(Handle&& other) noexcept : name_{std::exchange(other.name_, 0U)} {}
    Handle& operator=(Handle&& other) noexcept {
        if (this != &other) {
            reset();
            name_ = std::exchange(other.name_, 0U);
        }
        return *this;
    }
    Handle(const Handle&) = delete;
    Handle& operator=(const Handle&) = delete;
    ~Handle() { reset(); }

    void reset() noexcept {
        if (name_ != 0U) {
            PENUMBRA_ASSERT(detail::has_current_context());
            Traits::destroy(name_);
            detail::live_handles.fetch_sub(1, std::memory_order_relaxed);
            name_ = 0U;
        }
    }
    [[nodiscard]] GLuint name() const noexcept { return name_; }
    [[nodiscard]] explicit operator bool() const noexcept { return name_ != 0U; }

private:
    GLuint name_ = 0U;
};

struct BufferTraits {
    static GLuint create();
    static void destroy(GLuint name) noexcept;
};
struct TextureTraits {
    static GLuint create(GLenum target);
    static GLuint create();  ///< a name alone, for a view to take shape in
    static void destroy(GLuint name) noexcept;
};
struct FramebufferTraits {
    static GLuint create();
    static void destroy(GLuint name) noexcept;
};
struct VertexArrayTraits {
    static GLuint create();
    static void destroy(GLuint name) noexcept;
};
struct ProgramTraits {
    static GLuint create();
    static void destroy(GLuint name) noexcept;
};
struct ShaderTraits {
    static GLuint create(GLenum stage);
    static void destroy(GLuint name) noexcept;
};
struct QueryTraits {
    static GLuint create(GLenum target);
    static void destroy(GLuint name) noexcept;
};
struct SamplerTraits {
    static GLuint create();
    static void destroy(GLuint name) noexcept;
};

using Buffer = Handle<BufferTraits>;
using Texture = Handle<TextureTraits>;
using Framebuffer = Handle<FramebufferTraits>;
using VertexArray = Handle<VertexArrayTraits>;
using ProgramObject = Handle<ProgramTraits>;
using ShaderObject = Handle<ShaderTraits>;
using Query = Handle<QueryTraits>;
using Sampler = Handle<SamplerTraits>;

}  // namespace penumbra
