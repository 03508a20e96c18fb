#include "gl/context.h"

#include <algorithm>
#include <array>
#include <cstdlib>

#include "gl/egl.h"
#include "gl/gl.h"
#include "gl/handles.h"
#include "gl/probe.h"
#include "penumbra/error.h"

namespace penumbra {
namespace {

thread_local Context* current_context = nullptr;

// Debug builds listen to the driver always; PENUMBRA_GL_DEBUG=0 silences it, =1 makes a release build listen.
bool listens_by_default() {
    const char* value = std::getenv("PENUMBRA_GL_DEBUG");
    if (value != nullptr && *value != '\0') {
        return std::string_view(value) != "0";
    }
#ifdef PENUMBRA_DEBUG
    return true;
#else
    return false;
#endif
}

std::string wanted_device(const DeviceOptions& options) {
    if (!options.device.empty()) {
        return options.device;
    }
    const char* value = std::getenv("PENUMBRA_DEVICE");
    return value == nullptr ? std::string() : std::string(value);
}

int get_int(GLenum name) {
    GLint value = 0;
    glGetIntegerv(name, &value);
    return value;
}

std::string error_name(GLenum error) {
    switch (error) {
        case GL_INVALID_ENUM:
            return "GL_INVALID_ENUM";
        case GL_INVALID_VALUE:
            return "GL_INVALID_VALUE";
        case GL_INVALID_OPERATION:
            return "GL_INVALID_OPERATION";
        case GL_INVALID_FRAMEBUFFER_OPERATION:
            return "GL_INVALID_FRAMEBUFFER_OPERATION";
        case GL_OUT_OF_MEMORY:
            return "GL_OUT_OF_MEMORY";
        case GL_STACK_OVERFLOW:
            return "GL_STACK_OVERFLOW";
        case GL_STACK_UNDERFLOW:
            return "GL_STACK_UNDERFLOW";
        case GL_CONTEXT_LOST:
            return "GL_CONTEXT_LOST";
        default:
            return "OpenGL error " + std::to_string(error);
    }
}

// A lost context answers GL_CONTEXT_LOST for ever, so that "until there is none" would not end.
constexpr int kMostErrors = 32;

}  // namespace

namespace detail {
bool has_current_context() noexcept {
    return current_context != nullptr;
}
}  // namespace detail

struct Context::State {
    egl::RawContext raw;
    DeviceInfo info;
    DeviceLimits limits;
    DeviceExtensions extensions;
    std::vector<std::string> names;
    bool debug = false;
    bool reports_resets = false;
    std::string lost_because;           // empty: not lost
    std::vector<std::string> messages;  // from the driver, since the last check

    [[nodiscard]] bool has(std::string_view extension) const { return std::ranges::binary_search(names, extension); }
    void read_names() {
        const int count = get_int(GL_NUM_EXTENSIONS);
        for (int i = 0; i < count; ++i) {
            names.emplace_back(reinterpret_cast<const char*>(glGetStringi(GL_EXTENSIONS, static_cast<GLuint>(i))));
        }
        std::ranges::sort(names);
    }
    void read_limits() {
        limits.max_texture_size_px = get_int(GL_MAX_TEXTURE_SIZE);
        limits.max_cube_map_size_px = get_int(GL_MAX_CUBE_MAP_TEXTURE_SIZE);
        limits.max_array_layers = get_int(GL_MAX_ARRAY_TEXTURE_LAYERS);
        limits.max_viewports = get_int(GL_MAX_VIEWPORTS);
        GLint64 storage = 0;
        glGetInteger64v(GL_MAX_SHADER_STORAGE_BLOCK_SIZE, &storage);
        limits.max_storage_bytes = storage;
    }
    void read_extensions() {
        extensions.shader_stencil_export = has("GL_ARB_shader_stencil_export");
        extensions.shader_viewport_layer_array = has("GL_ARB_shader_viewport_layer_array");
        extensions.texture_filter_minmax = has("GL_ARB_texture_filter_minmax") || has("GL_EXT_texture_filter_minmax");
        extensions.depth_bounds_test = has("GL_EXT_depth_bounds_test");
        extensions.conservative_raster = has("GL_NV_conservative_raster");
        extensions.seamless_cubemap_per_texture = has("GL_ARB_seamless_cubemap_per_texture");
    }

    static void GLAD_API_PTR on_message(GLenum /*source*/, GLenum type, GLuint /*id*/, GLenum severity, GLsizei length,
                                        const GLchar* message, const void* user) {
        const bool bad = type == GL_DEBUG_TYPE_ERROR || type == GL_DEBUG_TYPE_UNDEFINED_BEHAVIOR ||
                         severity == GL_DEBUG_SEVERITY_HIGH || severity == GL_DEBUG_SEVERITY_MEDIUM;
        // Advice on speed is not an error, however loud; nor is our own annotation.
        if (!bad || type == GL_DEBUG_TYPE_PERFORMANCE) {
            return;
        }
        // NOLINTNEXTLINE(cppcoreguidelines-pro-type-const-cast): OpenGL adds the const; a State was registered
        auto& state = *static_cast<State*>(const_cast<void*>(user));
        if (state.messages.size() < static_cast<std::size_t>(kMostErrors)) {
            state.messages.emplace_back(
                message, length < 0 ? std::string_view(message).size() : static_cast<std::size_t>(length));
        }
    }
    void listen() {
        glEnable(GL_DEBUG_OUTPUT);
        glEnable(GL_DEBUG_OUTPUT_SYNCHRONOUS);  // so that a debugger stops at the call that did it
        glDebugMessageCallback(&State::on_message, this);
    }
};

Context::Context(const DeviceOptions& options) : state_(std::make_unique<State>()) {
    egl::load(options);
    const std::vector<egl::Candidate> candidates = egl::enumerate();
    std::vector<DeviceInfo> devices = probe_devices(candidates);
    const std::size_t chosen = choose_device(devices, wanted_device(options));

    State& state = *state_;
    state.debug = options.debug || listens_by_default();
    state.info = std::move(devices[chosen]);
    try {
        state.raw = egl::create_context(candidates[chosen], state.debug);
        make_current();
        state.read_names();
        state.read_limits();
        state.read_extensions();
        GLint strategy = GL_NO_RESET_NOTIFICATION;
        glGetIntegerv(GL_RESET_NOTIFICATION_STRATEGY, &strategy);
        state.reports_resets = strategy == GL_LOSE_CONTEXT_ON_RESET;
        // Rows of an image lie without gaps on our side of the border.
        glPixelStorei(GL_PACK_ALIGNMENT, 1);
        glPixelStorei(GL_UNPACK_ALIGNMENT, 1);
        glEnable(GL_TEXTURE_CUBE_MAP_SEAMLESS);
        discard_errors();
        if (state.debug) {
            state.listen();
        }
    } catch (const DeviceError& error) {
        release();
        egl::destroy(state.raw);
        throw DeviceError("device " + describe(state.info) + ": " + error.what());
    }
}

Context::~Context() {
    if (current_context == this) {
        if (state_->debug) {
            glDebugMessageCallback(nullptr, nullptr);
        }
        release();
    }
    egl::destroy(state_->raw);
}

Context* Context::current() noexcept {
    return current_context;
}

void Context::make_current() {
    egl::make_current(state_->raw);
    current_context = this;
}

void Context::release() noexcept {
    if (current_context == this) {
        egl::release_current(state_->raw);
        current_context = nullptr;
    }
}

const DeviceInfo& Context::info() const noexcept {
    return state_->info;
}
const DeviceLimits& Context::limits() const noexcept {
    return state_->limits;
}
const DeviceExtensions& Context::extensions() const noexcept {
    return state_->extensions;
}
const std::vector<std::string>& Context::extension_names() const noexcept {
    return state_->names;
}
bool Context::debug() const noexcept {
    return state_->debug;
}

std::optional<std::int64_t> Context::free_memory_bytes() const {
    constexpr std::int64_t kKibibyte = 1024;
    if (state_->has("GL_NVX_gpu_memory_info")) {
        return get_int(GL_GPU_MEMORY_INFO_CURRENT_AVAILABLE_VIDMEM_NVX) * kKibibyte;
    }
    if (state_->has("GL_ATI_meminfo")) {
        std::array<GLint, 4> free_kib{};  // total free, largest free block, and the same for auxiliary memory
        glGetIntegerv(GL_TEXTURE_FREE_MEMORY_ATI, free_kib.data());
        return free_kib[0] * kKibibyte;
    }
    return std::nullopt;
}

void Context::check(std::string_view what) {
    PENUMBRA_ASSERT(current_context == this);
    throw_if_lost();
    State& state = *state_;
    const std::string step(what);
    if (state.reports_resets) {
        switch (glGetGraphicsResetStatus()) {
            case GL_NO_ERROR:
                break;
            case GL_GUILTY_CONTEXT_RESET:
                mark_lost("the graphics driver reset during \"" + step +
                          "\", probably because the work took too long; try a smaller image or fewer samples");
                break;
            case GL_INNOCENT_CONTEXT_RESET:
                mark_lost("the graphics driver was reset by another program during \"" + step + "\"; render again");
                break;
            default:
                mark_lost("the graphics driver was reset during \"" + step + "\"; render again");
                break;
        }
        throw_if_lost();
    }

    std::string errors;
    bool out_of_memory = false;
    for (int i = 0; i < kMostErrors; ++i) {
        const GLenum error = glGetError();
        if (error == GL_NO_ERROR) {
            break;
        }
        if (error == GL_CONTEXT_LOST) {
            mark_lost("the OpenGL context was lost during \"" + step + "\"; render again");
            throw_if_lost();
        }
        out_of_memory = out_of_memory || error == GL_OUT_OF_MEMORY;
        errors += (errors.empty() ? "" : ", ") + error_name(error);
    }
    for (const std::string& message : state.messages) {
        errors += (errors.empty() ? "" : "; ") + message;
    }
    state.messages.clear();
    if (out_of_memory) {
        throw OutOfMemory(step + ": " + state.info.name +
                          " is out of memory; use a smaller image, smaller maps or fewer samples");
    }
    if (!errors.empty()) {
        throw DeviceError(step + ": OpenGL reports " + errors + " on " + state.info.name +
                          "; this is a fault of Penumbra or of the driver, please report it");
    }
}

void Context::discard_errors() noexcept {
    for (int i = 0; i < kMostErrors && glGetError() != GL_NO_ERROR; ++i) {
    }
    state_->messages.clear();
}

bool Context::lost() const noexcept {
    return !state_->lost_because.empty();
}

void Context::throw_if_lost() const {
    if (lost()) {
        throw DeviceError(state_->lost_because);
    }
}

void Context::mark_lost(std::string reason) {
    state_->lost_because = std::move(reason);
}

void check_gl(std::string_view what) {
    Context* context = Context::current();
    PENUMBRA_ASSERT(context != nullptr);
    if (context != nullptr) {
        context->check(what);
    }
}

}  // namespace penumbra
