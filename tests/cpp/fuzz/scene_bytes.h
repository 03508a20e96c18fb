#pragma once

#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <limits>
#include <memory>
#include <span>
#include <string>

#include "penumbra/scene.h"
#include "penumbra/settings.h"

namespace penumbra::fuzz {

/// Bytes read as scenes. All bytes are a scene, and what is read past the end is zero, so that a fuzzer's small changes
/// stay small; most numbers are multiples of 1/4, so that things touch and coincide.
class SceneBytes {
public:
    explicit SceneBytes(std::span<const std::uint8_t> bytes) : left_{bytes}, wild_{byte() % 2 == 1} {}

    /// False: all numbers are small multiples of 1/4, so that what is computed from them must be finite.
    [[nodiscard]] bool wild() const noexcept { return wild_; }
    [[nodiscard]] bool at_end() const noexcept { return left_.empty(); }

    std::uint8_t byte() {
        if (left_.empty()) {
            return 0;
        }
        const std::uint8_t value = left_.front();
        left_ = left_.subspan(1);
        return value;
    }

    bool flag() { return byte() % 8 != 7; }

    double number() {
        const std::uint8_t kind = byte();
        if (!wild_ || kind < 224) {
            return 0.25 * (static_cast<int>(kind % 64) - 32);
        }
        if (kind < 240) {
            return static_cast<double>(std::bit_cast<float>(bits<std::uint32_t>()));
        }
        if (kind < 248) {
            return std::bit_cast<double>(bits<std::uint64_t>());
        }
        constexpr double kInfinity = std::numeric_limits<double>::infinity();
        constexpr std::array kSpecial{
            std::numeric_limits<double>::quiet_NaN(), kInfinity, 1e18, -1e18, 1e-300, 1e-45, -0.0, 1e308};
        return kSpecial.at(kind % kSpecial.size());
    }

    glm::dvec3 vector() {
        const double x = number();
        const double y = number();
        return {x, y, number()};
    }

    std::shared_ptr<const Mesh> mesh() {
        auto mesh = std::make_shared<Mesh>();
        mesh->name = "mesh";
        mesh->positions_local.resize(byte() % 40);
        for (glm::vec3& position : mesh->positions_local) {
            position = glm::vec3{vector()};
        }
        mesh->triangles.resize(byte() % 64);
        const auto corner = [&] {
            const std::uint8_t index = byte();
            const std::size_t count = mesh->positions_local.size();
            return wild_ && index == 255 ? 0xffffffffU
                                         : static_cast<std::uint32_t>(count > 0 ? index % count : index % 4U);
        };
        for (glm::uvec3& triangle : mesh->triangles) {
            triangle.x = corner();
            triangle.y = corner();
            triangle.z = corner();
        }
        if (byte() % 4 == 1) {
            mesh->corner_normals_local.resize(3 * mesh->triangles.size() + (wild_ ? byte() % 2U : 0U));
            for (glm::vec3& normal : mesh->corner_normals_local) {
                normal = glm::vec3{vector()};
            }
        }
        if (byte() % 4 == 1) {
            mesh->triangle_material.resize(mesh->triangles.size() + (wild_ ? byte() % 2U : 0U), byte());
        }
        return mesh;
    }

    glm::dmat4 matrix() {
        glm::dmat4 matrix{1.0};
        if (byte() % 2 == 0) {
            matrix[3] = glm::dvec4{vector(), 1.0};
            return matrix;
        }
        for (int column = 0; column < 4; ++column) {
            matrix[column] = glm::dvec4{vector(), column == 3 ? 1.0 : 0.0};
        }
        if (wild_ && byte() % 16 == 15) {
            matrix[byte() % 4].w = number();
        }
        return matrix;
    }

    Light light() {
        Light light;
        light.name = "light";
        light.kind = static_cast<LightKind>(byte() % 7);
        light.position_ws = vector();
        light.direction_ws = vector();
        light.half_u_ws = vector();
        light.half_v_ws = vector();
        if (light.kind == LightKind::Polygon) {
            light.corners_ws.resize(byte() % 10U);
            for (glm::dvec3& corner : light.corners_ws) {
                // Convex and flat now and then: in the plane of the half axes.
                corner = light.position_ws + number() * light.half_u_ws + number() * light.half_v_ws;
            }
        }
        light.radius_m = std::abs(number());
        light.sun_angle_rad = std::abs(number()) / 4.0;
        light.spot_angle_rad = std::abs(number()) / 4.0;
        light.spot_blend = std::abs(number()) / 8.0;
        light.spot_stretch = {std::abs(number()) + (wild_ ? 0.0 : 0.25), std::abs(number()) + (wild_ ? 0.0 : 0.25)};
        light.power_w = vector();
        light.casts_shadow = flag();
        return light;
    }

    Camera camera() {
        Camera camera;
        camera.world_from_camera = matrix();
        camera.orthographic = byte() % 2 == 1;
        camera.tan_half_width = std::abs(number()) + (wild_ ? 0.0 : 0.25);
        camera.half_width_m = std::abs(number()) + (wild_ ? 0.0 : 0.25);
        camera.shift = {number(), number()};
        camera.pixel_aspect = std::abs(number()) + (wild_ ? 0.0 : 0.25);
        camera.near_m = std::abs(number()) + (wild_ ? 0.0 : 0.25);
        camera.far_m = camera.near_m + 10.0 + number();
        camera.width_px = wild_ ? static_cast<int>(bits<std::uint32_t>()) : byte() + 1;
        camera.height_px = byte() + (wild_ ? 0 : 1);
        return camera;
    }

    Scene scene() {
        Scene scene;
        const std::array meshes{mesh(), mesh()};
        const unsigned instances = byte() % 4U;
        for (unsigned i = 0; i < instances; ++i) {
            Instance instance;
            instance.name = "instance";
            instance.mesh = meshes.at(byte() % 2U);
            instance.world_from_local = matrix();
            instance.albedo = {glm::vec3{vector()}};
            instance.casts = flag();
            instance.receives = flag();
            instance.visible = flag();
            scene.instances.push_back(std::move(instance));
        }
        const unsigned lights = byte() % 3U;
        for (unsigned i = 0; i < lights; ++i) {
            scene.lights.push_back(light());
        }
        scene.camera = camera();
        return scene;
    }

    Settings settings(std::span<const SettingInfo> infos) {
        Settings settings;
        const unsigned count = byte() % 4U;
        for (unsigned i = 0; i < count; ++i) {
            const unsigned which = byte();
            const std::string id = which < infos.size() ? infos[which].id : std::string(which % 5, 'x');
            switch (byte() % 4) {
                case 0:
                    settings[id] = byte() % 2 == 1;
                    break;
                case 1:
                    settings[id] = static_cast<int>(bits<std::uint32_t>());
                    break;
                case 2:
                    settings[id] = number();
                    break;
                default:
                    settings[id] = std::string{"slope"}.substr(0, byte() % 6U);
            }
        }
        return settings;
    }

private:
    template <class T>
    T bits() {
        T value = 0;
        for (unsigned shift = 0; shift < 8 * sizeof(T); shift += 8) {
            value |= static_cast<T>(static_cast<T>(byte()) << shift);
        }
        return value;
    }

    std::span<const std::uint8_t> left_;
    bool wild_;
};

}  // namespace penumbra::fuzz
