#include "gl/buffer.h"

#include <algorithm>

#include "gl/context.h"
#include "penumbra/error.h"

namespace penumbra {
namespace {

constexpr std::size_t kLeastBytes = 16;  // one vec4: an empty buffer is bound like any other

}  // namespace

StorageBuffer::StorageBuffer(std::size_t bytes, std::string_view what) : what_{what} {
    resize(bytes);
}

void StorageBuffer::resize(std::size_t bytes) {
    if (buffer_ && bytes == bytes_) {
        return;
    }
    check_gl("before making " + what_);
    buffer_ = Buffer::create();
    bytes_ = bytes;
    glNamedBufferStorage(buffer_.name(), static_cast<GLsizeiptr>(std::max(bytes, kLeastBytes)), nullptr,
                         GL_DYNAMIC_STORAGE_BIT);
    if (glGetError() == GL_OUT_OF_MEMORY) {
        Context& context = *Context::current();
        context.discard_errors();
        buffer_.reset();
        bytes_ = 0;
        constexpr std::size_t kMebibyte = std::size_t{1} << 20U;
        throw OutOfMemory(what_ + ": a buffer of " + std::to_string(bytes / kMebibyte) + " MiB is more than " +
                          context.info().name + " gives; use fewer triangles or samples");
    }
    glObjectLabel(GL_BUFFER, buffer_.name(), static_cast<GLsizei>(what_.size()), what_.data());
    check_gl("making " + what_);
}

void StorageBuffer::upload_raw(const void* data, std::size_t bytes, std::size_t offset) {
    if (bytes > bytes_ || offset > bytes_ - bytes) {
        throw DeviceError(what_ + ": " + std::to_string(bytes) + " bytes at " + std::to_string(offset) +
                          " do not fit into " + std::to_string(bytes_) +
                          "; this is a fault of Penumbra, please report it");
    }
    if (bytes > 0) {
        glNamedBufferSubData(buffer_.name(), static_cast<GLintptr>(offset), static_cast<GLsizeiptr>(bytes), data);
    }
}

void StorageBuffer::read_raw(void* data, std::size_t bytes, std::size_t offset) const {
    PENUMBRA_ASSERT(bytes <= bytes_ && offset <= bytes_ - bytes);
    if (bytes > 0) {
        // What shaders wrote counts as written only behind a barrier.
        glMemoryBarrier(GL_BUFFER_UPDATE_BARRIER_BIT);
        glGetNamedBufferSubData(buffer_.name(), static_cast<GLintptr>(offset), static_cast<GLsizeiptr>(bytes), data);
    }
}

void StorageBuffer::fill_zero() {
    glClearNamedBufferData(buffer_.name(), GL_R8UI, GL_RED_INTEGER, GL_UNSIGNED_BYTE, nullptr);
}

void StorageBuffer::barrier() {
    glMemoryBarrier(GL_ALL_BARRIER_BITS);
}

void StorageBuffer::bind_storage(GLuint index) const {
    glBindBufferBase(GL_SHADER_STORAGE_BUFFER, index, buffer_.name());
}

void StorageBuffer::bind_uniform(GLuint index) const {
    glBindBufferBase(GL_UNIFORM_BUFFER, index, buffer_.name());
}

}  // namespace penumbra
