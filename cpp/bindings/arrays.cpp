#include "arrays.h"

#include <cstdint>
#include <limits>
#include <type_traits>
#include <utility>

namespace penumbra::bindings {

std::string shape_text(const py::array& array) {
    std::string text = "(";
    for (py::ssize_t i = 0; i < array.ndim(); ++i) {
        text += (i > 0 ? ", " : "") + std::to_string(array.shape(i));
    }
    return text + ")";
}

namespace {

/// @param values an array of Wide
template <class T, class Wide>
void check_whole(const py::array& values) {
    const Array<Wide> wide{values};
    for (py::ssize_t i = 0; i < wide.size(); ++i) {
        if (!std::in_range<T>(wide.data()[i])) {
            throw InvalidScene("an index is " + std::to_string(wide.data()[i]) + "; give numbers from 0 to " +
                               std::to_string(std::numeric_limits<T>::max()));
        }
    }
}

}  // namespace

template <class T>
Array<T> faithful(const py::array& given) {
    const char kind = given.dtype().kind();
    const auto refuse = [&](const char* wanted) {
        throw InvalidScene("an array holds " + py::str(given.dtype()).cast<std::string>() + "; give " + wanted);
    };
    if (given.size() == 0) {
        return Array<T>{given};
    }
    if constexpr (std::is_integral_v<T>) {
        if (kind != 'u' && kind != 'i' && kind != 'b') {
            refuse("whole numbers");
        }
        if (kind == 'i') {
            check_whole<T, std::int64_t>(given);
        } else if (given.itemsize() > py::ssize_t{sizeof(T)}) {
            check_whole<T, std::uint64_t>(given);
        }
    } else if (kind != 'f' && kind != 'u' && kind != 'i' && kind != 'b') {
        refuse("real numbers");
    }
    return Array<T>{given};
}

template Array<float> faithful<float>(const py::array&);
template Array<double> faithful<double>(const py::array&);
template Array<std::uint16_t> faithful<std::uint16_t>(const py::array&);
template Array<std::uint32_t> faithful<std::uint32_t>(const py::array&);

glm::dmat4 matrix_from(const Array<double>& array, const char* what) {
    if (array.ndim() != 2 || array.shape(0) != 4 || array.shape(1) != 4) {
        throw InvalidScene(std::string{what} + " has shape " + shape_text(array) + ", but (4, 4) is needed");
    }
    glm::dmat4 matrix;
    for (int row = 0; row < 4; ++row) {
        for (int column = 0; column < 4; ++column) {
            matrix[column][row] = array.at(row, column);
        }
    }
    return matrix;
}

py::array_t<double> matrix_to(const glm::dmat4& matrix) {
    py::array_t<double> array({4, 4});
    auto values = array.mutable_unchecked<2>();
    for (int row = 0; row < 4; ++row) {
        for (int column = 0; column < 4; ++column) {
            values(row, column) = matrix[column][row];
        }
    }
    return array;
}

glm::dvec3 dvec3_from(const std::vector<double>& values, const char* what) {
    if (values.size() != 3) {
        throw InvalidScene(std::string{what} + " has " + std::to_string(values.size()) + " numbers, but 3 are needed");
    }
    return {values[0], values[1], values[2]};
}

}  // namespace penumbra::bindings
