#pragma once

#include <string>

#include "reference/embree_table.h"

namespace penumbra::embree {

/// Opens the plugin on the first call and keeps it until the process ends. Looks for `penumbra_embree.so` beside the
/// object that holds this code; the environment variable PENUMBRA_EMBREE names another file.
/// @throws DeviceError if it cannot be opened; a later call tries again.
[[nodiscard]] const Table& library();

/// The device all scenes share; made on the first call with thread_count() build threads, kept like the library.
/// @throws DeviceError, OutOfMemory
[[nodiscard]] Device* device();

/// "3.13.5": the version of the library that really answers, not of the headers. @throws like device()
[[nodiscard]] std::string version();

/// Turns the last failed call of this thread into an exception that starts with `what`; does nothing if none failed.
/// @throws OutOfMemory, Cancelled, DeviceError
void throw_if_failed(const char* what);

}  // namespace penumbra::embree
