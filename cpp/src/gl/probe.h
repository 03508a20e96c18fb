#pragma once

#include <vector>

#include "gl/device.h"
#include "gl/egl.h"

namespace penumbra {

inline constexpr const char* kNoDevice =
    "no OpenGL device: libEGL lists none; install a driver (Debian, Ubuntu: apt install libegl1 libgl1-mesa-dri)";

/// Makes a context on each and asks its name; changes what is current on this thread.
[[nodiscard]] std::vector<DeviceInfo> probe_devices(const std::vector<egl::Candidate>& candidates);

/// Fills name, vendor, version, software and usable from the current context.
void read_info(DeviceInfo& info);

}  // namespace penumbra
