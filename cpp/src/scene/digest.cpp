#include "scene/digest.h"

#define XXH_INLINE_ALL
#include <xxhash.h>

#include <array>
#include <bit>
#include <new>
#include <unordered_map>
#include <vector>

namespace penumbra {

static_assert(std::endian::native == std::endian::little, "digests are defined over little-endian bytes");

struct Digest::State {
    XXH3_state_t* xxh = nullptr;
};

Digest::Digest() : state_{std::make_unique<State>()} {
    state_->xxh = XXH3_createState();  // it wants more alignment than operator new promises
    if (state_->xxh == nullptr) {
        throw std::bad_alloc{};
    }
    XXH3_128bits_reset(state_->xxh);
}

Digest::~Digest() {
    XXH3_freeState(state_->xxh);
}

void Digest::add_bytes(const void* data, std::size_t bytes) {
    if (bytes > 0) {
        XXH3_128bits_update(state_->xxh, data, bytes);
    }
}

void Digest::add(std::string_view text) {
    add(static_cast<std::uint64_t>(text.size()));
    add_bytes(text.data(), text.size());
}

void Digest::add(const glm::dvec2& value) {
    add(value.x);
    add(value.y);
}

void Digest::add(const glm::dvec3& value) {
    add(value.x);
    add(value.y);
    add(value.z);
}

void Digest::add(const glm::dmat4& value) {
    for (int column = 0; column < 4; ++column) {
        add(glm::dvec3{value[column]});
        add(value[column].w);
    }
}

std::string Digest::hex() const {
    XXH128_canonical_t canonical;
    XXH128_canonicalFromHash(&canonical, XXH3_128bits_digest(state_->xxh));
    constexpr std::string_view kDigits = "0123456789abcdef";
    std::string text;
    for (const unsigned char byte : canonical.digest) {
        text += kDigits[byte >> 4];
        text += kDigits[byte & 15];
    }
    return text;
}

namespace {

template <typename T>
void add_array(Digest& digest, const std::vector<T>& values) {
    static_assert(sizeof(T) == 2 || sizeof(T) == 12, "no padding");
    digest.add(static_cast<std::uint64_t>(values.size()));
    digest.add_bytes(values.data(), values.size() * sizeof(T));
}

}  // namespace

std::string mesh_digest(const Mesh& mesh) {
    Digest digest;
    add_array(digest, mesh.positions_local);
    add_array(digest, mesh.triangles);
    add_array(digest, mesh.corner_normals_local);
    add_array(digest, mesh.triangle_material);
    return digest.hex();
}

std::string light_digest(const Light& light) {
    Digest digest;
    digest.add(to_string(light.kind));  // by name, so that reordering the enumeration changes nothing
    digest.add(light.position_ws);
    digest.add(light.direction_ws);
    digest.add(light.half_u_ws);
    digest.add(light.half_v_ws);
    digest.add(static_cast<std::uint64_t>(light.corners_ws.size()));
    for (const glm::dvec3& corner : light.corners_ws) {
        digest.add(corner);
    }
    digest.add(light.radius_m);
    digest.add(light.sun_angle_rad);
    digest.add(light.spot_angle_rad);
    digest.add(light.spot_blend);
    digest.add(light.spot_stretch);
    digest.add(light.power_w);
    digest.add(light.casts_shadow);
    return digest.hex();
}

std::string camera_digest(const Camera& camera) {
    Digest digest;
    digest.add(camera.world_from_camera);
    digest.add(camera.orthographic);
    digest.add(camera.tan_half_width);
    digest.add(camera.half_width_m);
    digest.add(camera.shift);
    digest.add(camera.pixel_aspect);
    digest.add(camera.near_m);
    digest.add(camera.far_m);
    digest.add(camera.width_px);
    digest.add(camera.height_px);
    digest.add(camera.pixel_offset);
    return digest.hex();
}

std::string scene_digest(const Scene& scene) {
    Digest digest;
    std::unordered_map<const Mesh*, std::string> mesh_digests;
    digest.add(static_cast<std::uint64_t>(scene.instances.size()));
    for (const Instance& instance : scene.instances) {
        std::string& of_mesh = mesh_digests[instance.mesh.get()];
        if (of_mesh.empty()) {
            of_mesh = mesh_digest(*instance.mesh);
        }
        digest.add(of_mesh);
        digest.add(instance.world_from_local);
        add_array(digest, instance.albedo);
        digest.add(instance.casts);
        digest.add(instance.receives);
        digest.add(instance.visible);
    }
    digest.add(static_cast<std::uint64_t>(scene.lights.size()));
    for (const Light& light : scene.lights) {
        digest.add(light_digest(light));
    }
    digest.add(camera_digest(scene.camera));
    return digest.hex();
}

}  // namespace penumbra
