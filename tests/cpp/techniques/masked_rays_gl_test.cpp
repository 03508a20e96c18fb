#include <map>

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

TEST_P(MaskedRaysLights, RaysInPlaceOfMapsFindTheSamePenumbraeButForAFewFinePixels) {
    const Scene scene = garden(light_of(GetParam().kind, GetParam().size));
    renderer().set_scene(scene);
    const VisibilityResult result =
        renderer().visibility(0, {"masked_rays", {{"mask_by", std::string{"rays"}}}}, false, control_);
    EXPECT_TRUE(result.plan.runs("pilot rays"));
    EXPECT_EQ(std::ranges::find(result.plan.steps, "penumbra mask", &Step::name), result.plan.steps.end());
    std::map<std::string, double> told;
    for (const Statistic& statistic : result.statistics) {
        told[statistic.id] = statistic.value;
    }
    EXPECT_NEAR(told.at("mask_lit") + told.at("mask_umbra") + told.at("mask_maybe"), 1.0, 1e-9);
    EXPECT_GT(told.at("mask_maybe"), 0.0);
    // What wires and blades far thinner than the light do to V is missed, and little: the next line says how little.
    EXPECT_LT(told.at("mask_wrong"), 0.02);
    EXPECT_LT(rmse(result.visibility, visibility(scene, "ray_traced", {{"rays", 256}})), 0.013);
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

// --- singular places -------------------------------------------------------------------------------------------

struct Place {
    std::string name;
    Scene scene;
    bool decided = true;   ///< some pixels are sure
    bool penumbra = true;  ///< wider than a pixel
};

/// Places where a mask from maps could go wrong.
std::vector<Place> places() {
    std::vector<Place> all;
    const auto add = [&](const std::string& name, std::vector<Instance> instances, const Light& light,
                         bool decided = true, bool penumbra = true) {
        Place at{name, garden(light), decided, penumbra};
        at.scene.instances.resize(1);
        at.scene.instances.insert(at.scene.instances.end(), instances.begin(), instances.end());
        all.push_back(std::move(at));
    };
    const Light lamp = rectangle_light({0.3, -0.2, 4.0}, 0.8, 0.8);

    add("a caster close under a wide light, seen by pixels far to the side",
        {place(box({-0.1F, -0.1F, 0.0F}, {0.1F, 0.1F, 0.02F}), "chip", {1.2, 0.5, 3.7})},
        rectangle_light({0.3, -0.2, 4.0}, 2.5, 2.5), false);
    add("a slit between two sheets at different heights, closed for the light's centre",
        {place(sheet(-3, 0.31, -3, 3), "near", {0, 0, 2.5}), place(sheet(0.28, 3, -3, 3), "far", {0, 0, 1.0})}, lamp);
    add("a hole smaller than a texel, far above",
        {place(sheet(-3, 0.3, -3, 3), "left", {0, 0, 3.0}), place(sheet(0.302F, 3, -3, 3), "right", {0, 0, 3.0})},
        lamp);
    Instance paper = place(sheet(-0.7, 0.7, -0.7, 0.7), "paper", {0, 0, 1e-3});
    paper.visible = false;
    add("a sheet a hair above the ground", {paper}, lamp, true, false);
    add("a folded sheet, its fold away from the light",
        {place(mesh("fold", {{-1, -1, 1.4F}, {0, -1, 0.6F}, {1, -1, 1.4F}, {-1, 1, 1.4F}, {0, 1, 0.6F}, {1, 1, 1.4F}},
                    {{0, 1, 4}, {0, 4, 3}, {1, 2, 5}, {1, 5, 4}}),
               "fold")},
        rectangle_light({0.3, -0.2, 2.2}, 3.0, 3.0));
    add("a low sun",
        {place(box({-0.2F, -0.2F, 0.0F}, {0.2F, 0.2F, 0.7F}), "post"), place(sphere(12, false), "ball", {2, 0, 1.0})},
        sun_light({1.0, 0.2, -0.12}, 0.05));
    add("a ball on the ground", {place(sphere(24, false), "ball", {0, 0, 1.0})}, lamp);
    add("two boxes that cut through each other",
        {place(box({-0.6F, -0.6F, 0.3F}, {0.5F, 0.5F, 0.9F}), "a"),
         place(box({-0.1F, -1.0F, 0.5F}, {0.9F, 0.2F, 1.3F}), "b")},
        lamp);
    Instance room = place(box({-3.5F, -3.5F, -0.01F}, {3.5F, 3.5F, 5.0F}), "room");
    room.visible = false;
    add("a lamp in a room", {room, place(sphere(10, false), "ball", {0.8, 0.4, 1.2})},
        point_light({0.3, -0.2, 2.9}, 0.15));
    add("a caster through the light", {place(box({-0.1F, -0.1F, 0.0F}, {0.1F, 0.1F, 5.0F}), "pole", {0.3, -0.2, 0.0})},
        lamp, false);
    Instance chip = place(sheet(-1e-4F, 1e-4F, -1e-4F, 1e-4F), "chip", {0.3, -0.2, 4.0 - 1e-6});
    chip.visible = false;
    add("a chip nearer to the light than the map's depths reach", {chip}, rectangle_light({0.3, -0.2, 4.0}, 4e-4, 4e-4),
        false);
    add("a ball lamp with a collar", {place(sheet(-0.4, 0.4, -0.4, 0.4), "collar", {0.3, -0.2, 3.9})},
        point_light({0.3, -0.2, 4.0}, 0.3), false);
    return all;
}

TEST_F(MaskedRaysGl, NoPixelIsSureOfWhatIsNotSoInSingularPlaces) {
    for (const Place& at : places()) {
        const Shares shares = against_reference(at.scene);
        EXPECT_EQ(shares.wrong, 0U) << at.name << ": of " << shares.pixels << ", worst " << shares.worst;
        EXPECT_GE(shares.penumbra, at.penumbra ? 20U : 0U) << at.name;
        EXPECT_EQ(shares.maybe < shares.pixels, at.decided) << at.name << ": " << shares.maybe;
    }
}

TEST_F(MaskedRaysGl, DepthsAloneAreSureOfWhatIsNotSo) {
    // Why edges: wires thinner than a texel and slits between two surfaces are nothing to the depths of a window.
    const Shares edges = against_reference(garden(rectangle_light({0.3, -0.2, 4.0}, 0.6, 0.6)));
    const Shares depth =
        against_reference(garden(rectangle_light({0.3, -0.2, 4.0}, 0.6, 0.6)), {{"mask_test", std::string{"depth"}}});
    EXPECT_EQ(edges.wrong, 0U);
    EXPECT_GT(depth.wrong, depth.penumbra / 100);
}

TEST_F(MaskedRaysGl, EveryMapSizeIsConservativeAndLargerOnesHoldLess) {
    const Scene scene = garden(rectangle_light({0.3, -0.2, 4.0}, 0.6, 0.6));
    std::size_t before = ~std::size_t{0};
    for (const int size : {64, 256, 1000}) {
        const Shares shares = against_reference(scene, {{"mask_size", size}});
        EXPECT_EQ(shares.wrong, 0U) << size << ", worst " << shares.worst;
        EXPECT_LT(shares.maybe, before) << size;
        before = shares.maybe;
    }
}

TEST_F(MaskedRaysGl, TellsWhatTheMaskHoldsAndWhatItCost) {
    renderer().set_scene(garden(rectangle_light({0.3, -0.2, 4.0}, 0.6, 0.6)));
    std::map<std::string, double> told;
    const VisibilityResult result = renderer().visibility(0, {"masked_rays", {}}, false, control_);
    for (const Statistic& statistic : result.statistics) {
        told[statistic.id] = statistic.value;
    }
    EXPECT_NEAR(told.at("mask_lit") + told.at("mask_umbra") + told.at("mask_maybe"), 1.0, 1e-9);
    EXPECT_GT(told.at("mask_lit"), 0.2);
    EXPECT_EQ(told.at("mask_wrong"), 0.0);
    EXPECT_LE(told.at("full_share"), told.at("mask_maybe"));
    EXPECT_GE(told.at("rays_per_traced_pixel"), 16.0);
    EXPECT_LT(told.at("rays_per_traced_pixel"), 256.0);
    // Depths alone are wrong, and the rays that check say so.
    const VisibilityResult depth =
        renderer().visibility(0, {"masked_rays", {{"mask_test", std::string{"depth"}}}}, false, control_);
    const auto wrong = std::ranges::find(depth.statistics, "mask_wrong", &Statistic::id);
    ASSERT_NE(wrong, depth.statistics.end());
    EXPECT_GT(wrong->value, 0.0);
}

TEST_F(MaskedRaysGl, DebugViewsShowClassesAndBothMaps) {
    renderer().set_scene(garden(rectangle_light({0.3, -0.2, 4.0}, 0.6, 0.6)));
    const auto images = renderer().debug_images(0, {"masked_rays", {}}, {}, control_);
    ASSERT_EQ(images.size(), 3U);
    for (const NamedDebugImage& named : images) {
        EXPECT_EQ(named.image.rgb.size(), static_cast<std::size_t>(named.image.width_px * named.image.height_px));
        const auto [least, most] = std::ranges::minmax(named.image.rgb, {}, &glm::vec3::x);
        EXPECT_LT(least.x, most.x) << named.view.id;
    }
}

TEST_F(MaskedRaysGl, ALightWithoutExtentHasNoMaskAndOneRay) {
    renderer().set_scene(garden(point_light({0.3, -0.2, 4.0}, 0.0)));
    const VisibilityResult result = renderer().visibility(0, {"masked_rays", {}}, false, control_);
    EXPECT_FALSE(result.plan.runs("penumbra mask"));
    EXPECT_EQ(result.visibility, visibility(garden(point_light({0.3, -0.2, 4.0}, 0.0)), "ray_traced"));
    const VisibilityResult by_rays =
        renderer().visibility(0, {"masked_rays", {{"mask_by", std::string{"rays"}}}}, false, control_);
    EXPECT_FALSE(by_rays.plan.runs("pilot rays"));
    EXPECT_EQ(by_rays.visibility, result.visibility);
}

}  // namespace
}  // namespace penumbra
