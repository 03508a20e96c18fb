#pragma once

#include <pybind11/pybind11.h>

#include "penumbra/measure.h"
#include "penumbra/plan.h"
#include "penumbra/settings.h"
#include "penumbra/technique.h"

namespace penumbra::bindings {

/// {"key": bool | int | float | str}; @throws InvalidSettings naming the key for any other type
[[nodiscard]] Settings settings_from(const pybind11::dict& values);
[[nodiscard]] pybind11::object to_python(const SettingValue& value);
[[nodiscard]] pybind11::dict to_python(const Settings& settings);
[[nodiscard]] pybind11::list to_python(const Plan& plan);
[[nodiscard]] pybind11::list to_python(const std::vector<Warning>& warnings);
[[nodiscard]] pybind11::list to_python(const std::vector<Statistic>& statistics);
[[nodiscard]] pybind11::dict to_python(const TimeSummary& times);

}  // namespace penumbra::bindings
