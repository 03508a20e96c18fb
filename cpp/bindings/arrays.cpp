#include "arrays.h"

namespace penumbra::bindings {

std::string shape_text(const py::array& array) {
    std::string text = "(";
    for (py::ssize_t i = 0; i < array.ndim(); ++i) {
        text += (i > 0 ? ", " : "") + std::to_string(array.shape(i));
    }
    return text + ")";
}

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
