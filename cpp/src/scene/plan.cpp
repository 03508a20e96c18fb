#include "penumbra/plan.h"

#include <algorithm>
#include <utility>

namespace penumbra {

void Plan::run(std::string name) {
    Step step;
    step.name = std::move(name);
    steps.push_back(std::move(step));
}

void Plan::leave_out(std::string name, std::string rule, std::string reason, double tolerance) {
    Step step;
    step.name = std::move(name);
    step.run = false;
    step.rule = std::move(rule);
    step.reason = std::move(reason);
    step.tolerance = tolerance;
    steps.push_back(std::move(step));
}

bool Plan::runs(std::string_view name) const noexcept {
    return std::ranges::any_of(steps, [&](const Step& step) { return step.run && step.name == name; });
}

void Plan::add_time(std::string_view name, double time_ms) noexcept {
    const auto step = std::ranges::find_if(steps, [&](const Step& s) { return s.run && s.name == name; });
    if (step != steps.end()) {
        step->time_ms += time_ms;
    }
}

bool Keep::has(std::string_view rule) const noexcept {
    return everything || std::ranges::binary_search(rules, rule);
}

std::string_view to_string(RuleStage stage) noexcept {
    switch (stage) {
        case RuleStage::Export:
            return "export";
        case RuleStage::Frame:
            return "frame";
        case RuleStage::LightSpace:
            return "light space";
        case RuleStage::ViewSpace:
            return "view space";
        case RuleStage::Reference:
            break;
    }
    return "reference";
}

}  // namespace penumbra
