#pragma once

#include <cstddef>
#include <span>
#include <string>
#include <string_view>
#include <type_traits>
#include <vector>

#include "gl/handles.h"

namespace penumbra {

/// A place in the buffer that is bound, spelt as the pointer that OpenGL asks for.
[[nodiscard]] inline const void* buffer_offset(std::size_t bytes) noexcept {
    return reinterpret_cast<const void*>(bytes);  // NOLINT(performance-no-int-to-ptr): it never becomes an address
}

/// A block of GPU memory for shader storage, uniforms, vertices, indices and indirect draws alike.
class StorageBuffer {
public:
    StorageBuffer() noexcept = default;
    /// @param bytes > 0 or 0 (holds one unused word, so that it can be bound)
    /// @throws OutOfMemory if the driver refuses
    StorageBuffer(std::size_t bytes, std::string_view what);

    template <class T>
    [[nodiscard]] static StorageBuffer from(std::span<const T> values, std::string_view what) {
        StorageBuffer buffer(values.size_bytes(), what);
        buffer.upload(values);
        return buffer;
    }
    template <class T>
    [[nodiscard]] static StorageBuffer from(const std::vector<T>& values, std::string_view what) {
        return from(std::span<const T>(values), what);
    }

    [[nodiscard]] GLuint name() const noexcept { return buffer_.name(); }
    [[nodiscard]] explicit operator bool() const noexcept { return static_cast<bool>(buffer_); }
    [[nodiscard]] std::size_t bytes() const noexcept { return bytes_; }

    /// Keeps the storage where the size fits, else makes it anew (name() may change).
    template <class T>
    void replace(std::span<const T> values) {
        static_assert(std::is_trivially_copyable_v<T>);
        resize(values.size_bytes());
        upload_raw(values.data(), values.size_bytes(), 0);
    }
    /// @param first offset in elements of T; the range must lie inside
    template <class T>
    void upload(std::span<const T> values, std::size_t first = 0) {
        static_assert(std::is_trivially_copyable_v<T>);
        upload_raw(values.data(), values.size_bytes(), first * sizeof(T));
    }
    /// Waits for the GPU. All of it; the size is bytes() / sizeof(T).
    template <class T>
    [[nodiscard]] std::vector<T> read() const {
        static_assert(std::is_trivially_copyable_v<T>);
        std::vector<T> values(bytes_ / sizeof(T));
        read_raw(values.data(), values.size() * sizeof(T), 0);
        return values;
    }
    void fill_zero();
    /// Waits until shader writes are visible to reads through any other path (glMemoryBarrier of all bits).
    static void barrier();

    void bind_storage(GLuint index) const;  ///< layout(std430, binding = index) buffer
    void bind_uniform(GLuint index) const;  ///< layout(std140, binding = index) uniform

private:
    void resize(std::size_t bytes);
    void upload_raw(const void* data, std::size_t bytes, std::size_t offset);
    void read_raw(void* data, std::size_t bytes, std::size_t offset) const;

    Buffer buffer_;
    std::size_t bytes_ = 0;
    std::string what_;
};

}  // namespace penumbra
