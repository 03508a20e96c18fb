#include "techniques/renderer_fixture.h"

namespace penumbra {
namespace {

class PcfGl : public RendererGl {
protected:
    /// Width of the ramp over the straight edge, in texels: the pixels strictly between umbra and lit.
    double ramp_texels(const Settings& settings, double margin_texels, double height_m = 1.0, double threshold = 1e-6) {
        Settings all = settings;
        all["map_size"] = 64;
        const Scene scene = scenes::straight_edge(scenes::rectangle_light({0, 0, 4}, 1, 1), height_m, 0.0, 1024);
        const std::vector<double> v = profile(visibility(scene, "pcf", all), scene.camera);
        const double texel_px = 1024.0 / (64.0 - 2.0 * margin_texels);
        double between = 0.0;
        for (const double value : v) {
            between += value > threshold && value < 1.0 - threshold ? 1.0 : 0.0;
        }
        return between / texel_px;
    }
};

TEST_F(PcfGl, BilinearRampIsOneTexelWide) {
    EXPECT_NEAR(ramp_texels({{"filter", std::string{"2x2"}}}, 2.0), 1.0, 0.1);
}

TEST_F(PcfGl, BicubicRampIsThreeTexelsWide) {
    EXPECT_NEAR(ramp_texels({{"filter", std::string{"bicubic16"}}}, 4.0), 3.0, 0.15);
}

TEST_F(PcfGl, BoxRampIsAsWideAsItsKernel) {
    for (const int kernel : {1, 3, 7, 15}) {
        EXPECT_NEAR(ramp_texels({{"kernel", kernel}}, 0.5 * kernel + 2.0), kernel, 0.15) << kernel;
    }
}

// Wrong by construction: the width does not follow the distance to the caster.
TEST_F(PcfGl, WidthIsTheSameNearTheContactAndFarFromIt) {
    const double near_contact = ramp_texels({{"kernel", 7}}, 5.5, 0.05);
    const double far_from_it = ramp_texels({{"kernel", 7}}, 5.5, 2.0);
    EXPECT_NEAR(near_contact, far_from_it, 0.15);
}

TEST_F(PcfGl, RampsRiseMonotonouslyAndMeetTheMiddleAtTheEdge) {
    const Scene scene = scenes::straight_edge(scenes::rectangle_light({0, 0, 4}, 1, 1), 1.0, 0.0, 512);
    for (const char* filter : {"2x2", "bicubic16", "bicubic4", "box"}) {
        const std::vector<double> v =
            profile(visibility(scene, "pcf", {{"filter", std::string{filter}}, {"map_size", 64}}), scene.camera);
        for (std::size_t x = 1; x < v.size(); ++x) {
            EXPECT_GE(v[x], v[x - 1] - 1e-6) << filter;
        }
        double crossing = 0.0;
        for (std::size_t x = 0; x < v.size(); ++x) {
            crossing += v[x] < 0.5 ? 1.0 : 0.0;
        }
        EXPECT_NEAR(crossing, 256.0, 5.0) << filter;  // half a texel is 4.3 pixels
    }
}

// The comparisons enter linearly, so four bilinear fetches give the sixteen; hardware weights have 8 bits an axis.
TEST_F(PcfGl, FourFetchesEqualSixteen) {
    const Scene scene = scenes::straight_edge(scenes::rectangle_light({0, 0, 4}, 1, 1), 1.0, 0.1, 256);
    const std::vector<float> sixteen =
        visibility(scene, "pcf", {{"filter", std::string{"bicubic16"}}, {"map_size", 64}});
    const std::vector<float> four = visibility(scene, "pcf", {{"filter", std::string{"bicubic4"}}, {"map_size", 64}});
    EXPECT_LE(largest_difference(sixteen, four), 2.0 / 256.0);
}

TEST_F(PcfGl, AKernelOfOneTexelDiffersFromTheHardMapOnlyAtEdges) {
    const Scene scene = scenes::straight_edge(scenes::rectangle_light({0, 0, 4}, 1, 1), 1.0, 0.0, 512);
    const std::vector<float> pcf = visibility(scene, "pcf", {{"kernel", 1}, {"map_size", 512}});
    const std::vector<float> hard = visibility(scene, "shadow_map", {{"map_size", 512}});
    EXPECT_LT(share_that_differs(pcf, hard, 1e-3), 3.0 / 512.0);
}

TEST_F(PcfGl, LeavingOutComparisonsThatAgreeChangesNothing) {
    Scene scene;
    scene.instances.push_back(scenes::place(scenes::sheet(-20, 20, -20, 20), "ground"));
    scene.instances.push_back(scenes::place(scenes::sphere(16, false), "ball", {0.4, 0.3, 1.2}));
    scene.instances.push_back(scenes::place(scenes::sheet(-2, -1, -1, 1), "sheet", {0, 0, 0.4}));
    scene.camera = scenes::camera_from_above(3.0, 160, 120);
    for (const Light& light : {scenes::rectangle_light({0.3, -0.2, 4.0}, 1, 1), scenes::point_light({0, 0, 1.5}, 0.1),
                               scenes::sun_light({0.6, 0.1, -0.4}, 0.1)}) {
        scene.lights = {light};
        for (const int kernel : {23, 24, 31, 63}) {
            const Settings on{{"kernel", kernel}, {"map_size", 200}};
            Settings off = on;
            off["mask"] = false;
            EXPECT_EQ(visibility(scene, "pcf", on), visibility(scene, "pcf", off)) << kernel;
            renderer().set_scene(scene);
            const Plan plan = renderer().visibility(0, {"pcf", on}, false, control_).plan;
            EXPECT_EQ(plan.runs("depths under the kernel"), kernel >= 24);
        }
    }
}

TEST_F(PcfGl, NoFilterMakesAcneOnASlantedPlane) {
    Scene scene;
    scene.instances.push_back(scenes::place(scenes::sheet(-50, 50, -50, 50), "ground"));
    scene.lights.push_back(scenes::sun_light({0.8, 0.3, -0.5}, 0.0));
    scene.camera = scenes::camera_from_above(2.0, 128, 128);
    for (const char* bias : {"slope", "receiver_plane"}) {
        for (const char* filter : {"2x2", "bicubic16", "box"}) {
            for (const float v :
                 visibility(scene, "pcf", {{"filter", std::string{filter}}, {"bias", std::string{bias}}})) {
                ASSERT_EQ(v, 1.0F) << filter << " " << bias;
            }
        }
    }
}

}  // namespace
}  // namespace penumbra
