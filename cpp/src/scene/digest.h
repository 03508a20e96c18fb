#pragma once

#include <concepts>
#include <cstddef>
#include <cstdint>
#include <glm/glm.hpp>
#include <memory>
#include <string>
#include <string_view>

#include "penumbra/scene.h"

namespace penumbra {

/// Gathers values into a 128-bit digest (XXH3): the same values in the same order give the same digest on every
/// machine. Not cryptographic: it names cache entries and tells whether something changed.
class Digest {
public:
    Digest();
    ~Digest();
    Digest(const Digest&) = delete;
    Digest& operator=(const Digest&) = delete;

    void add_bytes(const void* data, std::size_t bytes);
    template <typename T>
    requires std::integral<T> || std::floating_point<T>
    void add(T value) { add_bytes(&value, sizeof value); }
    /// With its length in front, so that ("ab", "c") differs from ("a", "bc").
    void add(std::string_view text);
    void add(const glm::dvec2& value);
    void add(const glm::dvec3& value);
    void add(const glm::dmat4& value);

    /// 32 lower-case hexadecimal digits of all that was added so far.
    [[nodiscard]] std::string hex() const;

private:
    struct State;
    std::unique_ptr<State> state_;
};

/// Digest of all bytes of the mesh that influence an image; its name does not.
[[nodiscard]] std::string mesh_digest(const Mesh& mesh);
/// Digest of one light without its name.
[[nodiscard]] std::string light_digest(const Light& light);
/// Digest of the camera without its name.
[[nodiscard]] std::string camera_digest(const Camera& camera);
/// Digest of all that influences images: meshes, instances in order, lights in order, camera. Names do not count, and
/// neither does whether two instances share one mesh or hold two equal ones.
[[nodiscard]] std::string scene_digest(const Scene& scene);

}  // namespace penumbra
