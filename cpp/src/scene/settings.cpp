#include "penumbra/settings.h"

#include <algorithm>
#include <cmath>
#include <sstream>
#include <string_view>

#include "penumbra/error.h"

namespace penumbra {

namespace {

std::string as_text(const SettingValue& value) {
    std::ostringstream out;
    out.precision(12);
    if (const bool* flag = std::get_if<bool>(&value)) {
        out << (*flag ? "true" : "false");
    } else if (const int* integer = std::get_if<int>(&value)) {
        out << *integer;
    } else if (const double* number = std::get_if<double>(&value)) {
        out << *number;
    } else {
        out << '"' << std::get<std::string>(value) << '"';
    }
    return out.str();
}

std::string joined(const std::vector<std::string>& names) {
    std::string text;
    for (const std::string& name : names) {
        text += text.empty() ? name : ", " + name;
    }
    return text;
}

/// "shadow_map.size: "
std::string place(std::string_view technique, std::string_view id) {
    return std::string{technique} + "." + std::string{id} + ": ";
}

void check_range(std::string_view technique, const SettingInfo& info, double value) {
    if (!(value >= info.minimum && value <= info.maximum)) {  // false for NaN too
        std::ostringstream out;
        out.precision(12);
        out << place(technique, info.id) << value << " is out of range; give a value from " << info.minimum << " to "
            << info.maximum;
        if (!info.unit.empty()) {
            out << ' ' << info.unit;
        }
        throw InvalidSettings{out.str()};
    }
}

[[noreturn]] void throw_wrong_type(std::string_view technique, const SettingInfo& info, const SettingValue& value,
                                   const char* wanted) {
    throw InvalidSettings{place(technique, info.id) + as_text(value) + " is not " + wanted + "; give " + wanted +
                          " such as " + as_text(info.default_value)};
}

SettingValue checked(std::string_view technique, const SettingInfo& info, const SettingValue& value) {
    if (std::holds_alternative<bool>(info.default_value)) {
        if (!std::holds_alternative<bool>(value)) {
            throw_wrong_type(technique, info, value, "true or false");
        }
        return value;
    }
    if (std::holds_alternative<int>(info.default_value)) {
        if (!std::holds_alternative<int>(value)) {
            throw_wrong_type(technique, info, value, "a whole number");
        }
        check_range(technique, info, std::get<int>(value));
        return value;
    }
    if (std::holds_alternative<double>(info.default_value)) {
        const int* integer = std::get_if<int>(&value);
        if (integer == nullptr && !std::holds_alternative<double>(value)) {
            throw_wrong_type(technique, info, value, "a number");
        }
        const double number = integer != nullptr ? *integer : std::get<double>(value);
        check_range(technique, info, number);
        return number;
    }
    if (!std::holds_alternative<std::string>(value)) {
        throw_wrong_type(technique, info, value, "a name");
    }
    if (!info.choices.empty() && std::ranges::find(info.choices, std::get<std::string>(value)) == info.choices.end()) {
        throw InvalidSettings{place(technique, info.id) + as_text(value) + " is not a choice; give one of " +
                              joined(info.choices)};
    }
    return value;
}

template <typename T>
const T& get(const Settings& settings, const std::string& id, const char* wanted) {
    const auto found = settings.find(id);
    if (found == settings.end()) {
        throw InvalidSettings{"setting \"" + id + "\" is missing; complete() the settings first"};
    }
    const T* value = std::get_if<T>(&found->second);
    if (value == nullptr) {
        throw InvalidSettings{"setting \"" + id + "\" is " + as_text(found->second) + ", not " + wanted};
    }
    return *value;
}

}  // namespace

Settings complete(std::string_view technique, std::span<const SettingInfo> infos, const Settings& given) {
    for (const auto& [id, value] : given) {
        if (std::ranges::find(infos, id, &SettingInfo::id) == infos.end()) {
            std::vector<std::string> known;
            for (const SettingInfo& info : infos) {
                known.push_back(info.id);
            }
            throw InvalidSettings{std::string{technique} + " has no setting \"" + id + "\"; " +
                                  (known.empty() ? "it has none" : "it has " + joined(known))};
        }
    }
    Settings all;
    for (const SettingInfo& info : infos) {
        const auto found = given.find(info.id);
        all[info.id] = found == given.end() ? info.default_value : checked(technique, info, found->second);
    }
    return all;
}

bool get_bool(const Settings& settings, const std::string& id) {
    return get<bool>(settings, id, "true or false");
}

int get_int(const Settings& settings, const std::string& id) {
    return get<int>(settings, id, "a whole number");
}

double get_double(const Settings& settings, const std::string& id) {
    const auto found = settings.find(id);
    if (found != settings.end()) {
        if (const int* integer = std::get_if<int>(&found->second)) {
            return *integer;
        }
    }
    return get<double>(settings, id, "a number");
}

const std::string& get_choice(const Settings& settings, const std::string& id) {
    return get<std::string>(settings, id, "a name");
}

}  // namespace penumbra
