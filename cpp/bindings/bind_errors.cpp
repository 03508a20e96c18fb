#include "bindings.h"
#include "penumbra/error.h"

namespace penumbra::bindings {

void bind_errors(pybind11::module_& m) {
    namespace py = pybind11;
    // The base first: translators are tried in reverse order of registration.
    const auto error = py::register_exception<Error>(m, "Error", PyExc_RuntimeError);
    py::register_exception<InvalidScene>(m, "InvalidScene", error);
    py::register_exception<InvalidSettings>(m, "InvalidSettings", error);
    py::register_exception<DeviceError>(m, "DeviceError", error);
    py::register_exception<OutOfMemory>(m, "OutOfMemory", error);
    py::register_exception<Cancelled>(m, "Cancelled", error);
}

}  // namespace penumbra::bindings
