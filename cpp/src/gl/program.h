#pragma once

#include <cstdint>
#include <glm/glm.hpp>
#include <initializer_list>
#include <map>
#include <memory>
#include <set>
#include <span>
#include <string>
#include <string_view>

#include "gl/handles.h"
#include "gl/shader_source.h"

namespace penumbra {

/// A linked program. Uniforms are set on it by name, bound or not; locations are looked up once, when it is linked.
/// A name that the shader never declares is a bug of ours (PENUMBRA_ASSERT); one that the compiler left out because
/// nothing reads it is ignored. Arrays go by span, from element 0. Large data belongs in a StorageBuffer.
class Program {
public:
    [[nodiscard]] GLuint name() const noexcept { return object_.name(); }
    /// glUseProgram
    void use() const;

    void set(std::string_view uniform, bool value) const;  ///< as int
    void set(std::string_view uniform, int value) const;
    void set(std::string_view uniform, unsigned value) const;
    void set(std::string_view uniform, float value) const;
    void set(std::string_view uniform, double value) const;
    void set(std::string_view uniform, const glm::ivec2& value) const;
    void set(std::string_view uniform, const glm::ivec3& value) const;
    void set(std::string_view uniform, const glm::ivec4& value) const;
    void set(std::string_view uniform, const glm::uvec2& value) const;
    void set(std::string_view uniform, const glm::vec2& value) const;
    void set(std::string_view uniform, const glm::vec3& value) const;
    void set(std::string_view uniform, const glm::vec4& value) const;
    void set(std::string_view uniform, const glm::dvec2& value) const;
    void set(std::string_view uniform, const glm::dvec3& value) const;
    void set(std::string_view uniform, const glm::dvec4& value) const;
    void set(std::string_view uniform, const glm::mat3& value) const;
    void set(std::string_view uniform, const glm::mat4& value) const;
    void set(std::string_view uniform, const glm::dmat3& value) const;
    void set(std::string_view uniform, const glm::dmat4& value) const;
    void set(std::string_view uniform, std::span<const int> values) const;
    void set(std::string_view uniform, std::span<const float> values) const;
    void set(std::string_view uniform, std::span<const glm::vec2> values) const;
    void set(std::string_view uniform, std::span<const glm::vec3> values) const;
    void set(std::string_view uniform, std::span<const glm::vec4> values) const;
    void set(std::string_view uniform, std::span<const glm::mat4> values) const;

    /// True if the linked program reads it.
    [[nodiscard]] bool has(std::string_view uniform) const noexcept { return locations_.contains(uniform); }

private:
    friend class ProgramLibrary;
    [[nodiscard]] GLint location(std::string_view uniform) const noexcept;

    ProgramObject object_;
    std::map<std::string, GLint, std::less<>> locations_;
    std::set<std::string, std::less<>> declared_;  ///< by any stage, read or not
};

/// Compiles programs when they are first asked for, and keeps them. One per context, on the render thread.
class ProgramLibrary {
public:
    explicit ProgramLibrary(const ShaderSources& sources = embedded_shaders()) : sources_{&sources} {}

    /// @param stage_files keys of entry files; the suffix tells the stage: .vert .geom .frag .comp .tesc .tese
    /// @param defines macros for all stages, in any order; a name given twice is a bug
    /// @return valid as long as the library
    /// @throws DeviceError with file, line, the driver's message and the source line
    const Program& get(std::initializer_list<std::string_view> stage_files, const Defines& defines = {});

    /// Programs compiled so far, and the time it took (part of set-up). A software driver compiles most of it later,
    /// at the first draw.
    [[nodiscard]] int compiled() const noexcept { return static_cast<int>(programs_.size()); }
    [[nodiscard]] double compile_ms() const noexcept { return compile_ms_; }

private:
    [[nodiscard]] std::unique_ptr<Program> compile(std::span<const std::string_view> stage_files,
                                                   std::span<const Define> defines) const;

    const ShaderSources* sources_;
    std::map<std::string, std::unique_ptr<Program>, std::less<>> programs_;
    double compile_ms_ = 0.0;
};

}  // namespace penumbra
