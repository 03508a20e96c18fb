#include <pybind11/stl.h>

#include "arrays.h"
#include "bindings.h"
#include "penumbra/measure.h"

namespace penumbra::bindings {

using namespace pybind11::literals;

namespace {

py::dict to_python(const ErrorSummary& e) {
    const py::dict parts("noise"_a = e.parts.noise, "leak"_a = e.parts.leak,
                         "over_darkening"_a = e.parts.over_darkening, "bias"_a = e.parts.bias,
                         "aliasing"_a = e.parts.aliasing);
    return py::dict("pixels"_a = e.pixels, "penumbra_pixels"_a = e.penumbra_pixels, "rmse"_a = e.rmse, "mae"_a = e.mae,
                    "bias"_a = e.bias, "p95"_a = e.p95, "p99"_a = e.p99, "max"_a = e.max,
                    "penumbra_rmse"_a = e.penumbra_rmse, "leak"_a = e.leak, "over_darkening"_a = e.over_darkening,
                    "penumbra_width_ratio"_a = e.penumbra_width_ratio, "non_finite"_a = e.non_finite,
                    "reference_standard_error"_a = e.reference_standard_error,
                    "within_reference_noise"_a = e.within_reference_noise, "parts"_a = parts, "dominant"_a = e.dominant,
                    "sentence"_a = e.sentence);
}

template <class T>
std::span<const T> image_span(const Array<T>& array, py::ssize_t height, py::ssize_t width, const char* what) {
    if (array.ndim() != 2 || array.shape(0) != height || array.shape(1) != width) {
        throw InvalidSettings(std::string{what} + " has shape " + shape_text(array) + ", but the mask has (" +
                              std::to_string(height) + ", " + std::to_string(width) + ")");
    }
    return {array.data(), static_cast<std::size_t>(array.size())};
}

py::dict errors(const std::vector<Array<float>>& visibility, const Array<float>& reference,
                const std::optional<Array<float>>& standard_error, const Array<std::uint8_t>& mask) {
    if (mask.ndim() != 2) {
        throw InvalidSettings("the mask has shape " + shape_text(mask) + ", but (height, width) is needed");
    }
    const py::ssize_t height = mask.shape(0);
    const py::ssize_t width = mask.shape(1);
    std::vector<std::span<const float>> images;
    images.reserve(visibility.size());
    for (const auto& image : visibility) {
        images.push_back(image_span(image, height, width, "visibility"));
    }
    const auto truth = image_span(reference, height, width, "reference");
    const auto deviation =
        standard_error ? image_span(*standard_error, height, width, "standard_error") : std::span<const float>{};
    const std::span<const std::uint8_t> asked{mask.data(), static_cast<std::size_t>(mask.size())};
    ErrorSummary summary;
    {
        const py::gil_scoped_release release;
        summary = measure_errors(images, truth, deviation, asked, static_cast<int>(width));
    }
    return to_python(summary);
}

}  // namespace

void bind_measure(py::module_& m) {
    m.def("measure_errors", &errors, "visibility"_a, "reference"_a, "standard_error"_a, "mask"_a,
          "Errors of V against the reference over the mask; definitions in docs/measuring.md.\n"
          "visibility: one (h, w) float32 image per seed; reference, standard_error (or None): (h, w) float32;\n"
          "mask: (h, w) uint8.");
    m.def(
        "pareto_front",
        [](const std::vector<double>& times_ms, const std::vector<double>& values) {
            return pareto_front(times_ms, values);
        },
        "times_ms"_a, "errors"_a, "True for each record that no other beats in both time and error.");
}

}  // namespace penumbra::bindings
