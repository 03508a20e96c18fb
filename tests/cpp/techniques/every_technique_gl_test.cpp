#include "techniques/renderer_fixture.h"

namespace penumbra {
namespace {

struct Case {
    std::string technique;
    LightKind kind;
};

std::vector<Case> all_cases() {
    std::vector<Case> cases;
    for (const TechniqueInfo& info : techniques()) {
        for (const LightKind kind : info.lights) {
            cases.push_back({info.id, kind});
        }
    }
    return cases;
}

std::string case_name(const testing::TestParamInfo<Case>& info) {
    return info.param.technique + "_" + std::string{to_string(info.param.kind)};
}

Light light_of(LightKind kind, double size = 0.6) {
    Light light = scenes::rectangle_light({0.3, -0.2, 4.0}, size, size);
    light.kind = kind;
    switch (kind) {
        case LightKind::Point:
            light.radius_m = 0.5 * size;
            break;
        case LightKind::Spot:
            light.radius_m = 0.5 * size;
            light.half_u_ws = {1, 0, 0};
            light.half_v_ws = {0, 1, 0};
            light.spot_angle_rad = 1.2;
            break;
        case LightKind::Sun:
            light = scenes::sun_light({0.2, 0.1, -1.0}, 0.15 * size);
            break;
        case LightKind::Line:
            light.half_v_ws = glm::dvec3{0.0};
            break;
        case LightKind::Polygon: {
            const double h = 0.5 * size;
            light.corners_ws = {{0.3 - h, -0.2 - h, 4}, {0.3 + h, -0.2 - h, 4}, {0.3, -0.2 + h, 4}};
            light.half_u_ws = light.half_v_ws = glm::dvec3{0.0};
            break;
        }
        default:
            break;
    }
    return light;
}

/// A ball and a fence over a ground, seen obliquely: all that scenes have in small.
Scene small_scene(const Light& light) {
    Scene scene;
    scene.instances.push_back(scenes::place(scenes::sheet(-20, 20, -20, 20), "ground"));
    scene.instances.push_back(scenes::place(scenes::sphere(16, false), "ball", {0.4, 0.3, 1.2}));
    const auto bar = scenes::box({-0.1F, -0.1F, 0.0F}, {0.1F, 0.1F, 1.5F});
    for (int i = 0; i < 4; ++i) {
        scene.instances.push_back(scenes::place(bar, "bar " + std::to_string(i), {-1.5 + 0.5 * i, -1.0, 0.0}));
    }
    scene.lights.push_back(light);
    scene.camera = scenes::camera_from_above(3.0, 96, 72, 20.0);
    const double a = 0.6;
    const glm::dmat3 tilt{{1, 0, 0}, {0, std::cos(a), std::sin(a)}, {0, -std::sin(a), std::cos(a)}};
    scene.camera.world_from_camera = glm::dmat4{tilt};
    scene.camera.world_from_camera[3] = glm::dvec4{tilt * glm::dvec3{0, 0, 20}, 1.0};
    return scene;
}

class EveryTechnique : public RendererGl, public testing::WithParamInterface<Case> {};
INSTANTIATE_TEST_SUITE_P(Registry, EveryTechnique, testing::ValuesIn(all_cases()), case_name);

TEST_P(EveryTechnique, ReceiverWithoutOccluderIsFullyLit) {
    Scene scene = small_scene(light_of(GetParam().kind));
    scene.instances.resize(1);
    for (const bool keep : {false, true}) {
        for (const float v : visibility(scene, GetParam().technique, {}, keep)) {
            ASSERT_EQ(v, 1.0F) << "keep_everything " << keep;
        }
    }
}

TEST_P(EveryTechnique, AnEmptySceneIsFullyLit) {
    Scene scene = small_scene(light_of(GetParam().kind));
    scene.instances.clear();
    for (const bool keep : {false, true}) {
        for (const float v : visibility(scene, GetParam().technique, {}, keep)) {
            ASSERT_EQ(v, 1.0F);
        }
    }
}

TEST_P(EveryTechnique, StaysBetweenUmbraAndLitAndShowsBoth) {
    const Scene scene = small_scene(light_of(GetParam().kind));
    const std::vector<float> v = visibility(scene, GetParam().technique);
    for (const float value : v) {
        ASSERT_TRUE(value >= 0.0F && value <= 1.0F) << value;
    }
    EXPECT_EQ(*std::max_element(v.begin(), v.end()), 1.0F);
    EXPECT_EQ(*std::min_element(v.begin(), v.end()), 0.0F);
}

TEST_P(EveryTechnique, LeavingOutWorkChangesNothing) {
    const Scene scene = small_scene(light_of(GetParam().kind));
    const std::vector<float> planned = visibility(scene, GetParam().technique, {}, false);
    const std::vector<float> everything = visibility(scene, GetParam().technique, {}, true);
    EXPECT_EQ(planned, everything);
}

TEST_P(EveryTechnique, ASecondFrameIsTheSameImage) {
    const Scene scene = small_scene(light_of(GetParam().kind));
    const std::vector<float> first = visibility(scene, GetParam().technique);
    EXPECT_EQ(first, visibility(scene, GetParam().technique));
}

TEST_P(EveryTechnique, ShrinkingTheLightTendsToTheHardShadow) {
    Light tiny = light_of(GetParam().kind, 1e-7);
    Light point = light_of(GetParam().kind, 0.0);
    if (GetParam().kind == LightKind::Line || GetParam().kind == LightKind::Polygon) {
        point = scenes::point_light({0.3, -0.2, 4.0}, 0.0);
        if (GetParam().kind == LightKind::Polygon) {  // position_ws is the mean of the corners
            point.position_ws = (tiny.corners_ws[0] + tiny.corners_ws[1] + tiny.corners_ws[2]) / 3.0;
        }
    }
    const std::vector<float> soft = visibility(small_scene(tiny), GetParam().technique);
    const std::vector<float> hard = visibility(small_scene(point), GetParam().technique);
    EXPECT_LT(share_that_differs(soft, hard, 1e-3), 0.003);
}

TEST_P(EveryTechnique, ScaleTranslationAndRotationDoNotChangeTheImage) {
    const Scene scene = small_scene(light_of(GetParam().kind));
    const std::vector<float> original = visibility(scene, GetParam().technique);
    struct Move {
        const char* name;
        double scale;
        glm::dmat3 turn;
        glm::dvec3 by;
        double share;  ///< of pixels that may fall on the other side of a texel or an edge by rounding
    };
    // Scale and place change coordinates by float32 rounding only: a comparison flips where an edge falls within
    // rounding of a sample, once per map or ray, so N of them may flip in N places.
    const bool many = GetParam().technique == "light_samples" || GetParam().technique == "ray_traced" ||
                      GetParam().technique == "masked_rays";
    // Where the rim of a spot's cone falls is a matter of rounding, and the fitted map moves by a pixel with it; what
    // is kept per texel then changes by its slope over a texel.
    const bool per_texel = GetParam().technique == "penumbra_maps" && GetParam().kind == LightKind::Spot;
    const double flips = many ? 0.01 : (per_texel ? 0.03 : 0.004);
    // A turn about odd axes turns the maps' axes, so all texels fall elsewhere: pixels within a texel of an edge may
    // change. Round lights are sampled in a frame that hangs on world axes, so there noise changes as well.
    const bool round =
        GetParam().kind == LightKind::Point || GetParam().kind == LightKind::Spot || GetParam().kind == LightKind::Sun;
    const double turned = many ? (round ? 1.0 : 0.15) : 0.06;
    const Move moves[] = {
        {"scale 1e-4", 1e-4, glm::dmat3{1.0}, {}, flips},
        {"scale 1e4", 1e4, glm::dmat3{1.0}, {}, flips},
        {"moved by 1e6", 1.0, glm::dmat3{1.0}, {1e6, -1e6, 1e6}, flips},
        {"turned", 1.0, scenes::odd_turn(), {}, turned},
    };
    for (const Move& move : moves) {
        const std::vector<float> moved =
            visibility(scenes::transformed(scene, move.scale, move.turn, move.by), GetParam().technique);
        EXPECT_LE(share_that_differs(original, moved, 0.02), move.share) << move.name;
        // For noise: two independent estimates of 16 samples differ by sqrt(2) 0.36 16^-3/4 = 0.064 in a penumbra.
        EXPECT_LE(rmse(original, moved), 0.064) << move.name;
    }
}

}  // namespace
}  // namespace penumbra
