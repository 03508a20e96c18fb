#pragma once

#include <pybind11/pybind11.h>

namespace penumbra::bindings {

void bind_errors(pybind11::module_& m);
void bind_scene(pybind11::module_& m);
void bind_techniques(pybind11::module_& m);
void bind_renderer(pybind11::module_& m);
void bind_measure(pybind11::module_& m);

}  // namespace penumbra::bindings
