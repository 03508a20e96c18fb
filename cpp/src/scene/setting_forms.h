#pragma once

#include <string>
#include <utility>
#include <vector>

#include "penumbra/settings.h"

namespace penumbra {

/// One of `choices`, the first by default.
[[nodiscard]] inline SettingInfo choice_setting(std::string id, std::string label, std::string help,
                                                std::vector<std::string> choices,
                                                std::vector<SettingValue> sweep = {}) {
    SettingValue first = choices.front();
    return {.id = std::move(id),
            .label = std::move(label),
            .unit = "",
            .help = std::move(help),
            .default_value = std::move(first),
            .minimum = 0,
            .maximum = 0,
            .choices = std::move(choices),
            .sweep = std::move(sweep)};
}

/// Any text.
[[nodiscard]] inline SettingInfo name_setting(std::string id, std::string label, std::string help, std::string value) {
    return {.id = std::move(id),
            .label = std::move(label),
            .unit = "",
            .help = std::move(help),
            .default_value = std::move(value),
            .minimum = 0,
            .maximum = 0,
            .choices = {},
            .sweep = {}};
}

/// An int or a double, by the type of `value`; both limits are allowed.
[[nodiscard]] inline SettingInfo number_setting(std::string id, std::string label, std::string unit, std::string help,
                                                SettingValue value, double minimum, double maximum,
                                                std::vector<SettingValue> sweep = {}) {
    return {.id = std::move(id),
            .label = std::move(label),
            .unit = std::move(unit),
            .help = std::move(help),
            .default_value = std::move(value),
            .minimum = minimum,
            .maximum = maximum,
            .choices = {},
            .sweep = std::move(sweep)};
}

[[nodiscard]] inline SettingInfo toggle_setting(std::string id, std::string label, std::string help, bool value) {
    return {.id = std::move(id),
            .label = std::move(label),
            .unit = "",
            .help = std::move(help),
            .default_value = value,
            .minimum = 0,
            .maximum = 0,
            .choices = {},
            .sweep = {}};
}

/// Swept only where the choice `setting` is `value`: elsewhere it changes nothing.
[[nodiscard]] inline SettingInfo swept_when(SettingInfo info, std::string setting, std::string value) {
    info.sweep_when = {.setting = std::move(setting), .value = std::move(value)};
    return info;
}

}  // namespace penumbra
