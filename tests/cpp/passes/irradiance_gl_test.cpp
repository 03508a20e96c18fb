// shaders/lib/irradiance.glsl on the device against its float64 original in geometry/irradiance.h.
#include "geometry/irradiance.h"

#include <gtest/gtest.h>

#include <optional>
#include <random>

#include "geometry/light_block.h"
#include "gl/buffer.h"
#include "gl/render_thread.h"
#include "support/scenes.h"
#include "support/skip.h"

namespace penumbra {
namespace {

const ShaderSources& sources() {
    static const ShaderSources all = [] {
        ShaderSources made = embedded_shaders();
        made["irradiance_test.comp"] =
            "#include \"lib/irradiance.glsl\"\n"
            "layout(local_size_x = 64) in;\n"
            "layout(std140, binding = 0) uniform Lights { LightBlock light; };\n"
            "layout(std430, binding = 0) readonly buffer In { vec4 receivers[]; };\n"
            "layout(std430, binding = 1) writeonly buffer Out { vec2 results[]; };\n"
            "void main() {\n"
            "    uint i = gl_GlobalInvocationID.x;\n"
            "    if (2u * i + 1u >= uint(receivers.length())) { return; }\n"
            "    vec3 p = receivers[2u * i].xyz;\n"
            "    results[i] = vec2(irradiance_per_radiance(light, p, receivers[2u * i + 1u].xyz),\n"
            "                      spot_attenuation(light, p));\n"
            "}\n";
        return made;
    }();
    return all;
}

std::vector<Light> one_of_each() {
    std::vector<Light> lights;
    lights.push_back(scenes::point_light({0.2, 0.1, 2.0}, 0.4));
    lights.push_back(scenes::point_light({0.2, 0.1, 2.0}, 0.0));
    lights.push_back(scenes::sun_light({0.3, 0.2, -1.0}, 0.3));
    lights.push_back(scenes::rectangle_light({0.2, 0.1, 2.0}, 1.0, 0.5));
    lights.push_back(lights.back());
    lights.back().kind = LightKind::Ellipse;
    lights.push_back(lights[3]);
    lights.back().kind = LightKind::Line;
    lights.back().half_v_ws = glm::dvec3{0.0};
    Light triangle = lights[3];
    triangle.kind = LightKind::Polygon;
    triangle.corners_ws = {{-0.5, -0.5, 2.0}, {0.5, -0.5, 2.2}, {0.0, 0.6, 2.1}};
    lights.push_back(triangle);
    Light spot = lights[0];
    spot.kind = LightKind::Spot;
    spot.spot_angle_rad = 1.4;
    spot.half_u_ws = {1, 0, 0};
    spot.half_v_ws = {0, 1, 0};
    lights.push_back(spot);
    Scene scene;
    scene.lights = lights;
    validate(scene);
    return scene.lights;
}

TEST(IrradianceGl, TheShaderAgreesWithFloat64ForEveryKindOfLight) {
    std::optional<RenderThread> thread;
    try {
        thread.emplace();
    } catch (const DeviceError& error) {
        PENUMBRA_SKIP(error.what());
    }
    std::mt19937 random{11};
    std::uniform_real_distribution<float> place{-2.0F, 2.0F}, unit{-1.0F, 1.0F};
    constexpr int kCount = 2000;
    std::vector<glm::vec4> receivers;
    for (int i = 0; i < kCount; ++i) {
        receivers.emplace_back(place(random), place(random), 0.5F * place(random), 1.0F);
        receivers.emplace_back(glm::normalize(glm::vec3{unit(random), unit(random), unit(random) + 0.5F}), 0.0F);
    }
    for (const Light& light : one_of_each()) {
        const std::vector<glm::vec2> shader = thread->run([&](Device&) {
            ProgramLibrary programs{sources()};
            const auto block = light_block(light, glm::dvec3{0.0});
            const StorageBuffer uniform = StorageBuffer::from(std::span{&block, 1}, "light");
            const StorageBuffer in = StorageBuffer::from(receivers, "receivers");
            const StorageBuffer out(kCount * sizeof(glm::vec2), "results");
            uniform.bind_uniform(0);
            in.bind_storage(0);
            out.bind_storage(1);
            programs.get({"irradiance_test.comp"}).use();
            glDispatchCompute((kCount + 63) / 64, 1, 1);
            StorageBuffer::barrier();
            return out.read<glm::vec2>();
        });
        double largest = 0.0, brightest = 0.0;
        for (int i = 0; i < kCount; ++i) {
            const glm::dvec3 p{receivers[static_cast<std::size_t>(2 * i)]};
            const glm::dvec3 n = glm::normalize(glm::dvec3{receivers[static_cast<std::size_t>(2 * i + 1)]});
            const glm::vec2& got = shader[static_cast<std::size_t>(i)];
            ASSERT_TRUE(std::isfinite(got.x) && std::isfinite(got.y)) << to_string(light.kind);
            const double expected = irradiance_per_radiance(light, p, n);
            largest = std::max(largest, std::abs(got.x - expected));
            brightest = std::max(brightest, expected);
            EXPECT_NEAR(got.y, spot_attenuation(light, p), 1e-4) << to_string(light.kind);
        }
        EXPECT_GT(brightest, 0.0) << to_string(light.kind);
        EXPECT_LE(largest, 2e-5 * std::max(1.0, brightest)) << to_string(light.kind);
    }
}

}  // namespace
}  // namespace penumbra
