#include "irradiance_glsl.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>

#include "geometry/irradiance.h"
#include "geometry/radiometry.h"

namespace penumbra {
namespace {

constexpr double kPi = std::numbers::pi;

struct Random {
    std::mt19937 engine{77};
    double in(double low, double high) { return std::uniform_real_distribution<double>{low, high}(engine); }
    glm::dvec3 vector() { return {in(-1.0, 1.0), in(-1.0, 1.0), in(-1.0, 1.0)}; }
    glm::dvec3 unit() {
        glm::dvec3 v = vector();
        while (glm::length(v) < 0.1 || glm::length(v) > 1.0) {
            v = vector();
        }
        return glm::normalize(v);
    }
};

Light random_light(LightKind kind, double scale, Random& random) {
    Light light;
    light.kind = kind;
    light.position_ws = scale * 3.0 * random.unit();
    light.half_u_ws = scale * random.vector();
    light.half_v_ws = scale * random.vector();
    light.radius_m = scale * random.in(0.05, 2.5);
    light.sun_angle_rad = random.in(0.01, kPi);
    light.direction_ws = random.unit();
    if (kind == LightKind::Rectangle || kind == LightKind::Ellipse) {
        light.direction_ws = glm::normalize(glm::cross(light.half_u_ws, light.half_v_ws));
    }
    if (kind == LightKind::Polygon) {
        const int corners = 3 + static_cast<int>(random.in(0.0, 5.99));
        for (int i = 0; i < corners; ++i) {
            const double t = 2.0 * kPi * i / corners;
            light.corners_ws.push_back(light.position_ws + std::cos(t) * light.half_u_ws +
                                       std::sin(t) * light.half_v_ws);
        }
        light.direction_ws = glm::normalize(glm::cross(light.half_u_ws, light.half_v_ws));
    }
    return light;
}

constexpr LightKind kKinds[] = {LightKind::Point,   LightKind::Sun,  LightKind::Rectangle,
                                LightKind::Ellipse, LightKind::Line, LightKind::Polygon};

TEST(IrradianceGlsl, EqualsTheFloat64FormToFloat32AtAllScales) {
    Random random;
    for (const LightKind kind : kKinds) {
        double worst = 0.0;
        for (const double scale : {1e-4, 1.0, 1e4}) {
            for (int i = 0; i < 3000; ++i) {
                const Light light = random_light(kind, scale, random);
                const gpu::LightBlock block = light_block(light, glm::dvec3{0.0});
                const glm::dvec3 n = random.unit();
                const double exact = irradiance_per_radiance(light, glm::dvec3{0.0}, n);
                const double value = test::glsl_irradiance_per_radiance(block, glm::vec3{0.0F}, glm::vec3{n});
                ASSERT_TRUE(std::isfinite(value) && value >= 0.0) << to_string(kind) << ' ' << i;
                const double unit = kind == LightKind::Line ? 1.0 / scale : 1.0;
                worst = std::max(worst, std::abs(value - exact) / unit);
            }
        }
        // Of a full hemisphere's pi, and for lines of the 1 / m at the scene's scale.
        EXPECT_LT(worst, 5e-6) << to_string(kind);
        RecordProperty("worst_" + std::string{to_string(kind)}, testing::PrintToString(worst));
    }
}

TEST(IrradianceGlsl, KeepsItsRelativeDigitsForTinyAndFarLights) {
    Random random;
    for (const LightKind kind : kKinds) {
        if (kind == LightKind::Sun) {
            continue;
        }
        double worst = 0.0;
        for (int i = 0; i < 4000; ++i) {
            Light light = random_light(kind, 1.0, random);
            const double far = std::pow(10.0, random.in(1.5, 6.0));
            const glm::dvec3 move = far * random.unit() - light.position_ws;
            light.position_ws += move;
            for (glm::dvec3& corner : light.corners_ws) {
                corner += move;
            }
            const glm::dvec3 towards = glm::normalize(light.position_ws);
            if (glm::dot(light.direction_ws, towards) > 0.0) {
                light.direction_ws = -light.direction_ws;
            }
            const glm::dvec3 n = glm::normalize(towards + 0.5 * random.vector());
            const double exact = irradiance_per_radiance(light, glm::dvec3{0.0}, n);
            if (std::abs(glm::dot(light.direction_ws, towards)) < 0.05 || !(exact > 0.0)) {
                continue;
            }
            const double value =
                test::glsl_irradiance_per_radiance(light_block(light, glm::dvec3{0.0}), glm::vec3{0.0F}, glm::vec3{n});
            worst = std::max(worst, std::abs(value / exact - 1.0));
        }
        EXPECT_LT(worst, 3e-5) << to_string(kind);
        RecordProperty("worst_" + std::string{to_string(kind)}, testing::PrintToString(worst));
    }
}

TEST(IrradianceGlsl, IsFiniteOnAndAroundEveryLight) {
    Random random;
    for (const LightKind kind : kKinds) {
        for (int i = 0; i < 4000; ++i) {
            Light light = random_light(kind, 1.0, random);
            if (i % 3 == 0) {
                light.half_v_ws *= std::pow(10.0, random.in(-10.0, 0.0));
            }
            const glm::dvec3 p = light.position_ws + random.in(-1.5, 1.5) * light.half_u_ws +
                                 random.in(-1.5, 1.5) * light.half_v_ws +
                                 (i % 2 == 0 ? 0.0 : std::pow(10.0, random.in(-9.0, 0.0))) * light.direction_ws;
            const float value =
                test::glsl_irradiance_per_radiance(light_block(light, p), glm::vec3{0.0F}, glm::vec3{random.unit()});
            ASSERT_TRUE(std::isfinite(value) && value >= 0.0F) << to_string(kind) << ' ' << i;
            if (kind != LightKind::Line && form_of(light) != LightForm::FacingLine) {
                ASSERT_LE(value, 3.15F) << to_string(kind) << ' ' << i;
            }
        }
    }
}

TEST(IrradianceGlsl, LightsWithoutExtentEqualTheFloat64Form) {
    Random random;
    for (const LightKind kind : kKinds) {
        for (int i = 0; i < 200; ++i) {
            Light light = random_light(kind, 1.0, random);
            light.radius_m = 0.0;
            light.sun_angle_rad = 0.0;
            light.half_v_ws = glm::dvec3{0.0};
            if (i % 2 == 0 || kind == LightKind::Line) {
                light.half_u_ws = glm::dvec3{0.0};
            } else {
                light.direction_ws = glm::normalize(light.direction_ws -
                                                    light.half_u_ws * (glm::dot(light.half_u_ws, light.direction_ws) /
                                                                       glm::dot(light.half_u_ws, light.half_u_ws)));
            }
            for (glm::dvec3& corner : light.corners_ws) {
                corner = light.position_ws + random.in(-1.0, 1.0) * light.half_u_ws;
            }
            const glm::dvec3 n = random.unit();
            const double exact = irradiance_per_radiance(light, glm::dvec3{0.0}, n);
            const double value =
                test::glsl_irradiance_per_radiance(light_block(light, glm::dvec3{0.0}), glm::vec3{0.0F}, glm::vec3{n});
            EXPECT_NEAR(value, exact, 1e-5 * (1.0 + exact)) << to_string(kind) << ' ' << i;
        }
    }
}

TEST(IrradianceGlsl, SpotConeEqualsTheFloat64Form) {
    Random random;
    for (int i = 0; i < 5000; ++i) {
        Light light;
        light.kind = LightKind::Spot;
        light.direction_ws = random.unit();
        light.half_u_ws = glm::normalize(glm::cross(light.direction_ws, random.unit()));
        light.half_v_ws = glm::cross(light.half_u_ws, light.direction_ws);
        light.spot_angle_rad = random.in(0.05, kPi);
        light.spot_blend = random.in(0.05, 1.0);
        light.spot_stretch = {random.in(0.2, 3.0), random.in(0.2, 3.0)};
        light.position_ws = random.unit();
        const glm::dvec3 p = light.position_ws + light.direction_ws * 1.5 + random.vector();
        const double exact = spot_attenuation(light, p);
        const glm::dvec3 eye{1.0, 2.0, 3.0};
        // The smoothstep's slope in the cosine is 1.5 / ((1 - rim) blend).
        const double slope = 1.5 / ((1.0 - std::cos(0.5 * light.spot_angle_rad)) * light.spot_blend);
        EXPECT_NEAR(test::glsl_spot_attenuation(light_block(light, eye), glm::vec3{p - eye}), exact,
                    2e-6 * (1.0 + slope));
    }
}

}  // namespace
}  // namespace penumbra
