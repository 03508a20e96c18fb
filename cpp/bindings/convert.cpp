#include "convert.h"

#include <utility>

#include "penumbra/error.h"

namespace penumbra::bindings {

namespace py = pybind11;
using namespace pybind11::literals;

namespace {

/// @throws InvalidSettings for what is no text, or no whole Unicode
std::string text_of(const py::handle& value, const std::string& what) {
    if (!py::isinstance<py::str>(value)) {
        throw InvalidSettings(what + " is of type " +
                              py::str(py::type::of(value).attr("__name__")).cast<std::string>() + "; give a str");
    }
    Py_ssize_t bytes = 0;
    const char* text = PyUnicode_AsUTF8AndSize(value.ptr(), &bytes);
    if (text == nullptr) {
        PyErr_Clear();
        throw InvalidSettings(what + " holds half a character; give a text that UTF-8 can hold");
    }
    return {text, static_cast<std::size_t>(bytes)};
}

int whole_number(const py::handle& value, const std::string& id) {
    int overflow = 0;
    const long long number = PyLong_AsLongLongAndOverflow(value.ptr(), &overflow);
    if (overflow != 0 || !std::in_range<int>(number)) {
        throw InvalidSettings("setting \"" + id +
                              "\" is a whole number of more than 31 bits; no setting goes that far");
    }
    return static_cast<int>(number);
}

}  // namespace

Settings settings_from(const py::dict& values) {
    Settings settings;
    for (const auto& [key, value] : values) {
        const std::string id = text_of(key, "a setting's name");
        if (py::isinstance<py::bool_>(value)) {  // before int: True is an int in Python
            settings[id] = value.cast<bool>();
        } else if (py::isinstance<py::int_>(value)) {
            settings[id] = whole_number(value, id);
        } else if (py::isinstance<py::float_>(value)) {
            settings[id] = value.cast<double>();
        } else if (py::isinstance<py::str>(value)) {
            settings[id] = text_of(value, "setting \"" + id + "\"");
        } else {
            throw InvalidSettings("setting \"" + id + "\" has a value of type " +
                                  py::str(py::type::of(value).attr("__name__")).cast<std::string>() +
                                  "; give a bool, int, float or str");
        }
    }
    return settings;
}

py::object to_python(const SettingValue& value) {
    return std::visit([](const auto& v) { return py::object(py::cast(v)); }, value);
}

py::dict to_python(const Settings& settings) {
    py::dict values;
    for (const auto& [id, value] : settings) {
        values[py::str(id)] = to_python(value);
    }
    return values;
}

py::list to_python(const Plan& plan) {
    py::list steps;
    for (const Step& step : plan.steps) {
        steps.append(py::dict("step"_a = step.name, "state"_a = step.run ? "run" : "left_out", "rule"_a = step.rule,
                              "reason"_a = step.reason, "tolerance"_a = step.tolerance, "time_ms"_a = step.time_ms));
    }
    return steps;
}

py::list to_python(const std::vector<Warning>& warnings) {
    py::list all;
    for (const Warning& warning : warnings) {
        all.append(py::dict("id"_a = warning.id, "reason"_a = warning.reason));
    }
    return all;
}

py::list to_python(const std::vector<Statistic>& statistics) {
    py::list all;
    for (const Statistic& s : statistics) {
        all.append(py::dict("id"_a = s.id, "label"_a = s.label, "unit"_a = s.unit, "value"_a = s.value));
    }
    return all;
}

py::dict to_python(const TimeSummary& times) {
    return py::dict("median"_a = times.median, "p10"_a = times.p10, "p90"_a = times.p90, "low"_a = times.low,
                    "high"_a = times.high, "runs"_a = times.runs, "tight"_a = times.tight);
}

}  // namespace penumbra::bindings
