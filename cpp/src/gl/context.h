#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "gl/device.h"

namespace penumbra {

/// Limits of the driver that our code meets.
struct DeviceLimits {
    int max_texture_size_px = 0;   ///< 2D and 2D array, each side
    int max_cube_map_size_px = 0;  ///< each side of a face
    int max_array_layers = 0;
    int max_viewports = 0;
    std::int64_t max_storage_bytes = 0;  ///< one shader storage block
};

/// Extensions beyond OpenGL 4.5 core that a pass may use if present.
struct DeviceExtensions {
    bool shader_stencil_export = false;        ///< GL_ARB_shader_stencil_export
    bool shader_viewport_layer_array = false;  ///< GL_ARB_shader_viewport_layer_array: gl_Layer in vertex shaders
    bool texture_filter_minmax = false;        ///< GL_ARB_texture_filter_minmax or the EXT
    bool depth_bounds_test = false;            ///< GL_EXT_depth_bounds_test
    bool conservative_raster = false;          ///< GL_NV_conservative_raster
    bool seamless_cubemap_per_texture = false;
};

/// An OpenGL 4.5 core context without a window, current on the thread that made it until it is destroyed there.
/// It saves and restores nothing: the thread is meant to be ours alone (see RenderThread).
///
/// EGL displays are shared by the whole process and not counted, so none is ever terminated: another Context, or
/// another library (Blender), may live on the same one. See docs/decisions/0002-opengl-through-egl.md.
class Context {
public:
    /// @throws DeviceError if there is no libEGL, no matching device or no OpenGL 4.5 core
    explicit Context(const DeviceOptions& options = {});
    ~Context();
    Context(const Context&) = delete;
    Context& operator=(const Context&) = delete;

    /// The one current on this thread, or nullptr. Contexts of other libraries do not count.
    [[nodiscard]] static Context* current() noexcept;
    void make_current();
    void release() noexcept;

    [[nodiscard]] const DeviceInfo& info() const noexcept;
    [[nodiscard]] const DeviceLimits& limits() const noexcept;
    [[nodiscard]] const DeviceExtensions& extensions() const noexcept;
    /// All extension names, sorted.
    [[nodiscard]] const std::vector<std::string>& extension_names() const noexcept;
    [[nodiscard]] bool debug() const noexcept;
    /// Free memory on the device where the driver tells (NVIDIA, AMD).
    [[nodiscard]] std::optional<std::int64_t> free_memory_bytes() const;

    /// Turns what OpenGL has complained of since the last check into an exception.
    /// @param what the step that just ran, for the message: "depth map, face +x"
    /// @throws OutOfMemory for GL_OUT_OF_MEMORY, DeviceError for any other error, driver message or a lost context
    void check(std::string_view what);
    /// Forgets errors and driver messages, after an exception of another kind.
    void discard_errors() noexcept;

    /// True once the driver has reset the context; everything on it is gone and stays gone.
    [[nodiscard]] bool lost() const noexcept;
    /// @throws DeviceError with the reason if lost
    void throw_if_lost() const;
    /// For check() and for tests that play a lost context.
    void mark_lost(std::string reason);

private:
    struct State;
    std::unique_ptr<State> state_;
};

/// Context::current()->check(what). Cheap; called at the end of every step, in release builds too.
void check_gl(std::string_view what);

}  // namespace penumbra
