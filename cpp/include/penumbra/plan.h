#pragma once

#include <compare>
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

/// What a rule that fires saves.
enum class RuleStage {
    Export,      ///< reading the scene and sending it to the device
    Frame,       ///< all of a frame
    LightSpace,  ///< what is made of casters and light: maps, volumes, silhouettes
    ViewSpace,   ///< what is made per pixel
    Reference,   ///< the truth, which is no technique
};
[[nodiscard]] std::string_view to_string(RuleStage stage) noexcept;  ///< "light space"

/// A rule that leaves work out, for documentation and tests; the table is in renderer/rules.cpp.
struct RuleInfo {
    std::string id;
    std::string condition;
    double tolerance = 0.0;
    RuleStage stage = RuleStage::Frame;
    std::vector<std::string> techniques;  ///< ids of those it can fire in, in the registry's order; Reference: none
};
[[nodiscard]] const std::vector<RuleInfo>& rules();

/// Rules that must leave nothing out, whatever the scene: to prove that images do not change and to measure what is
/// saved.
struct Keep {
    bool everything = false;
    std::vector<std::string> rules;  ///< ids, ascending

    Keep() = default;
    Keep(bool every) : everything{every} {}  // NOLINT(*-explicit-constructor): mostly all or nothing
    /// @param ids  of rules, or "all" for everything. @throws InvalidSettings for an id that is not in rules()
    Keep(bool every, std::vector<std::string> ids);
    [[nodiscard]] bool has(std::string_view rule) const noexcept;
    friend auto operator<=>(const Keep&, const Keep&) = default;
};

}  // namespace penumbra
