#pragma once

#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>

#include <cstring>
#include <glm/glm.hpp>
#include <string>
#include <vector>

#include "penumbra/error.h"

namespace penumbra::bindings {

namespace py = pybind11;

template <class T>
using Array = py::array_t<T, py::array::c_style | py::array::forcecast>;

[[nodiscard]] std::string shape_text(const py::array& array);

/// Copies an (n, Width) array into a vector of GLM vectors with one memcpy.
/// @throws InvalidScene naming `what` and the shape found.
template <class Vector, class T, int Width>
std::vector<Vector> vectors_from(const Array<T>& array, const char* what) {
    static_assert(sizeof(Vector) == Width * sizeof(T));
    if (array.ndim() != 2 || array.shape(1) != Width) {
        throw InvalidScene(std::string{what} + " has shape " + shape_text(array) + ", but (n, " +
                           std::to_string(Width) + ") is needed; reshape the array");
    }
    std::vector<Vector> result(static_cast<std::size_t>(array.shape(0)));
    if (!result.empty()) {
        std::memcpy(result.data(), array.data(), result.size() * sizeof(Vector));
    }
    return result;
}

/// Hands a vector over to numpy without copying it: the array keeps it alive.
template <class T, class U>
py::array_t<T> array_from(std::vector<U>&& values, std::vector<py::ssize_t> shape) {
    auto* owned = new std::vector<U>(std::move(values));
    const py::capsule owner(owned, [](void* pointer) { delete static_cast<std::vector<U>*>(pointer); });
    return py::array_t<T>(std::move(shape), reinterpret_cast<const T*>(owned->data()), owner);
}

[[nodiscard]] glm::dmat4 matrix_from(const Array<double>& array, const char* what);
[[nodiscard]] py::array_t<double> matrix_to(const glm::dmat4& matrix);
[[nodiscard]] glm::dvec3 dvec3_from(const std::vector<double>& values, const char* what);

}  // namespace penumbra::bindings
