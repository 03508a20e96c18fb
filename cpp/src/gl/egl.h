#pragma once

#include <glad/egl.h>

#include <string>
#include <vector>

#include "gl/device.h"

namespace penumbra::egl {

/// Opens libEGL once for the process and fills glad's EGL table. Never closed again: drivers keep threads and
/// thread-local state that do not survive it.
/// @throws DeviceError with what to install
void load(const DeviceOptions& options);

/// One way to reach a device. Made by enumerate(); displays stay initialised until the process ends.
struct Candidate {
    EGLDeviceEXT device = nullptr;  ///< nullptr: Mesa's surfaceless platform
    std::string name;
    std::string drm_path;
    bool software = false;
};

/// Devices in the driver's order; where none can be listed, Mesa's surfaceless platform alone. load() came first.
[[nodiscard]] std::vector<Candidate> enumerate();

/// A context that nothing else knows of. Ends only by destroy().
struct RawContext {
    EGLDisplay display = EGL_NO_DISPLAY;
    EGLContext context = EGL_NO_CONTEXT;
};

/// @throws DeviceError with the reason: which EGL call failed and how, which extension is missing
[[nodiscard]] RawContext create_context(const Candidate& candidate, bool debug);
/// @throws DeviceError
void make_current(const RawContext& raw);
/// Of this thread.
void release_current(const RawContext& raw) noexcept;
void destroy(RawContext& raw) noexcept;

/// Frees what EGL keeps for this thread; the last call before it ends.
void release_thread() noexcept;

/// Fills glad's OpenGL table, once for the process; a context is current.
/// @throws DeviceError if the driver gives less than OpenGL 4.5 core
void load_gl();

}  // namespace penumbra::egl
