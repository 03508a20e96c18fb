#include "gl/egl.h"

#include <dlfcn.h>

#include <array>
#include <cstdlib>
#include <mutex>
#include <string_view>

#include "gl/gl.h"
#include "penumbra/error.h"

namespace penumbra::egl {
namespace {

constexpr const char* kDefaultLibrary = "libEGL.so.1";

using GetProcAddress = GLADapiproc (*)(const char*);
void* library = nullptr;  // guarded by load()'s mutex until set, then read only
GetProcAddress get_proc_address = nullptr;

std::string library_name(const DeviceOptions& options) {
    if (!options.egl_library.empty()) {
        return options.egl_library;
    }
    const char* from_environment = std::getenv("PENUMBRA_EGL_LIBRARY");
    return from_environment != nullptr && *from_environment != '\0' ? from_environment : kDefaultLibrary;
}

EGLDisplay no_display(EGLNativeDisplayType /*native*/) {
    return EGL_NO_DISPLAY;
}
EGLDisplay no_current_display() {
    return EGL_NO_DISPLAY;
}

// EGL functions themselves come from the library: eglGetProcAddress may refuse core ones before EGL 1.5.
GLADapiproc find_egl_function(const char* name) {
    if (void* symbol = dlsym(library, name)) {
        return reinterpret_cast<GLADapiproc>(symbol);
    }
    return get_proc_address(name);
}

// glad asks the default display for the version, which may connect to an X server and tells nothing before it is
// initialised. Without a display it asks the library itself, which is what is wanted here.
GLADapiproc find_egl_function_for_glad(const char* name) {
    const std::string_view wanted = name;
    if (wanted == "eglGetDisplay") {
        return reinterpret_cast<GLADapiproc>(&no_display);
    }
    if (wanted == "eglGetCurrentDisplay") {
        return reinterpret_cast<GLADapiproc>(&no_current_display);
    }
    return find_egl_function(name);
}

GLADapiproc find_gl_function(const char* name) {
    return get_proc_address(name);
}

bool has(const char* names, std::string_view extension) {
    if (names == nullptr) {
        return false;
    }
    std::string_view rest = names;
    while (!rest.empty()) {
        const std::size_t space = rest.find(' ');
        if (rest.substr(0, space) == extension) {
            return true;
        }
        if (space == std::string_view::npos) {
            break;
        }
        rest.remove_prefix(space + 1);
    }
    return false;
}

std::string error_name(EGLint error) {
    switch (error) {
        case EGL_SUCCESS:
            return "no EGL error";
        case EGL_NOT_INITIALIZED:
            return "EGL_NOT_INITIALIZED";
        case EGL_BAD_ACCESS:
            return "EGL_BAD_ACCESS";
        case EGL_BAD_ALLOC:
            return "EGL_BAD_ALLOC";
        case EGL_BAD_ATTRIBUTE:
            return "EGL_BAD_ATTRIBUTE";
        case EGL_BAD_CONFIG:
            return "EGL_BAD_CONFIG";
        case EGL_BAD_CONTEXT:
            return "EGL_BAD_CONTEXT";
        case EGL_BAD_DISPLAY:
            return "EGL_BAD_DISPLAY";
        case EGL_BAD_MATCH:
            return "EGL_BAD_MATCH";
        case EGL_BAD_PARAMETER:
            return "EGL_BAD_PARAMETER";
        case EGL_BAD_DEVICE_EXT:
            return "EGL_BAD_DEVICE_EXT";
        case EGL_CONTEXT_LOST:
            return "EGL_CONTEXT_LOST";
        default:
            return "EGL error " + std::to_string(error);
    }
}

std::string text(const char* string) {
    return string == nullptr ? std::string() : std::string(string);
}

EGLDisplay get_display(const Candidate& candidate) {
    const EGLenum platform =
        candidate.device != nullptr ? EGL_PLATFORM_DEVICE_EXT : static_cast<EGLenum>(EGL_PLATFORM_SURFACELESS_MESA);
    void* native = candidate.device != nullptr ? static_cast<void*>(candidate.device) : EGL_DEFAULT_DISPLAY;
    return eglGetPlatformDisplay(platform, native, nullptr);
}

// Most drivers need no config for a context without surfaces.
EGLConfig choose_config(EGLDisplay display, const char* extensions) {
    if (has(extensions, "EGL_KHR_no_config_context") || has(extensions, "EGL_MESA_configless_context")) {
        return EGL_NO_CONFIG_KHR;
    }
    const std::array<EGLint, 5> wanted{EGL_RENDERABLE_TYPE, EGL_OPENGL_BIT, EGL_SURFACE_TYPE, EGL_PBUFFER_BIT,
                                       EGL_NONE};
    EGLConfig config = nullptr;
    EGLint count = 0;
    if (eglChooseConfig(display, wanted.data(), &config, 1, &count) == EGL_FALSE || count < 1) {
        throw DeviceError("the EGL display has no config that can render desktop OpenGL");
    }
    return config;
}

EGLContext try_context(EGLDisplay display, EGLConfig config, bool debug, bool robust) {
    std::vector<EGLint> attributes{EGL_CONTEXT_MAJOR_VERSION,       4,
                                   EGL_CONTEXT_MINOR_VERSION,       5,
                                   EGL_CONTEXT_OPENGL_PROFILE_MASK, EGL_CONTEXT_OPENGL_CORE_PROFILE_BIT};
    if (debug) {
        attributes.insert(attributes.end(), {EGL_CONTEXT_OPENGL_DEBUG, EGL_TRUE});
    }
    if (robust) {
        // Only the notice of a reset is wanted, not bounds checks on every access.
        attributes.insert(attributes.end(),
                          {EGL_CONTEXT_OPENGL_RESET_NOTIFICATION_STRATEGY, EGL_LOSE_CONTEXT_ON_RESET});
    }
    attributes.push_back(EGL_NONE);
    return eglCreateContext(display, config, EGL_NO_CONTEXT, attributes.data());
}

}  // namespace

void load(const DeviceOptions& options) {
    static std::mutex mutex;
    const std::scoped_lock lock(mutex);
    const std::string name = library_name(options);
    void* opened = dlopen(name.c_str(), RTLD_NOW | RTLD_LOCAL);
    if (opened == nullptr) {
        throw DeviceError("no OpenGL device: \"" + name +
                          "\" cannot be opened; install the graphics driver's EGL library (Debian, Ubuntu: apt install "
                          "libegl1 libgl1-mesa-dri)");
    }
    const auto found = reinterpret_cast<GetProcAddress>(dlsym(opened, "eglGetProcAddress"));
    if (found == nullptr) {
        throw DeviceError("no OpenGL device: \"" + name +
                          "\" is not an EGL library; unset PENUMBRA_EGL_LIBRARY or let it name libEGL.so.1");
    }
    if (library != nullptr) {
        return;  // one table for the process; the count that dlopen raised keeps the library where it is
    }
    library = opened;
    get_proc_address = found;
    if (gladLoadEGL(EGL_NO_DISPLAY, find_egl_function_for_glad) == 0 || GLAD_EGL_VERSION_1_5 == 0) {
        library = nullptr;
        throw DeviceError("no OpenGL device: \"" + name +
                          "\" is older than EGL 1.5; update the graphics driver (Debian, Ubuntu: apt install libegl1 "
                          "libgl1-mesa-dri)");
    }
    glad_eglGetDisplay = reinterpret_cast<PFNEGLGETDISPLAYPROC>(find_egl_function("eglGetDisplay"));
    glad_eglGetCurrentDisplay =
        reinterpret_cast<PFNEGLGETCURRENTDISPLAYPROC>(find_egl_function("eglGetCurrentDisplay"));
}

std::vector<Candidate> enumerate() {
    std::vector<Candidate> candidates;
    const char* client_extensions = eglQueryString(EGL_NO_DISPLAY, EGL_EXTENSIONS);
    if (eglQueryDevicesEXT != nullptr && has(client_extensions, "EGL_EXT_platform_device")) {
        EGLint count = 0;
        if (eglQueryDevicesEXT(0, nullptr, &count) == EGL_TRUE && count > 0) {
            std::vector<EGLDeviceEXT> devices(static_cast<std::size_t>(count));
            if (eglQueryDevicesEXT(count, devices.data(), &count) == EGL_TRUE) {
                devices.resize(static_cast<std::size_t>(count));
                for (EGLDeviceEXT device : devices) {
                    Candidate candidate;
                    candidate.device = device;
                    const char* extensions = eglQueryDeviceStringEXT(device, EGL_EXTENSIONS);
                    candidate.software = has(extensions, "EGL_MESA_device_software");
                    if (has(extensions, "EGL_EXT_device_drm_render_node")) {
                        candidate.drm_path = text(eglQueryDeviceStringEXT(device, EGL_DRM_RENDER_NODE_FILE_EXT));
                    }
                    if (candidate.drm_path.empty() && has(extensions, "EGL_EXT_device_drm")) {
                        candidate.drm_path = text(eglQueryDeviceStringEXT(device, EGL_DRM_DEVICE_FILE_EXT));
                    }
                    if (has(extensions, "EGL_EXT_device_query_name")) {
                        candidate.name = text(eglQueryDeviceStringEXT(device, EGL_RENDERER_EXT));
                    }
                    if (candidate.name.empty()) {
                        const std::string hardware = candidate.drm_path.empty() ? "EGL device" : candidate.drm_path;
                        candidate.name = candidate.software ? "software device" : hardware;
                    }
                    candidates.push_back(std::move(candidate));
                }
            }
        }
    }
    if (candidates.empty() && has(client_extensions, "EGL_MESA_platform_surfaceless")) {
        Candidate candidate;
        candidate.name = "Mesa surfaceless platform";
        candidates.push_back(std::move(candidate));
    }
    return candidates;
}

RawContext create_context(const Candidate& candidate, bool debug) {
    RawContext raw;
    raw.display = get_display(candidate);
    if (raw.display == EGL_NO_DISPLAY) {
        throw DeviceError("EGL gives no display for it (" + error_name(eglGetError()) + ")");
    }
    EGLint major = 0;
    EGLint minor = 0;
    // Every time: it does nothing on a display that is ready, and repairs one that somebody has terminated.
    if (eglInitialize(raw.display, &major, &minor) == EGL_FALSE) {
        throw DeviceError("its EGL display cannot be initialised (" + error_name(eglGetError()) +
                          "); is its driver installed and may this user open it?");
    }
    const char* extensions = eglQueryString(raw.display, EGL_EXTENSIONS);
    if (!has(extensions, "EGL_KHR_surfaceless_context")) {
        throw DeviceError("its driver lacks EGL_KHR_surfaceless_context");
    }
    if (eglBindAPI(EGL_OPENGL_API) == EGL_FALSE) {
        throw DeviceError("its driver has no desktop OpenGL (" + error_name(eglGetError()) + ")");
    }
    EGLConfig config = choose_config(raw.display, extensions);
    raw.context = try_context(raw.display, config, debug, true);
    if (raw.context == EGL_NO_CONTEXT) {
        raw.context = try_context(raw.display, config, debug, false);
    }
    if (raw.context == EGL_NO_CONTEXT) {
        throw DeviceError("its driver gives no OpenGL 4.5 core context (" + error_name(eglGetError()) + ")");
    }
    return raw;
}

void make_current(const RawContext& raw) {
    // The API is a setting of the thread; another library may have used it before.
    if (eglBindAPI(EGL_OPENGL_API) == EGL_FALSE ||
        eglMakeCurrent(raw.display, EGL_NO_SURFACE, EGL_NO_SURFACE, raw.context) == EGL_FALSE) {
        throw DeviceError("its context cannot be made current (" + error_name(eglGetError()) + ")");
    }
}

void release_current(const RawContext& raw) noexcept {
    eglMakeCurrent(raw.display, EGL_NO_SURFACE, EGL_NO_SURFACE, EGL_NO_CONTEXT);
}

void destroy(RawContext& raw) noexcept {
    if (raw.context != EGL_NO_CONTEXT) {
        eglDestroyContext(raw.display, raw.context);
        raw.context = EGL_NO_CONTEXT;
    }
}

void release_thread() noexcept {
    if (eglReleaseThread != nullptr) {
        eglReleaseThread();
    }
}

void load_gl() {
    // One table serves every device: libEGL hands out entry points that find the driver of the context that is current
    // on the calling thread. Filled once, so that no thread reads it while another writes.
    static std::mutex mutex;
    static bool loaded = false;
    const std::scoped_lock lock(mutex);
    if (loaded) {
        return;
    }
    const int version = gladLoadGL(find_gl_function);
    if (GLAD_VERSION_MAJOR(version) * 10 + GLAD_VERSION_MINOR(version) < 45) {
        throw DeviceError("its driver gives OpenGL " + std::to_string(GLAD_VERSION_MAJOR(version)) + "." +
                          std::to_string(GLAD_VERSION_MINOR(version)) + " where 4.5 is needed");
    }
    // glad skips extensions that this device lacks; the next one may have them (DeviceExtensions says which does).
    if (glad_glDepthBoundsEXT == nullptr) {
        glad_glDepthBoundsEXT = reinterpret_cast<PFNGLDEPTHBOUNDSEXTPROC>(find_gl_function("glDepthBoundsEXT"));
    }
    if (glad_glSubpixelPrecisionBiasNV == nullptr) {
        glad_glSubpixelPrecisionBiasNV =
            reinterpret_cast<PFNGLSUBPIXELPRECISIONBIASNVPROC>(find_gl_function("glSubpixelPrecisionBiasNV"));
    }
    loaded = true;
}

}  // namespace penumbra::egl
