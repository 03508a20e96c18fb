// Penumbra maps on well-known models, where they are.
#include <random>

#include "support/obj.h"
#include "techniques/renderer_fixture.h"

namespace penumbra {
namespace {

class PenumbraMapsOnModels : public RendererGl, public testing::WithParamInterface<const char*> {
protected:
    void SetUp() override {
        RendererGl::SetUp();
        mesh_ = read_model(GetParam());
        if (!mesh_) {
            GTEST_SKIP() << GetParam() << " is not here";
        }
    }
    /// The model one metre high over a ground, a lamp of `radius_m` beside and above it.
    static Scene over_ground(const std::shared_ptr<const Mesh>& mesh, double radius_m, int size_px) {
        glm::vec3 low{1e30F}, high{-1e30F};
        for (const glm::vec3& p : mesh->positions_local) {
            low = glm::min(low, p);
            high = glm::max(high, p);
        }
        const double scale = 1.0 / (high.y - low.y);
        const glm::dvec3 middle = 0.5 * (glm::dvec3{low} + glm::dvec3{high});
        Scene scene;
        scene.instances.push_back(scenes::place(scenes::sheet(-20, 20, -20, 20), "ground"));
        Instance model = scenes::place(mesh, "model");
        model.world_from_local = glm::dmat4{{scale, 0, 0, 0}, {0, 0, scale, 0}, {0, -scale, 0, 0}, {0, 0, 0, 1}};
        model.world_from_local[3] = glm::dvec4{-scale * middle.x, scale * middle.z, -scale * low.y, 1.0};
        scene.instances.push_back(model);
        scene.lights.push_back(scenes::point_light({1.0, -1.0, 3.0}, radius_m));
        const double a = 0.9;
        const glm::dmat4 tilt{
            {1, 0, 0, 0}, {0, std::cos(a), std::sin(a), 0}, {0, -std::sin(a), std::cos(a), 0}, {0, 0, 0, 1}};
        scene.camera.world_from_camera = tilt;
        scene.camera.world_from_camera[3] = tilt * glm::dvec4{0, 0, 4, 1} + glm::dvec4{0, 0, 0.4, 0};
        scene.camera.tan_half_width = 0.4;
        scene.camera.width_px = scene.camera.height_px = size_px;
        return scene;
    }
    std::shared_ptr<const Mesh> mesh_;
};
std::string model_name(const testing::TestParamInfo<const char*>& model) {
    std::string name{model.param};
    name.resize(name.find('.'));
    std::ranges::replace(name, '-', '_');
    return name;
}
INSTANTIATE_TEST_SUITE_P(Models, PenumbraMapsOnModels,
                         testing::Values("stanford-bunny.obj", "spot.obj", "fandisk.obj", "teapot.obj"), model_name);

TEST_P(PenumbraMapsOnModels, LiteralAndExactAgreeWithinTheFacetsError) {
    const Scene scene = over_ground(mesh_, 0.1, 256);
    const std::vector<float> exact = visibility(scene, "penumbra_maps", {{"trim_cones", false}});
    const std::vector<float> literal =
        visibility(scene, "penumbra_maps", {{"mode", std::string{"literal"}}, {"facets", 24}, {"sheet_parts", 8}});
    EXPECT_LE(share_that_differs(exact, literal, 0.03), 0.001);
    EXPECT_LE(rmse(exact, literal), 0.01);
    const std::vector<float> trimmed = visibility(scene, "penumbra_maps");
    EXPECT_LE(share_that_differs(exact, trimmed, 0.03), 0.002);
}

TEST_P(PenumbraMapsOnModels, WithoutExtentItIsTheHardShadowMap) {
    const Scene scene = over_ground(mesh_, 0.0, 256);
    EXPECT_EQ(visibility(scene, "penumbra_maps"), visibility(scene, "shadow_map"));
}

TEST_P(PenumbraMapsOnModels, TheOrderOfTrianglesChangesNothing) {
    auto shuffled = std::make_shared<Mesh>(*mesh_);
    std::mt19937 random{7};
    std::shuffle(shuffled->triangles.begin(), shuffled->triangles.end(), random);
    shuffled->corner_normals_local.clear();
    EXPECT_EQ(visibility(over_ground(mesh_, 0.1, 128), "penumbra_maps"),
              visibility(over_ground(shuffled, 0.1, 128), "penumbra_maps"));
}

// Light radii 0.05, 0.2 and 1 of the caster's height: the published form is the worse the larger the light; with both
// sides the error stays below the hard shadow's.
TEST_P(PenumbraMapsOnModels, BothSidesAreNearerToTheTruthThanTheHardShadowAtAnySizeOfLight) {
    for (const double radius_m : {0.05, 0.2, 1.0}) {
        const Scene scene = over_ground(mesh_, radius_m, 128);
        renderer().set_scene(scene);
        const Reference truth = renderer().reference(0, {.standard_error = 0.01}, control_);
        const auto error = [&](const std::vector<float>& v) {
            double sum = 0.0;
            int count = 0;
            for (std::size_t i = 0; i < v.size(); ++i) {
                EXPECT_TRUE(v[i] >= 0.0F && v[i] <= 1.0F);
                if (truth.mask[i] != 0 && truth.area[i] > 1e-4F && truth.area[i] < 1.0F - 1e-4F) {
                    sum += (v[i] - truth.area[i]) * (v[i] - truth.area[i]);
                    ++count;
                }
            }
            return std::sqrt(sum / std::max(count, 1));
        };
        const double hard = error(visibility(scene, "shadow_map"));
        const double outer = error(visibility(scene, "penumbra_maps"));
        const double both = error(visibility(scene, "penumbra_maps", {{"sides", std::string{"both"}}}));
        const std::string radius = std::to_string(static_cast<int>(100.0 * radius_m)) + "_percent";
        RecordProperty("hard_" + radius, std::to_string(hard));
        RecordProperty("outer_" + radius, std::to_string(outer));
        RecordProperty("both_" + radius, std::to_string(both));
        EXPECT_LT(both, hard);
    }
}

}  // namespace
}  // namespace penumbra
