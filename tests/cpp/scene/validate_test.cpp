#include <functional>
#include <glm/gtc/matrix_transform.hpp>
#include <limits>

#include "scenes.h"

namespace penumbra {
namespace {

using test::instance_of;
using test::refusal;
using test::square_mesh;
using test::square_scene;
using testing::AllOf;
using testing::HasSubstr;
using testing::IsEmpty;

constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
constexpr float kInf = std::numeric_limits<float>::infinity();

std::string refusal_of(const Mesh& mesh) {
    return refusal([&] { validate(mesh); });
}
std::string refusal_of(const Instance& instance) {
    return refusal([&] { validate(instance); });
}
std::string refusal_of(Camera camera) {
    return refusal([&] { validate(camera); });
}
std::string refusal_of(Scene scene) {
    return refusal([&] { validate(scene); });
}

TEST(ValidateMesh, PassesAnEmptyMesh) {
    EXPECT_THAT(refusal_of(Mesh{}), IsEmpty());
}

TEST(ValidateMesh, NamesTheFirstPositionThatIsNotANumber) {
    Mesh mesh = square_mesh();
    mesh.positions_local[2].y = kNan;
    mesh.positions_local[3].x = kNan;
    EXPECT_THAT(refusal_of(mesh), AllOf(HasSubstr("mesh \"Square\""), HasSubstr("position 2"), HasSubstr("nan")));
}

TEST(ValidateMesh, RefusesInfinitePositionsAnywhere) {
    for (std::size_t i = 0; i < 4; ++i) {
        for (int axis = 0; axis < 3; ++axis) {
            Mesh mesh = square_mesh();
            mesh.positions_local[i][axis] = -kInf;
            EXPECT_THAT(refusal_of(mesh), HasSubstr("position " + std::to_string(i)));
        }
    }
}

TEST(ValidateMesh, TakesTheLargestAndTheSmallestFiniteFloats) {
    Mesh mesh = square_mesh();
    mesh.positions_local[0] = {std::numeric_limits<float>::max(), std::numeric_limits<float>::denorm_min(), -0.0F};
    EXPECT_THAT(refusal_of(mesh), IsEmpty());
}

TEST(ValidateMesh, NamesTheTriangleWhoseIndexIsOutOfRange) {
    Mesh mesh = square_mesh();
    mesh.triangles[1].z = 4;
    EXPECT_THAT(refusal_of(mesh), AllOf(HasSubstr("triangle 1"), HasSubstr("position 4"), HasSubstr("there are 4")));
}

TEST(ValidateMesh, RefusesTrianglesWithoutPositions) {
    Mesh mesh = square_mesh();
    mesh.positions_local.clear();
    EXPECT_THAT(refusal_of(mesh), HasSubstr("there are 0"));
}

TEST(ValidateMesh, WantsThreeCornerNormalsPerTriangleOrNone) {
    Mesh mesh = square_mesh();
    mesh.corner_normals_local.assign(6, glm::vec3{0, 0, 1});
    EXPECT_THAT(refusal_of(mesh), IsEmpty());
    mesh.corner_normals_local.pop_back();
    EXPECT_THAT(refusal_of(mesh), AllOf(HasSubstr("5 corner normals"), HasSubstr("give none or 6")));
    mesh.corner_normals_local.assign(6, glm::vec3{0, 0, kNan});
    EXPECT_THAT(refusal_of(mesh), HasSubstr("corner normal 0"));
}

TEST(ValidateMesh, WantsOneMaterialPerTriangleOrNone) {
    Mesh mesh = square_mesh();
    mesh.triangle_material = {0, 7};
    EXPECT_THAT(refusal_of(mesh), IsEmpty());
    mesh.triangle_material = {0};
    EXPECT_THAT(refusal_of(mesh), AllOf(HasSubstr("1 material indices"), HasSubstr("give none or 2")));
}

TEST(ValidateInstance, WantsAMesh) {
    Instance instance;
    instance.name = "Ghost";
    EXPECT_THAT(refusal_of(instance), AllOf(HasSubstr("\"Ghost\""), HasSubstr("no mesh")));
    Scene scene = square_scene();
    scene.instances.push_back(instance);
    EXPECT_THAT(refusal_of(scene), HasSubstr("no mesh"));
}

TEST(ValidateInstance, WantsAFiniteAlbedo) {
    Instance instance = instance_of(square_mesh());
    instance.albedo.clear();
    EXPECT_THAT(refusal_of(instance), HasSubstr("albedo is empty"));
    instance.albedo = {{0.5F, 0.5F, 0.5F}, {0.5F, kInf, 0.5F}};
    EXPECT_THAT(refusal_of(instance), HasSubstr("albedo 1"));
}

TEST(ValidateInstance, RefusesAScaleOfZeroAndSaysWhichInstance) {
    Instance instance = instance_of(square_mesh(), "Curtain");
    instance.world_from_local = glm::scale(glm::dmat4{1.0}, glm::dvec3{2.0, 0.0, 3.0});
    EXPECT_THAT(refusal_of(instance), AllOf(HasSubstr("\"Curtain\""), HasSubstr("singular"), HasSubstr("(2, 0, 3)")));
}

TEST(ValidateInstance, RefusesColumnsThatLieInOnePlane) {
    Instance instance = instance_of(square_mesh());
    instance.world_from_local[2] = instance.world_from_local[0] + instance.world_from_local[1];
    EXPECT_THAT(refusal_of(instance), HasSubstr("singular"));
}

TEST(ValidateInstance, TakesEveryScaleOverTwoHundredDecadesBothHands) {
    Mesh point = square_mesh();
    for (glm::vec3& position : point.positions_local) {
        position *= 1e-20F;
    }
    for (const double scale : {1e-100, 1e-8, 1.0, 1e8, 1e30}) {
        for (const double hand : {-1.0, 1.0}) {
            Instance instance = instance_of(point);
            instance.world_from_local = glm::scale(glm::dmat4{1.0}, glm::dvec3{scale, hand * scale, 1e3 * scale});
            EXPECT_THAT(refusal_of(instance), IsEmpty()) << scale << ' ' << hand;
        }
    }
}

TEST(ValidateInstance, TakesShear) {
    Instance instance = instance_of(square_mesh());
    instance.world_from_local[1] += 100.0 * instance.world_from_local[0];
    EXPECT_THAT(refusal_of(instance), IsEmpty());
}

TEST(ValidateInstance, RefusesPerspectiveAndNotANumber) {
    Instance instance = instance_of(square_mesh());
    instance.world_from_local[1][3] = 0.1;
    EXPECT_THAT(refusal_of(instance), HasSubstr("not affine"));
    instance.world_from_local = glm::dmat4{1.0};
    instance.world_from_local[3][2] = static_cast<double>(kNan);
    EXPECT_THAT(refusal_of(instance), AllOf(HasSubstr("row 2"), HasSubstr("column 3")));
}

TEST(ValidateInstance, RefusesWorldPositionsWhoseSquaresLeaveFloat32) {
    Instance instance = instance_of(square_mesh());
    instance.world_from_local = glm::scale(glm::dmat4{1.0}, glm::dvec3{1e19});
    EXPECT_THAT(refusal_of(instance), HasSubstr("keep it within"));
}

TEST(ValidateScene, PassesAnEmptyScene) {
    EXPECT_THAT(refusal_of(Scene{}), IsEmpty());
}

TEST(ValidateScene, NormalisesLightsAndCamera) {
    Scene scene = square_scene();
    scene.lights[0].kind = LightKind::Sun;
    scene.lights[0].direction_ws = {0, 0, -20};
    scene.camera.world_from_camera = glm::scale(glm::dmat4{1.0}, glm::dvec3{5.0});
    validate(scene);
    test::expect_near(scene.lights[0].direction_ws, {0, 0, -1}, 0.0);
    EXPECT_EQ(scene.camera.world_from_camera, glm::dmat4{1.0});
}

TEST(ValidateScene, ChecksEachSharedMeshThroughEveryInstance) {
    Scene scene = square_scene();
    scene.instances.push_back(scene.instances[0]);
    scene.instances[1].name = "Second";
    scene.instances[1].world_from_local[0] = glm::dvec4{0.0};
    EXPECT_THAT(refusal_of(scene), HasSubstr("\"Second\""));
}

TEST(ValidateCamera, TakesScaleOutAndKeepsPlaceAndView) {
    Camera camera;
    const glm::dmat4 rigid = glm::rotate(glm::translate(glm::dmat4{1.0}, glm::dvec3{1e6, 2.0, 3.0}), 1.1,
                                         glm::normalize(glm::dvec3{1, 2, 3}));
    camera.world_from_camera = glm::scale(rigid, glm::dvec3{1e-4, 20.0, 3.0});
    validate(camera);
    for (int column = 0; column < 4; ++column) {
        test::expect_near(glm::dvec3{camera.world_from_camera[column]}, glm::dvec3{rigid[column]}, 1e-14);
    }
}

TEST(ValidateCamera, IsRigidAfterShear) {
    Camera camera;
    camera.world_from_camera[1] = {0.5, 1.0, 0.3, 0.0};
    camera.world_from_camera[0] = {1.0, 0.2, 0.9, 0.0};
    validate(camera);
    const glm::dmat3 r{camera.world_from_camera};
    const glm::dmat3 identity = glm::transpose(r) * r;
    for (int column = 0; column < 3; ++column) {
        glm::dvec3 axis{0.0};
        axis[column] = 1.0;
        test::expect_near(identity[column], axis, 1e-14);
    }
    test::expect_near(r[2], {0, 0, 1}, 0.0);  // the viewing axis stays
    EXPECT_NEAR(glm::determinant(r), 1.0, 1e-14);
}

TEST(ValidateCamera, KeepsAMirroredCameraMirrored) {
    Camera camera;
    camera.world_from_camera = glm::scale(glm::dmat4{1.0}, glm::dvec3{-2.0, 2.0, 2.0});
    validate(camera);
    test::expect_near(glm::dvec3{camera.world_from_camera[0]}, {-1, 0, 0}, 0.0);
    EXPECT_EQ(glm::determinant(glm::dmat3{camera.world_from_camera}), -1.0);
}

TEST(ValidateCamera, RefusesASingularTransform) {
    Camera camera;
    camera.name = "Camera";
    camera.world_from_camera[1] = camera.world_from_camera[2];
    EXPECT_THAT(refusal_of(camera), AllOf(HasSubstr("camera \"Camera\""), HasSubstr("singular")));
}

TEST(ValidateCamera, RefusesClippingDistancesOutOfOrder) {
    Camera camera;
    camera.near_m = 0.0;
    EXPECT_THAT(refusal_of(camera), HasSubstr("near clipping distance is 0"));
    camera = Camera{};
    camera.far_m = camera.near_m;
    EXPECT_THAT(refusal_of(camera), HasSubstr("far clipping distance is 0.1"));
    camera.far_m = static_cast<double>(kInf);
    EXPECT_THAT(refusal_of(camera), HasSubstr("far clipping distance is inf"));
}

TEST(ValidateCamera, RefusesSizesThatAreEmptyOrTooLarge) {
    Camera camera;
    camera.width_px = 0;
    EXPECT_THAT(refusal_of(camera), HasSubstr("image is 0 x 512 px"));
    camera.width_px = 32769;
    EXPECT_THAT(refusal_of(camera), HasSubstr("image is 32769 x 512 px"));
    camera.width_px = 32768;
    EXPECT_THAT(refusal_of(camera), IsEmpty());
    camera.height_px = 32768;
    EXPECT_THAT(refusal_of(camera), HasSubstr("1073741824 pixels"));
}

TEST(ValidateCamera, RefusesNotANumberInEveryMember) {
    const double nan = static_cast<double>(kNan);
    const std::vector<std::function<void(Camera&)>> spoils{[&](Camera& c) { c.world_from_camera[0][0] = nan; },
                                                           [&](Camera& c) { c.tan_half_width = nan; },
                                                           [&](Camera& c) { c.half_width_m = nan; },
                                                           [&](Camera& c) { c.shift.y = nan; },
                                                           [&](Camera& c) { c.pixel_aspect = nan; },
                                                           [&](Camera& c) { c.near_m = nan; },
                                                           [&](Camera& c) { c.far_m = nan; },
                                                           [&](Camera& c) { c.pixel_offset.x = nan; }};
    for (const auto& spoil : spoils) {
        Camera camera;
        spoil(camera);
        EXPECT_THAT(refusal_of(camera), HasSubstr("nan"));
    }
}

TEST(ValidateCamera, RefusesAnAngleOfViewOfZero) {
    Camera camera;
    camera.tan_half_width = 0.0;
    EXPECT_THAT(refusal_of(camera), HasSubstr("angle of view"));
}

}  // namespace
}  // namespace penumbra
