#pragma once

#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace penumbra {

/// One EGL device as a user sees it.
struct DeviceInfo {
    int index = 0;           ///< what PENUMBRA_DEVICE takes
    std::string name;        ///< GL_RENDERER; the EGL device's name where no context could be made
    std::string vendor;      ///< GL_VENDOR
    std::string gl_version;  ///< GL_VERSION
    bool software = false;   ///< renders on the CPU
    bool usable = false;     ///< gives an OpenGL 4.5 core context without a window
    std::string reason;      ///< one sentence: why it is not usable; empty if it is
    std::string drm_path;    ///< "/dev/dri/renderD128", empty where there is none
};

struct DeviceOptions {
    /// Index of a device or part of its name, whatever the case. Empty: the environment variable PENUMBRA_DEVICE; where
    /// that is empty too, the first usable hardware device, else the first usable software one.
    std::string device;
    /// Driver messages of high and medium severity become a DeviceError at the next check. Always so in debug builds,
    /// unless the environment variable PENUMBRA_GL_DEBUG is 0; 1 switches it on in release builds too. Slower.
    bool debug = false;
    /// Opened at run time. Empty: the environment variable PENUMBRA_EGL_LIBRARY, else "libEGL.so.1".
    std::string egl_library;
};

/// All EGL devices, each probed with a context of its own on a thread of its own; the caller's current context stays.
/// Never throws: without libEGL or without a device the list is empty, and `problem` (if given) says why.
[[nodiscard]] std::vector<DeviceInfo> list_devices(const DeviceOptions& options = {},
                                                   std::string* problem = nullptr) noexcept;

/// @param wanted as DeviceOptions::device, empty for the default choice; the environment is not looked at
/// @return index into `devices`
/// @throws DeviceError if nothing matches or what matches is not usable; the message lists the devices
[[nodiscard]] std::size_t choose_device(std::span<const DeviceInfo> devices, std::string_view wanted);

/// "0: llvmpipe (LLVM 15.0.6, 256 bits), OpenGL 4.5, software"; one line per device, for messages and `doctor`.
[[nodiscard]] std::string describe(const DeviceInfo& device);

}  // namespace penumbra
