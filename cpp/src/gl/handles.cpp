#include "gl/handles.h"

namespace penumbra {

GLuint BufferTraits::create() {
    GLuint name = 0;
    glCreateBuffers(1, &name);
    return name;
}
void BufferTraits::destroy(GLuint name) noexcept {
    glDeleteBuffers(1, &name);
}

GLuint TextureTraits::create() {
    GLuint name = 0;
    glGenTextures(1, &name);
    return name;
}
GLuint TextureTraits::create(GLenum target) {
    GLuint name = 0;
    glCreateTextures(target, 1, &name);
    return name;
}
void TextureTraits::destroy(GLuint name) noexcept {
    glDeleteTextures(1, &name);
}

GLuint FramebufferTraits::create() {
    GLuint name = 0;
    glCreateFramebuffers(1, &name);
    return name;
}
void FramebufferTraits::destroy(GLuint name) noexcept {
    glDeleteFramebuffers(1, &name);
}

GLuint VertexArrayTraits::create() {
    GLuint name = 0;
    glCreateVertexArrays(1, &name);
    return name;
}
void VertexArrayTraits::destroy(GLuint name) noexcept {
    glDeleteVertexArrays(1, &name);
}

GLuint ProgramTraits::create() {
    return glCreateProgram();
}
void ProgramTraits::destroy(GLuint name) noexcept {
    glDeleteProgram(name);
}

GLuint ShaderTraits::create(GLenum stage) {
    return glCreateShader(stage);
}
void ShaderTraits::destroy(GLuint name) noexcept {
    glDeleteShader(name);
}

GLuint QueryTraits::create(GLenum target) {
    GLuint name = 0;
    glCreateQueries(target, 1, &name);
    return name;
}
void QueryTraits::destroy(GLuint name) noexcept {
    glDeleteQueries(1, &name);
}

GLuint SamplerTraits::create() {
    GLuint name = 0;
    glCreateSamplers(1, &name);
    return name;
}
void SamplerTraits::destroy(GLuint name) noexcept {
    glDeleteSamplers(1, &name);
}

}  // namespace penumbra
