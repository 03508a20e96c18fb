#pragma once

#include <string>

#include "penumbra/renderer.h"

namespace penumbra {

/// "TECHNIQUE[,setting=value...]" as a benchmark's words have it.
inline Job job_from(const std::string& words) {
    Job job;
    std::size_t at = words.find(',');
    job.technique = words.substr(0, at);
    while (at != std::string::npos) {
        const std::size_t next = words.find(',', at + 1);
        const std::string setting = words.substr(at + 1, next - at - 1);
        const std::size_t equal = setting.find('=');
        const std::string value = setting.substr(equal + 1);
        SettingValue parsed = value;
        if (value == "true" || value == "false") {
            parsed = value == "true";
        } else if (value.find_first_not_of("0123456789") == std::string::npos) {
            parsed = std::stoi(value);
        } else if (value.find_first_not_of("0123456789.e-") == std::string::npos) {
            parsed = std::stod(value);
        }
        job.settings[setting.substr(0, equal)] = parsed;
        at = next;
    }
    return job;
}

}  // namespace penumbra
