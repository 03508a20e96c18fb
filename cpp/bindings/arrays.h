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

/// An array whose values are what the caller wrote: numpy would wrap a triangle index of -1 or 2^32 round to another
/// one, cut 1.5 to 1, drop the imaginary part and read texts as numbers.
template <class T>
struct Faithful {
    Array<T> values;
};

/// @throws InvalidScene for other than numbers that T can hold; an empty array may be of any kind
template <class T>
[[nodiscard]] Array<T> faithful(const py::array& given);

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

template <class Vector, class T, int Width>
std::vector<Vector> vectors_from(const Faithful<T>& array, const char* what) {
    return vectors_from<Vector, T, Width>(array.values, what);
}

[[nodiscard]] glm::dmat4 matrix_from(const Array<double>& array, const char* what);
[[nodiscard]] py::array_t<double> matrix_to(const glm::dmat4& matrix);
[[nodiscard]] glm::dvec3 dvec3_from(const std::vector<double>& values, const char* what);

}  // namespace penumbra::bindings

namespace pybind11::detail {

template <class T>
struct type_caster<penumbra::bindings::Faithful<T>> {
    PYBIND11_TYPE_CASTER(penumbra::bindings::Faithful<T>, type_caster<penumbra::bindings::Array<T>>::name);

    bool load(handle source, bool convert) {
        if (!convert && !isinstance<array>(source)) {
            return false;
        }
        const array given = array::ensure(source);
        if (!given) {
            return false;
        }
        value.values = penumbra::bindings::faithful<T>(given);
        return static_cast<bool>(value.values);
    }
};

}  // namespace pybind11::detail
