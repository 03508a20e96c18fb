#include "gl/device.h"

#include <algorithm>
#include <cctype>
#include <charconv>
#include <optional>
#include <thread>

#include "gl/egl.h"
#include "gl/gl.h"
#include "gl/probe.h"
#include "gl/workarounds.h"
#include "penumbra/error.h"

namespace penumbra {
namespace {

std::string gl_string(GLenum name) {
    const GLubyte* value = glGetString(name);
    return value == nullptr ? std::string() : std::string(reinterpret_cast<const char*>(value));
}

std::string lower(std::string_view text) {
    std::string result(text);
    std::ranges::transform(result, result.begin(), [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
    return result;
}

std::optional<std::size_t> as_index(std::string_view text) {
    std::size_t value = 0;
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
    if (error != std::errc() || end != text.data() + text.size()) {
        return std::nullopt;
    }
    return value;
}

std::string listing(std::span<const DeviceInfo> devices) {
    if (devices.empty()) {
        return "there is no device";
    }
    std::string text = "there is";
    for (const DeviceInfo& device : devices) {
        text += (device.index == 0 ? " " : "; ") + describe(device);
    }
    return text;
}

}  // namespace

void read_info(DeviceInfo& info) {
    info.name = gl_string(GL_RENDERER);
    info.vendor = gl_string(GL_VENDOR);
    info.gl_version = gl_string(GL_VERSION);
    info.software = info.software || is_software_renderer(info.name);
    info.usable = true;
    info.reason.clear();
}

std::vector<DeviceInfo> probe_devices(const std::vector<egl::Candidate>& candidates) {
    std::vector<DeviceInfo> devices;
    for (const egl::Candidate& candidate : candidates) {
        DeviceInfo info;
        info.index = static_cast<int>(devices.size());
        info.name = candidate.name;
        info.software = candidate.software;
        info.drm_path = candidate.drm_path;
        egl::RawContext raw;
        try {
            raw = egl::create_context(candidate, false);
            egl::make_current(raw);
            egl::load_gl();
            read_info(info);
        } catch (const DeviceError& error) {
            info.reason = error.what();
        }
        if (raw.context != EGL_NO_CONTEXT) {
            egl::release_current(raw);
            egl::destroy(raw);
        }
        devices.push_back(std::move(info));
    }
    return devices;
}

std::vector<DeviceInfo> list_devices(const DeviceOptions& options, std::string* problem) noexcept {
    std::vector<DeviceInfo> devices;
    std::string why;
    try {
        std::thread probe([&] {
            try {
                egl::load(options);
                devices = probe_devices(egl::enumerate());
                if (devices.empty()) {
                    why = kNoDevice;
                }
            } catch (const std::exception& error) {
                why = error.what();
            }
            egl::release_thread();
        });
        probe.join();
    } catch (const std::exception& error) {
        why = error.what();
    }
    if (problem != nullptr) {
        *problem = why;
    }
    return devices;
}

std::size_t choose_device(std::span<const DeviceInfo> devices, std::string_view wanted) {
    if (devices.empty()) {
        throw DeviceError(kNoDevice);
    }
    if (wanted.empty()) {
        const auto usable_kind = [&](bool software) {
            return std::ranges::find_if(devices,
                                        [&](const DeviceInfo& d) { return d.usable && d.software == software; });
        };
        auto found = usable_kind(false);
        if (found == devices.end()) {
            found = usable_kind(true);
        }
        if (found == devices.end()) {
            throw DeviceError("no device gives an OpenGL 4.5 core context without a window: " + listing(devices) +
                              "; install a driver (Debian, Ubuntu: apt install libegl1 libgl1-mesa-dri)");
        }
        return static_cast<std::size_t>(found - devices.begin());
    }

    std::optional<std::size_t> match;
    if (const auto index = as_index(wanted)) {
        if (*index < devices.size()) {
            match = index;
        }
    } else {
        const std::string part = lower(wanted);
        for (std::size_t i = 0; i < devices.size(); ++i) {
            if (lower(devices[i].name).find(part) == std::string::npos) {
                continue;
            }
            if (!match || (!devices[*match].usable && devices[i].usable)) {
                match = i;
            }
        }
    }
    if (!match) {
        throw DeviceError("no device matches \"" + std::string(wanted) +
                          "\" (an index or part of a name): " + listing(devices));
    }
    if (!devices[*match].usable) {
        throw DeviceError("device " + describe(devices[*match]) + "; choose another or none: " + listing(devices));
    }
    return *match;
}

std::string describe(const DeviceInfo& device) {
    std::string text = std::to_string(device.index) + ": " + device.name;
    if (!device.usable) {
        return text + ", not usable: " + device.reason;
    }
    text += ", OpenGL " + device.gl_version.substr(0, device.gl_version.find(' '));
    text += device.software ? ", software" : ", hardware";
    if (!device.drm_path.empty()) {
        text += ", " + device.drm_path;
    }
    return text;
}

}  // namespace penumbra
