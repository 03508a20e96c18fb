#include "reference/embree_library.h"

#include <dlfcn.h>

#include <cstdlib>
#include <mutex>

#include "base/parallel.h"
#include "penumbra/error.h"

namespace penumbra::embree {
namespace {

constexpr const char* kFileName = "penumbra_embree.so";

/// The folder of the shared object (or program) that this function was linked into, with a slash, or empty.
std::string own_folder() {
    static const int anchor = 0;
    Dl_info info{};
    if (dladdr(&anchor, &info) == 0 || info.dli_fname == nullptr) {
        return {};
    }
    const std::string file = info.dli_fname;
    const std::size_t slash = file.rfind('/');
    return slash == std::string::npos ? std::string{} : file.substr(0, slash + 1);
}

std::string plugin_path() {
    const char* chosen = std::getenv("PENUMBRA_EMBREE");
    if (chosen != nullptr && *chosen != '\0') {
        return chosen;
    }
    return own_folder() + kFileName;
}

const Table* open_library() {
    // RTLD_DEEPBIND puts the plugin's own Embree before one that the host program made global. AddressSanitizer
    // refuses the flag, and a sanitised build never runs inside such a host.
    int flags = RTLD_NOW | RTLD_LOCAL;
#ifndef PENUMBRA_SANITIZED
    flags |= RTLD_DEEPBIND;
#endif
    const std::string path = plugin_path();
    void* handle = dlopen(path.c_str(), flags);
    if (handle == nullptr) {
        const char* reason = dlerror();
        throw DeviceError("ray tracing: cannot open " + path + " (" + (reason != nullptr ? reason : "no reason given") +
                          "); reinstall penumbra-core, or name the file in PENUMBRA_EMBREE");
    }
    const auto function = reinterpret_cast<TableFunction>(dlsym(handle, kTableSymbol));
    const Table* table = function != nullptr ? function() : nullptr;
    if (table == nullptr || table->table_version != kTableVersion) {
        dlclose(handle);
        throw DeviceError("ray tracing: " + path +
                          " was built for another version of Penumbra; reinstall penumbra-core, or correct "
                          "PENUMBRA_EMBREE");
    }
    return table;
}

std::string to_text(int version) {
    return std::to_string(version / 10000) + "." + std::to_string(version / 100 % 100) + "." +
           std::to_string(version % 100);
}

Device* open_device() {
    const Table& embree = library();
    const std::string config = "threads=" + std::to_string(thread_count());
    Device* device = embree.new_device(config.c_str());
    if (device == nullptr) {
        throw_if_failed("starting Embree");
        throw DeviceError("ray tracing: Embree " + to_text(embree.compiled_version) +
                          " does not start on this machine");
    }
    // Another generation would read our rays at wrong offsets: the very trap that the plugin exists for.
    const int loaded = embree.loaded_version(device);
    if (loaded / 10000 != embree.compiled_version / 10000) {
        embree.release_device(device);
        throw DeviceError("ray tracing: built for Embree " + to_text(embree.compiled_version) + " but Embree " +
                          to_text(loaded) + " answers, loaded by the host program; name another " + kFileName +
                          " in PENUMBRA_EMBREE");
    }
    return device;
}

std::mutex opening;
const Table* the_table = nullptr;
Device* the_device = nullptr;

}  // namespace

const Table& library() {
    const std::scoped_lock lock{opening};
    if (the_table == nullptr) {
        the_table = open_library();
    }
    return *the_table;
}

Device* device() {
    static_cast<void>(library());
    static std::mutex making;
    const std::scoped_lock lock{making};
    if (the_device == nullptr) {
        the_device = open_device();
    }
    return the_device;
}

std::string version() {
    Device* const shared = device();
    return to_text(library().loaded_version(shared));
}

void throw_if_failed(const char* what) {
    const std::string subject = std::string{"ray tracing: "} + what;
    // the_device is null while it is being made: Embree then reports the error of the failed rtcNewDevice.
    switch (library().take_status(the_device)) {
        case Status::Ok:
            return;
        case Status::Cancelled:
            throw Cancelled{};
        case Status::OutOfMemory:
            throw OutOfMemory(subject + " needs more memory than is free; close other programs or simplify the meshes");
        case Status::UnsupportedCpu:
            throw DeviceError(subject + " failed because this processor lacks what Embree needs (SSE2 or newer)");
        case Status::Failed:
            break;
    }
    throw DeviceError(subject + " failed inside Embree " + to_text(library().compiled_version));
}

}  // namespace penumbra::embree
