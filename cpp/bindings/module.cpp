#include "bindings.h"

namespace {

namespace py = pybind11;

/// Scene.__new__(Scene) has a C++ object only once __init__ has run. pybind11 would hand uninitialised memory of that
/// size to whatever takes it, for constructors of an older style, of which there are none here: refused instead.
void refuse_objects_without_init(const py::module_& m) {
    for (const auto& [name, value] : m.attr("__dict__").cast<py::dict>()) {
        if (!py::isinstance<py::type>(value)) {
            continue;
        }
        if (auto* const bound = py::detail::get_type_info(reinterpret_cast<PyTypeObject*>(value.ptr()))) {
            bound->operator_new = [](std::size_t) -> void* {
                throw py::type_error("an object is used that __new__ made and __init__ never filled; call its class");
            };
        }
    }
}

}  // namespace

PYBIND11_MODULE(_core, m) {
    m.doc() = "Penumbra's core: soft-shadow techniques, their reference and their measures. Forwards to C++.";
    penumbra::bindings::bind_errors(m);
    penumbra::bindings::bind_scene(m);
    penumbra::bindings::bind_techniques(m);
    penumbra::bindings::bind_measure(m);
    penumbra::bindings::bind_renderer(m);
    refuse_objects_without_init(m);
}
