#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace penumbra {

/// One named piece of a technique's work for one light: run, or left out with a reason.
struct Step {
    std::string name;  ///< "depth map, face +x"
    bool run = true;
    std::string rule;        ///< id of the rule that left it out, empty if it runs
    std::string reason;      ///< one sentence with the numbers, empty if it runs
    double tolerance = 0.0;  ///< largest change of V that leaving it out may cause; 0 for exact rules
    double time_ms = 0.0;    ///< median over the measured frames; 0 if not run
};

/// Something of the scene that a technique is not made for: the image will be wrong in a way that is known.
struct Warning {
    std::string id;      ///< "hard-shadow"
    std::string reason;  ///< one sentence with the numbers
};

/// What will be done and what will not, in order. Made before rendering from (light, view, scene, settings) alone.
struct Plan {
    std::vector<Step> steps;
    std::vector<Warning> warnings;  ///< where the technique leaves its field of use; empty within it

    void run(std::string name);
    void leave_out(std::string name, std::string rule, std::string reason, double tolerance = 0.0);
    [[nodiscard]] bool runs(std::string_view name) const noexcept;
    void add_time(std::string_view name, double time_ms) noexcept;
};

/// A rule that leaves work out, for documentation and tests; the table is in renderer/rules.cpp.
struct RuleInfo {
    std::string id;
    std::string condition;
    double tolerance = 0.0;
};
[[nodiscard]] const std::vector<RuleInfo>& rules();

}  // namespace penumbra
