#include "bindings.h"

PYBIND11_MODULE(_core, m) {
    m.doc() = "Penumbra's core: soft-shadow techniques, their reference and their measures. Forwards to C++.";
    penumbra::bindings::bind_errors(m);
    penumbra::bindings::bind_scene(m);
    penumbra::bindings::bind_techniques(m);
    penumbra::bindings::bind_measure(m);
    penumbra::bindings::bind_renderer(m);
}
