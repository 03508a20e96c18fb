#include "techniques/renderer_fixture.h"

namespace penumbra {
namespace {

using namespace scenes;

enum class Class { NotAsked, Maybe, Lit, Umbra };

struct Shares {
    std::size_t pixels = 0, penumbra = 0, maybe = 0, wrong = 0;
    float worst = 0.0F;  ///< |V - the class's V| where it is wrong
};

class MaskedRaysGl : public RendererGl {
protected:
    std::vector<Class> classes(const Settings& settings = {}) {
        const std::vector<std::string> view{"mask"};
        const DebugImage image = renderer().debug_images(0, {"masked_rays", settings}, view, control_).front().image;
        std::vector<Class> all;
        for (const glm::vec3& colour : image.rgb) {
            all.push_back(colour == glm::vec3{1.0F}   ? Class::Lit
                          : colour == glm::vec3{0.0F} ? Class::Umbra
                          : colour.z < 0.2F           ? Class::Maybe
                                                      : Class::NotAsked);
        }
        return all;
    }
    /// Classes against the reference: exact where the light is polygonal, else ray traced.
    Shares against_reference(const Scene& scene, const Settings& settings = {}) {
        renderer().set_scene(scene);
        const LightKind kind = scene.lights.front().kind;
        ReferenceOptions options{.standard_error = 0.01};
        if (kind == LightKind::Rectangle || kind == LightKind::Polygon) {
            options.method = ReferenceMethod::Exact;
        }
        const Reference truth = renderer().reference(0, options, control_);
        const std::vector<Class> found = classes(settings);
        Shares shares;
        for (std::size_t i = 0; i < found.size(); ++i) {
            if (truth.mask[i] == 0) {
                continue;
            }
            ++shares.pixels;
            const float v = truth.area[i];
            shares.penumbra += v > 1e-4F && v < 1.0F - 1e-4F ? 1 : 0;
            shares.maybe += found[i] == Class::Maybe ? 1 : 0;
            const float error = found[i] == Class::Lit ? 1.0F - v : (found[i] == Class::Umbra ? v : 0.0F);
            if (error > 1e-4F) {
                ++shares.wrong;
                shares.worst = std::max(shares.worst, error);
            }
        }
        return shares;
    }
};

Camera slanted_camera(int width_px = 160, int height_px = 120) {
    Camera camera = camera_from_above(3.0, width_px, height_px, 20.0);
    const double a = 0.6;
    const glm::dmat3 tilt{{1, 0, 0}, {0, std::cos(a), std::sin(a)}, {0, -std::sin(a), std::cos(a)}};
    camera.world_from_camera = glm::dmat4{tilt};
    camera.world_from_camera[3] = glm::dvec4{tilt * glm::dvec3{0, 0, 20}, 1.0};
    return camera;
}

Light light_of(LightKind kind, double size) {
    Light light = rectangle_light({0.3, -0.2, 4.0}, size, size);
    light.kind = kind;
    if (kind == LightKind::Point || kind == LightKind::Spot) {
        light.radius_m = 0.5 * size;
        light.half_u_ws = {1, 0, 0};
        light.half_v_ws = {0, 1, 0};
        light.spot_angle_rad = 1.2;
    } else if (kind == LightKind::Sun) {
        return sun_light({0.2, 0.1, -1.0}, 0.15 * size);
    } else if (kind == LightKind::Line) {
        light.half_v_ws = glm::dvec3{0.0};
    } else if (kind == LightKind::Polygon) {
        const double h = 0.5 * size;
        light.corners_ws = {{0.3 - h, -0.2 - h, 4}, {0.3 + h, -0.2 - h, 4}, {0.3, -0.2 + h, 4}};
        light.position_ws = (light.corners_ws[0] + light.corners_ws[1] + light.corners_ws[2]) / 3.0;
        light.half_u_ws = light.half_v_ws = glm::dvec3{0.0};
    }
    return light;
}

/// A ball, a fence, blades thinner than a texel of the mask's map and a board that all but touches the ground.
Scene garden(const Light& light) {
    Scene scene;
    scene.instances.push_back(place(sheet(-20, 20, -20, 20), "ground"));
    scene.instances.push_back(place(sphere(16, false), "ball", {0.9, 0.5, 1.2}));
    const auto bar = box({-0.1F, -0.1F, 0.0F}, {0.1F, 0.1F, 1.5F});
    const auto wire = box({-0.002F, -0.002F, 0.0F}, {0.002F, 0.002F, 1.2F});
    const auto blade = mesh("blade", {{-0.01F, 0, 0}, {0.01F, 0, 0}, {0, 0.1F, 0.9F}}, {{0, 1, 2}});
    for (int i = 0; i < 4; ++i) {
        scene.instances.push_back(place(bar, "bar " + std::to_string(i), {-1.5 + 0.5 * i, -1.0, 0.0}));
        scene.instances.push_back(place(wire, "wire " + std::to_string(i), {-1.6 + 0.3 * i, 0.9, 0.0}));
        scene.instances.push_back(place(blade, "blade " + std::to_string(i), {-1.8 + 0.25 * i, 0.1, 0.0}));
    }
    scene.instances.push_back(place(box({-0.4F, -0.3F, 0.001F}, {0.4F, 0.3F, 0.03F}), "board", {1.2, -1.2, 0.0}));
    scene.lights.push_back(light);
    scene.camera = slanted_camera();
    return scene;
}

struct Lamp {
    LightKind kind;
    double size;
};

std::string lamp_name(const testing::TestParamInfo<Lamp>& lamp) {
    return std::string{to_string(lamp.param.kind)} + std::to_string(static_cast<int>(100 * lamp.param.size));
}

class MaskedRaysLights : public MaskedRaysGl, public testing::WithParamInterface<Lamp> {};
INSTANTIATE_TEST_SUITE_P(Kinds, MaskedRaysLights,
                         testing::Values(Lamp{LightKind::Rectangle, 0.6}, Lamp{LightKind::Rectangle, 0.05},
                                         Lamp{LightKind::Rectangle, 3.0}, Lamp{LightKind::Ellipse, 0.6},
                                         Lamp{LightKind::Line, 0.6}, Lamp{LightKind::Polygon, 0.6},
                                         Lamp{LightKind::Point, 0.6}, Lamp{LightKind::Spot, 0.4},
                                         Lamp{LightKind::Sun, 0.6}),
                         lamp_name);

TEST_P(MaskedRaysLights, NoPixelIsSureOfWhatIsNotSo) {
    const Shares shares = against_reference(garden(light_of(GetParam().kind, GetParam().size)));
    EXPECT_EQ(shares.wrong, 0U) << "of " << shares.pixels << ", worst " << shares.worst;
    EXPECT_GT(shares.penumbra, 100U);
    EXPECT_LT(shares.maybe, shares.pixels) << "a mask that holds everything is none";
}

TEST_P(MaskedRaysLights, EqualsRayTracedWithinItsNoise) {
    const Scene scene = garden(light_of(GetParam().kind, GetParam().size));
    const std::vector<float> masked = visibility(scene, "masked_rays", {{"rays", 256}});
    const std::vector<float> traced = visibility(scene, "ray_traced", {{"rays", 256}});
    // Two independent estimates of 256 stratified samples: sqrt(2) 0.46 256^-3/4 = 0.010 at most in a penumbra.
    EXPECT_LT(rmse(masked, traced), 0.010);
}

// The sure pixels take what the light's centre sees, which a map of their own decides; the others are the same to the
// bit. What differs are texels at contacts, where the sampled maps leak or darken.
TEST_P(MaskedRaysLights, LightSamplesUnderTheMaskDifferAtNoPixelThatMayBeInAPenumbra) {
    const Scene scene = garden(light_of(GetParam().kind, GetParam().size));
    const std::vector<float> all = visibility(scene, "light_samples", {{"samples", 16}});
    const std::vector<float> masked = visibility(scene, "light_samples", {{"samples", 16}, {"mask", true}});
    const std::vector<Class> found = classes();
    std::size_t differ = 0;
    for (std::size_t i = 0; i < all.size(); ++i) {
        if (found[i] == Class::Lit || found[i] == Class::Umbra) {
            EXPECT_EQ(masked[i], found[i] == Class::Lit ? 1.0F : 0.0F);
            differ += masked[i] != all[i] ? 1 : 0;
        } else {
            EXPECT_EQ(masked[i], all[i]);
        }
    }
    EXPECT_LT(static_cast<double>(differ), 0.01 * static_cast<double>(all.size()));
}

TEST_F(MaskedRaysGl, ALightWithoutExtentHasNoMaskAndOneRay) {
    renderer().set_scene(garden(point_light({0.3, -0.2, 4.0}, 0.0)));
    const VisibilityResult result = renderer().visibility(0, {"masked_rays", {}}, false, control_);
    EXPECT_FALSE(result.plan.runs("penumbra mask"));
    EXPECT_EQ(result.visibility, visibility(garden(point_light({0.3, -0.2, 4.0}, 0.0)), "ray_traced"));
}

}  // namespace
}  // namespace penumbra
