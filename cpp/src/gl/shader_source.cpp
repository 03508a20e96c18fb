#include "gl/shader_source.h"

#include <algorithm>
#include <regex>
#include <sstream>

#include "penumbra/error.h"

namespace penumbra {
namespace {

// What the library itself writes above the entry file, so that a faulty define is told from a faulty file.
constexpr const char* kPrologue = "(version and defines)";

std::string_view trimmed(std::string_view text) {
    const std::size_t first = text.find_first_not_of(" \t\r");
    return first == std::string_view::npos ? std::string_view()
                                           : text.substr(first, text.find_last_not_of(" \t\r") - first + 1);
}

// A preprocessor line in its parts: "#  include "a" // b" is {"include", "\"a\" // b"}; empty name for any other line.
struct Directive {
    std::string_view name;
    std::string_view rest;
};

Directive parse_directive(std::string_view line) {
    line = trimmed(line);
    if (line.empty() || line.front() != '#') {
        return {};
    }
    line = trimmed(line.substr(1));
    const std::size_t end = line.find_first_of(" \t\"<(");
    return {line.substr(0, end), end == std::string_view::npos ? std::string_view() : trimmed(line.substr(end))};
}

class Expander {
public:
    Expander(const ShaderSources& sources, ExpandedSource& out) : sources_{sources}, out_{out} {}

    void add(std::string_view key, const std::string& included_from) {
        const auto found = sources_.find(key);
        if (found == sources_.end()) {
            throw DeviceError((included_from.empty() ? std::string("shader \"") : included_from + ": include \"") +
                              std::string(key) + R"(" does not exist; keys look like "lib/depth.glsl")");
        }
        const std::size_t number = out_.files.size();
        out_.files.emplace_back(key);
        std::istringstream lines(found->second);
        std::string line;
        Conditions conditions;
        for (int line_number = 1; std::getline(lines, line); ++line_number) {
            const Directive directive = parse_directive(line);
            const bool ours = conditions.meet(directive);
            if (ours || conditions.for_cpp() || (directive.name == "pragma" && directive.rest == "once")) {
                continue;
            }
            if (directive.name == "include") {
                include(directive.rest, std::string(key) + ":" + std::to_string(line_number));
            } else if (directive.name == "version") {
                throw DeviceError(std::string(key) + ":" + std::to_string(line_number) +
                                  ": #version is written by the library; remove the line");
            } else {
                append(line, {number, line_number});
            }
        }
    }

private:
    // Regions that only a C++ compiler reads; all other conditions are left to the driver.
    class Conditions {
    public:
        /// Follows #if .. #endif. @return true if the directive itself belongs to us and the driver must not see it
        bool meet(const Directive& directive) {
            if (directive.name == "ifdef" || directive.name == "ifndef" || directive.name == "if") {
                const bool about_cpp = directive.rest.find("__cplusplus") != std::string_view::npos;
                const bool negated = directive.name == "ifndef" || directive.rest.starts_with('!');
                open_.push_back({about_cpp, about_cpp && !negated});
                return about_cpp;
            }
            if (open_.empty()) {
                return false;
            }
            Condition& inner = open_.back();
            if (directive.name == "else") {
                inner.for_cpp = inner.about_cpp && !inner.for_cpp;
                return inner.about_cpp;
            }
            if (directive.name == "endif") {
                const bool about_cpp = inner.about_cpp;
                open_.pop_back();
                return about_cpp;
            }
            return false;
        }
        [[nodiscard]] bool for_cpp() const {
            return std::ranges::any_of(open_, [](const Condition& condition) { return condition.for_cpp; });
        }

    private:
        struct Condition {
            bool about_cpp = false;
            bool for_cpp = false;
        };
        std::vector<Condition> open_;
    };

    void append(const std::string& line, ExpandedSource::Place place) {
        out_.text += line;
        out_.text += '\n';
        out_.places.push_back(place);
    }

    void include(std::string_view rest, const std::string& place) {
        const std::size_t end = rest.empty() || rest.front() != '"' ? std::string_view::npos : rest.find('"', 1);
        if (end == std::string_view::npos) {
            throw DeviceError(place + ": shaders include by #include \"key\" only, not: " + std::string(rest));
        }
        const std::string_view key = rest.substr(1, end - 1);
        for (const std::string& file : out_.files) {
            if (file == key) {
                return;
            }
        }
        add(key, place);
    }

    const ShaderSources& sources_;
    ExpandedSource& out_;
};

std::string line_of(std::string_view text, int number) {
    std::size_t begin = 0;
    for (int i = 1; i < number; ++i) {
        begin = text.find('\n', begin);
        if (begin == std::string_view::npos) {
            return {};
        }
        ++begin;
    }
    return std::string(trimmed(text.substr(begin, text.find('\n', begin) - begin)));
}

}  // namespace

ExpandedSource expand(const ShaderSources& sources, std::string_view key, std::span<const Define> defines) {
    ExpandedSource out;
    out.files.emplace_back(kPrologue);
    const auto prologue = [&](const std::string& line) {
        out.text += line + "\n";
        out.places.push_back({0, static_cast<int>(out.places.size()) + 1});
    };
    prologue("#version 450 core");
    for (const Define& define : defines) {
        prologue("#define " + define.name + " " + define.value);
    }
    Expander(sources, out).add(key, {});
    return out;
}

std::string readable_log(std::string_view log, const ExpandedSource& source) {
    // Mesa "0:12(5): error: ...", NVIDIA "0(12) : error C1: ...", others "ERROR: 0:12: ...".
    static const std::regex place(R"(^(?:(ERROR|WARNING): )?\d+[:(](\d+)\)?(?:\(\d+\))?\s*:\s*)");
    std::string out;
    std::istringstream lines{std::string(log)};
    std::string line;
    while (std::getline(lines, line)) {
        line.erase(line.find_last_not_of(" \t\r") + 1);
        line.erase(0, line.starts_with('\0') ? 1 : 0);
        if (line.empty()) {
            continue;
        }
        std::smatch match;
        const bool found = std::regex_search(line, match, place);
        const std::size_t number = found ? std::stoul(match[2].str()) : 0;
        out += out.empty() ? "" : "\n";
        if (number < 1 || number > source.places.size()) {
            out += line;
            continue;
        }
        const ExpandedSource::Place at = source.places[number - 1];
        const std::string& file = source.files[at.file];
        out += file + ":" + std::to_string(at.line) + ": ";
        if (match[1].matched) {
            out += match[1].str() == "ERROR" ? "error: " : "warning: ";
        }
        out += match.suffix().str();
        const std::string shown = line_of(source.text, static_cast<int>(number));
        if (!shown.empty()) {
            out += "\n    " + shown;
        }
    }
    return out;
}

}  // namespace penumbra
