#pragma once

#include <pybind11/pybind11.h>

#include <chrono>
#include <future>
#include <string>

#include "penumbra/control.h"

namespace penumbra::bindings {

/// Runs `work(Control&)` on a thread of its own with the GIL released, and meanwhile hears Ctrl-C and tells
/// `progress(fraction, text)` about ten times a second. An exception of either cancels the work.
template <class Work>
auto wait_for(const Work& work, const pybind11::object& progress, const std::string& text) {
    namespace py = pybind11;
    Control control;
    auto future = std::async(std::launch::async, [&] { return work(control); });
    const auto stop = [&] {
        control.cancel();
        const py::gil_scoped_release release;
        future.wait();
    };
    for (;;) {
        {
            const py::gil_scoped_release release;
            if (future.wait_for(std::chrono::milliseconds(100)) == std::future_status::ready) {
                break;
            }
        }
        try {
            if (PyErr_CheckSignals() != 0) {
                throw py::error_already_set();
            }
            if (!progress.is_none()) {
                progress(control.progress(), text);
            }
        } catch (py::error_already_set&) {
            stop();
            throw;
        }
    }
    return future.get();
}

}  // namespace penumbra::bindings
