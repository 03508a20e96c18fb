#include "gl/program.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <chrono>
#include <glm/gtc/type_ptr.hpp>
#include <vector>

#include "gl/context.h"
#include "penumbra/error.h"

namespace penumbra {
namespace {

struct Stage {
    std::string_view suffix;
    GLenum type;
};
constexpr std::array<Stage, 6> kStages{{{".vert", GL_VERTEX_SHADER},
                                        {".tesc", GL_TESS_CONTROL_SHADER},
                                        {".tese", GL_TESS_EVALUATION_SHADER},
                                        {".geom", GL_GEOMETRY_SHADER},
                                        {".frag", GL_FRAGMENT_SHADER},
                                        {".comp", GL_COMPUTE_SHADER}}};

GLenum stage_of(std::string_view file) {
    for (const Stage& stage : kStages) {
        if (file.ends_with(stage.suffix)) {
            return stage.type;
        }
    }
    throw DeviceError("shader \"" + std::string(file) +
                      "\" does not tell its stage; it must end in .vert, .tesc, .tese, .geom, .frag or .comp");
}

std::string join(std::span<const std::string_view> files) {
    std::string text;
    for (const std::string_view file : files) {
        text += (text.empty() ? "" : " + ") + std::string(file);
    }
    return text;
}

std::string on_device() {
    const Context* context = Context::current();
    return context == nullptr ? std::string() : " on " + context->info().name;
}

bool in_identifier(char c) {
    return std::isalnum(static_cast<unsigned char>(c)) != 0 || c == '_';
}

// The names that a text declares as uniforms outside of blocks. Types come along and do no harm.
void collect_uniforms(std::string_view text, std::set<std::string, std::less<>>& names) {
    constexpr std::string_view kKeyword = "uniform";
    for (std::size_t at = text.find(kKeyword); at != std::string_view::npos; at = text.find(kKeyword, at)) {
        at += kKeyword.size();
        const std::size_t end = std::min(text.find_first_of(";{", at), text.size());
        while (at < end) {
            if (!in_identifier(text[at])) {
                ++at;
                continue;
            }
            const std::size_t begin = at;
            while (at < end && in_identifier(text[at])) {
                ++at;
            }
            names.emplace(text.substr(begin, at - begin));
        }
    }
}

ShaderObject compile_stage(std::string_view file, const ExpandedSource& source) {
    ShaderObject shader = ShaderObject::create(stage_of(file));
    const char* text = source.text.c_str();
    glShaderSource(shader.name(), 1, &text, nullptr);
    glCompileShader(shader.name());
    GLint compiled = GL_FALSE;
    glGetShaderiv(shader.name(), GL_COMPILE_STATUS, &compiled);
    if (compiled == GL_FALSE) {
        GLint length = 0;
        glGetShaderiv(shader.name(), GL_INFO_LOG_LENGTH, &length);
        std::string log(static_cast<std::size_t>(std::max(length, 1)), '\0');
        GLsizei written = 0;
        glGetShaderInfoLog(shader.name(), length, &written, log.data());
        log.resize(static_cast<std::size_t>(written));
        throw DeviceError("shader " + std::string(file) + " does not compile" + on_device() + ":\n" +
                          readable_log(log, source));
    }
    return shader;
}

void link(const ProgramObject& program, std::span<const ShaderObject> shaders, const std::string& what) {
    for (const ShaderObject& shader : shaders) {
        glAttachShader(program.name(), shader.name());
    }
    glLinkProgram(program.name());
    GLint linked = GL_FALSE;
    glGetProgramiv(program.name(), GL_LINK_STATUS, &linked);
    for (const ShaderObject& shader : shaders) {
        glDetachShader(program.name(), shader.name());
    }
    if (linked == GL_FALSE) {
        GLint length = 0;
        glGetProgramiv(program.name(), GL_INFO_LOG_LENGTH, &length);
        std::string log(static_cast<std::size_t>(std::max(length, 1)), '\0');
        GLsizei written = 0;
        glGetProgramInfoLog(program.name(), length, &written, log.data());
        log.resize(static_cast<std::size_t>(written));
        throw DeviceError("program " + what + " does not link" + on_device() + ":\n" + log);
    }
}

std::map<std::string, GLint, std::less<>> find_locations(const ProgramObject& program) {
    std::map<std::string, GLint, std::less<>> locations;
    GLint count = 0;
    GLint longest = 0;
    glGetProgramInterfaceiv(program.name(), GL_UNIFORM, GL_ACTIVE_RESOURCES, &count);
    glGetProgramInterfaceiv(program.name(), GL_UNIFORM, GL_MAX_NAME_LENGTH, &longest);
    std::string name(static_cast<std::size_t>(std::max(longest, 1)), '\0');
    for (GLuint i = 0; i < static_cast<GLuint>(count); ++i) {
        GLsizei length = 0;
        glGetProgramResourceName(program.name(), GL_UNIFORM, i, longest, &length, name.data());
        std::string_view found(name.data(), static_cast<std::size_t>(length));
        const GLint location = glGetUniformLocation(program.name(), name.c_str());
        if (location < 0) {
            continue;  // a member of a block
        }
        if (found.ends_with("[0]")) {
            found.remove_suffix(3);
        }
        locations.emplace(found, location);
    }
    return locations;
}

GLsizei count_of(std::size_t size) {
    return static_cast<GLsizei>(size);
}

}  // namespace

void Program::use() const {
    glUseProgram(name());
}

GLint Program::location(std::string_view uniform) const noexcept {
    const auto found = locations_.find(uniform);
    if (found != locations_.end()) {
        return found->second;
    }
    PENUMBRA_ASSERT(declared_.contains(uniform.substr(0, uniform.find_first_of(".["))));
    return -1;  // which glProgramUniform* ignores
}

void Program::set(std::string_view u, bool v) const {
    glProgramUniform1i(name(), location(u), v ? 1 : 0);
}
void Program::set(std::string_view u, int v) const {
    glProgramUniform1i(name(), location(u), v);
}
void Program::set(std::string_view u, unsigned v) const {
    glProgramUniform1ui(name(), location(u), v);
}
void Program::set(std::string_view u, float v) const {
    glProgramUniform1f(name(), location(u), v);
}
void Program::set(std::string_view u, double v) const {
    glProgramUniform1d(name(), location(u), v);
}
void Program::set(std::string_view u, const glm::ivec2& v) const {
    glProgramUniform2iv(name(), location(u), 1, glm::value_ptr(v));
}
void Program::set(std::string_view u, const glm::ivec3& v) const {
    glProgramUniform3iv(name(), location(u), 1, glm::value_ptr(v));
}
void Program::set(std::string_view u, const glm::ivec4& v) const {
    glProgramUniform4iv(name(), location(u), 1, glm::value_ptr(v));
}
void Program::set(std::string_view u, const glm::uvec2& v) const {
    glProgramUniform2uiv(name(), location(u), 1, glm::value_ptr(v));
}
void Program::set(std::string_view u, const glm::vec2& v) const {
    glProgramUniform2fv(name(), location(u), 1, glm::value_ptr(v));
}
void Program::set(std::string_view u, const glm::vec3& v) const {
    glProgramUniform3fv(name(), location(u), 1, glm::value_ptr(v));
}
void Program::set(std::string_view u, const glm::vec4& v) const {
    glProgramUniform4fv(name(), location(u), 1, glm::value_ptr(v));
}
void Program::set(std::string_view u, const glm::dvec2& v) const {
    glProgramUniform2dv(name(), location(u), 1, glm::value_ptr(v));
}
void Program::set(std::string_view u, const glm::dvec3& v) const {
    glProgramUniform3dv(name(), location(u), 1, glm::value_ptr(v));
}
void Program::set(std::string_view u, const glm::dvec4& v) const {
    glProgramUniform4dv(name(), location(u), 1, glm::value_ptr(v));
}
void Program::set(std::string_view u, const glm::mat3& v) const {
    glProgramUniformMatrix3fv(name(), location(u), 1, GL_FALSE, glm::value_ptr(v));
}
void Program::set(std::string_view u, const glm::mat4& v) const {
    glProgramUniformMatrix4fv(name(), location(u), 1, GL_FALSE, glm::value_ptr(v));
}
void Program::set(std::string_view u, const glm::dmat3& v) const {
    glProgramUniformMatrix3dv(name(), location(u), 1, GL_FALSE, glm::value_ptr(v));
}
void Program::set(std::string_view u, const glm::dmat4& v) const {
    glProgramUniformMatrix4dv(name(), location(u), 1, GL_FALSE, glm::value_ptr(v));
}
void Program::set(std::string_view u, std::span<const int> v) const {
    glProgramUniform1iv(name(), location(u), count_of(v.size()), v.data());
}
void Program::set(std::string_view u, std::span<const float> v) const {
    glProgramUniform1fv(name(), location(u), count_of(v.size()), v.data());
}
void Program::set(std::string_view u, std::span<const glm::vec2> v) const {
    glProgramUniform2fv(name(), location(u), count_of(v.size()), reinterpret_cast<const float*>(v.data()));
}
void Program::set(std::string_view u, std::span<const glm::vec3> v) const {
    glProgramUniform3fv(name(), location(u), count_of(v.size()), reinterpret_cast<const float*>(v.data()));
}
void Program::set(std::string_view u, std::span<const glm::vec4> v) const {
    glProgramUniform4fv(name(), location(u), count_of(v.size()), reinterpret_cast<const float*>(v.data()));
}
void Program::set(std::string_view u, std::span<const glm::mat4> v) const {
    glProgramUniformMatrix4fv(name(), location(u), count_of(v.size()), GL_FALSE,
                              reinterpret_cast<const float*>(v.data()));
}

const Program& ProgramLibrary::get(std::initializer_list<std::string_view> stage_files, const Defines& defines) {
    Defines sorted = defines;
    std::ranges::sort(sorted, [](const Define& a, const Define& b) { return a.name < b.name; });
    const std::span<const std::string_view> files(stage_files.begin(), stage_files.size());
    std::string key = join(files);
    PENUMBRA_ASSERT(std::ranges::adjacent_find(sorted, {}, &Define::name) == sorted.end());  // no name twice
    for (const Define& define : sorted) {
        key += "\n" + define.name + "=" + define.value;
    }
    const auto found = programs_.find(key);
    if (found != programs_.end()) {
        return *found->second;
    }
    const auto started = std::chrono::steady_clock::now();
    std::unique_ptr<Program> program = compile(files, sorted);
    compile_ms_ += std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - started).count();
    return *programs_.emplace(std::move(key), std::move(program)).first->second;
}

std::unique_ptr<Program> ProgramLibrary::compile(std::span<const std::string_view> stage_files,
                                                 std::span<const Define> defines) const {
    auto program = std::make_unique<Program>();
    std::vector<ShaderObject> shaders;
    for (const std::string_view file : stage_files) {
        const ExpandedSource source = expand(*sources_, file, defines);
        shaders.push_back(compile_stage(file, source));
        collect_uniforms(source.text, program->declared_);
    }
    const std::string what = join(stage_files);
    program->object_ = ProgramObject::create();
    link(program->object_, shaders, what);
    program->locations_ = find_locations(program->object_);
    glObjectLabel(GL_PROGRAM, program->name(), -1, what.c_str());
    return program;
}

}  // namespace penumbra
