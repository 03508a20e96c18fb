#pragma once

#include <map>
#include <span>
#include <string>
#include <variant>
#include <vector>

namespace penumbra {

using SettingValue = std::variant<bool, int, double, std::string>;

/// The one description of a setting: validation, command line, Blender panel and docs are made from it.
struct SettingInfo {
    std::string id;     ///< snake_case, unique within its technique
    std::string label;  ///< for people
    std::string unit;   ///< "px", "m", "texel", "rays", ... or empty
    std::string help;   ///< one sentence
    SettingValue default_value;
    double minimum = 0.0;              ///< int and double only, inclusive
    double maximum = 0.0;              ///< int and double only, inclusive
    std::vector<std::string> choices;  ///< string only: the allowed values; empty: any text (a name)
    std::vector<SettingValue> sweep;   ///< quality steps from cheap to costly; empty: not swept
    /// Another setting (a choice) and the value it must have for this one to be swept: elsewhere it changes nothing.
    struct {
        std::string setting;  ///< empty: always
        std::string value;
    } sweep_when{};
};

/// Values by setting id. What is absent takes its default.
using Settings = std::map<std::string, SettingValue>;

/// All settings of `infos`, defaults filled in.
/// @throws InvalidSettings for an unknown id, a wrong type (an int is taken for a double) or a value out of range.
[[nodiscard]] Settings complete(std::string_view technique, std::span<const SettingInfo> infos, const Settings& given);

[[nodiscard]] bool get_bool(const Settings& settings, const std::string& id);
[[nodiscard]] int get_int(const Settings& settings, const std::string& id);
[[nodiscard]] double get_double(const Settings& settings, const std::string& id);
[[nodiscard]] const std::string& get_choice(const Settings& settings, const std::string& id);

}  // namespace penumbra
