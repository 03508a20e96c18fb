#include <pybind11/stl.h>

#include <array>

#include "bindings.h"
#include "convert.h"
#include "gl/device.h"
#include "penumbra/technique.h"
#include "reference/embree_library.h"

namespace penumbra::bindings {

namespace py = pybind11;
using namespace pybind11::literals;

namespace {

const char* type_name(const SettingValue& value) {
    static constexpr std::array kNames{"bool", "int", "float", "choice"};
    return kNames.at(value.index());
}

py::dict describe_setting(const SettingInfo& info) {
    py::list sweep;
    for (const SettingValue& value : info.sweep) {
        sweep.append(to_python(value));
    }
    const py::dict when;
    if (!info.sweep_when.setting.empty()) {
        when[py::str(info.sweep_when.setting)] = info.sweep_when.value;
    }
    return py::dict("id"_a = info.id, "label"_a = info.label, "unit"_a = info.unit, "help"_a = info.help,
                    "type"_a = type_name(info.default_value), "default"_a = to_python(info.default_value),
                    "minimum"_a = info.minimum, "maximum"_a = info.maximum, "choices"_a = info.choices,
                    "sweep"_a = sweep, "sweep_when"_a = when);
}

py::list list_techniques() {
    py::list all;
    for (const TechniqueInfo& info : techniques()) {
        py::list lights;
        py::list settings;
        for (const LightKind kind : info.lights) {
            lights.append(std::string{to_string(kind)});
        }
        for (const SettingInfo& setting : info.settings) {
            settings.append(describe_setting(setting));
        }
        all.append(py::dict("id"_a = info.id, "title"_a = info.title, "paper"_a = info.paper,
                            "summary"_a = info.summary, "randomised"_a = info.randomised, "on_cpu"_a = info.on_cpu,
                            "lights"_a = lights, "settings"_a = settings, "knob"_a = info.knob));
    }
    return all;
}

py::list list_rules() {
    py::list all;
    for (const RuleInfo& rule : rules()) {
        all.append(py::dict("id"_a = rule.id, "condition"_a = rule.condition, "tolerance"_a = rule.tolerance,
                            "stage"_a = to_string(rule.stage), "techniques"_a = rule.techniques));
    }
    return all;
}

py::list list_all_devices() {
    std::vector<DeviceInfo> devices;
    {
        const py::gil_scoped_release release;
        devices = list_devices();
    }
    py::list all;
    for (const DeviceInfo& info : devices) {
        all.append(py::dict("index"_a = info.index, "name"_a = info.name, "vendor"_a = info.vendor,
                            "gl_version"_a = info.gl_version, "software"_a = info.software, "usable"_a = info.usable,
                            "reason"_a = info.reason));
    }
    return all;
}

std::string device_problem() {
    std::string problem;
    const py::gil_scoped_release release;
    static_cast<void>(list_devices({}, &problem));
    return problem;
}

py::dict build_info() {
    return py::dict("version"_a = PENUMBRA_VERSION, "compiler"_a = __VERSION__, "cpp_standard"_a = __cplusplus);
}

}  // namespace

void bind_techniques(py::module_& m) {
    m.attr("__version__") = PENUMBRA_VERSION;
    m.def("techniques", &list_techniques, "All techniques with their settings, in the order users see them.");
    m.def("rules", &list_rules,
          "All rules that leave work out: id, condition, tolerance of V, stage of a frame, and the techniques it can "
          "fire in.");
    m.def("devices", &list_all_devices, "All EGL devices, usable or not; empty without libEGL.");
    m.def("device_problem", &device_problem, "Why devices() is empty, in one sentence, or an empty string.");
    m.def("embree_version", &embree::version, "Version of the Embree in use; raises DeviceError if there is none.");
    m.def("build_info", &build_info, "Version, compiler and language standard of this build.");
}

}  // namespace penumbra::bindings
