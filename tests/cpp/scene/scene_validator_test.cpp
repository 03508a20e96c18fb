#include "scene/scene_validator.h"

#include <limits>

#include "scenes.h"

namespace penumbra {
namespace {

using test::instance_of;
using test::refusal;
using test::square_mesh;
using test::square_scene;
using testing::HasSubstr;
using testing::IsEmpty;

constexpr float kNan = std::numeric_limits<float>::quiet_NaN();

/// A scene of one mesh that the test may spoil behind the validator's back, to see whether it is looked at.
struct Spoilt {
    std::shared_ptr<Mesh> mesh = std::make_shared<Mesh>(square_mesh());
    Scene scene = square_scene();
    Spoilt() { scene.instances[0].mesh = mesh; }
};

TEST(SceneValidator, LooksThroughAMeshOnceForManyScenes) {
    Spoilt spoilt;
    SceneValidator validator;
    EXPECT_THAT(refusal([&] { validator.validate(spoilt.scene); }), IsEmpty());
    spoilt.mesh->positions_local[0].x = kNan;
    EXPECT_THAT(refusal([&] { validator.validate(spoilt.scene); }), IsEmpty()) << "it was in the scene before";
    EXPECT_THAT(refusal([&] { validate(spoilt.scene); }), HasSubstr("nan")) << "who knows no scene before looks";
}

TEST(SceneValidator, ForgetsWhatTheSceneBeforeLacked) {
    Spoilt spoilt;
    SceneValidator validator;
    validator.validate(spoilt.scene);
    Scene other = square_scene();
    validator.validate(other);
    spoilt.mesh->positions_local[0].x = kNan;
    EXPECT_THAT(refusal([&] { validator.validate(spoilt.scene); }), HasSubstr("nan"));
}

TEST(SceneValidator, ChecksEveryTransformAndColourOfKnownMeshesToo) {
    Scene scene = square_scene();
    SceneValidator validator;
    validator.validate(scene);
    Scene far = scene;
    far.instances[0].world_from_local[0].x = 2e18;  // the mesh reaches 1 along x: known from the scene before
    EXPECT_THAT(refusal([&] { validator.validate(far); }), HasSubstr("reaches as far as"));
    Scene flat = scene;
    flat.instances[0].world_from_local[1] = {};
    EXPECT_THAT(refusal([&] { validator.validate(flat); }), HasSubstr("singular"));
    Scene colourless = scene;
    colourless.instances[0].albedo[0].y = kNan;
    EXPECT_THAT(refusal([&] { validator.validate(colourless); }), HasSubstr("albedo 0"));
}

TEST(SceneValidator, ARefusedSceneDoesNotCountAsTheOneBefore) {
    Spoilt spoilt;
    spoilt.scene.camera.near_m = -1.0;
    SceneValidator validator;
    EXPECT_THAT(refusal([&] { validator.validate(spoilt.scene); }), HasSubstr("near"));
    spoilt.scene.camera.near_m = 0.1;
    spoilt.mesh->positions_local[0].x = kNan;
    EXPECT_THAT(refusal([&] { validator.validate(spoilt.scene); }), HasSubstr("nan"));
}

TEST(SceneValidator, NormalisesTheLightsOfEveryScene) {
    Scene scene = square_scene();
    scene.lights[0].kind = LightKind::Spot;
    scene.lights[0].direction_ws = {0, 0, -3};
    scene.lights[0].half_u_ws = {2, 0, 0};
    scene.lights[0].half_v_ws = {0, 2, 0};
    SceneValidator validator;
    for (int time = 0; time < 2; ++time) {
        Scene copy = scene;
        validator.validate(copy);
        EXPECT_EQ(copy.lights[0].direction_ws, glm::dvec3(0, 0, -1));
    }
}

}  // namespace
}  // namespace penumbra
