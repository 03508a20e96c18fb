// Plateaus against their closed forms: plateaus.md section 3, through the whole renderer.
#include <cstdio>

#include "geometry/plateau.h"
#include "techniques/renderer_fixture.h"

namespace penumbra {
namespace {

Settings with(Settings settings, const std::string& id, const char* value) {
    settings[id] = std::string{value};
    return settings;
}

class PlateausGl : public RendererGl {
protected:
    /// RMSE over 1e-4 < truth < 1 - 1e-4, along a straight_edge() image.
    double penumbra_rmse(const Scene& scene, const Settings& settings, const std::function<double(double)>& truth) {
        const std::vector<double> v = profile(visibility(scene, "plateaus", settings), scene.camera);
        double sum = 0.0;
        int count = 0;
        for (std::size_t x = 0; x < v.size(); ++x) {
            const double t = truth(scenes::column_x(scene.camera, static_cast<int>(x)));
            if (t > 1e-4 && t < 1.0 - 1e-4) {
                sum += (v[x] - t) * (v[x] - t);
                ++count;
            }
        }
        return std::sqrt(sum / std::max(count, 1));
    }
    static void dump(const std::vector<float>& v, const Camera& camera, const std::string& name) {
        if (const char* folder = std::getenv("PLATEAUS_DUMP")) {
            std::FILE* file = std::fopen((std::string{folder} + "/" + name + ".pgm").c_str(), "wb");
            std::fprintf(file, "P5 %d %d 255\n", camera.width_px, camera.height_px);
            for (int y = camera.height_px - 1; y >= 0; --y) {
                for (int x = 0; x < camera.width_px; ++x) {
                    std::fputc(static_cast<int>(255.0F * v[static_cast<std::size_t>(y * camera.width_px + x)]), file);
                }
            }
            std::fclose(file);
        }
    }
};

Light disc_light(const glm::dvec3& centre, double radius) {
    Light light = scenes::rectangle_light(centre, 2.0 * radius, 2.0 * radius);
    light.kind = LightKind::Ellipse;
    return light;
}

Scene picture_scene(const Light& light) {
    Scene scene;
    scene.instances.push_back(scenes::place(scenes::sheet(-20, 20, -20, 20), "ground"));
    scene.instances.push_back(scenes::place(scenes::sphere(24, false), "ball", {0.6, 0.5, 1.2}));
    const auto bar = scenes::box({-0.1F, -0.1F, 0.0F}, {0.1F, 0.1F, 1.5F});
    for (int i = 0; i < 4; ++i) {
        scene.instances.push_back(scenes::place(bar, "bar " + std::to_string(i), {-1.5 + 0.5 * i, -1.0, 0.0}));
    }
    scene.instances.push_back(scenes::place(scenes::box({-0.4F, -0.3F, 1.0F}, {0.4F, 0.3F, 1.1F}), "slab", {-1.4, 1.0, 0.3}));
    scene.lights.push_back(light);
    scene.camera = scenes::camera_from_above(3.0, 480, 360, 20.0);
    const double a = 0.6;
    const glm::dmat3 tilt{{1, 0, 0}, {0, std::cos(a), std::sin(a)}, {0, -std::sin(a), std::cos(a)}};
    scene.camera.world_from_camera = glm::dmat4{tilt};
    scene.camera.world_from_camera[3] = glm::dvec4{tilt * glm::dvec3{0, 0, 20}, 1.0};
    return scene;
}

TEST_F(PlateausGl, DISABLED_Pictures) {
    const std::vector<std::pair<std::string, Light>> lights{
        {"disc", disc_light({0.8, -0.6, 4.0}, 0.4)},
        {"rect", scenes::rectangle_light({0.8, -0.6, 4.0}, 0.8, 0.4)},
        {"ball", scenes::point_light({0.8, -0.6, 4.0}, 0.4)},
        {"sun", scenes::sun_light({1.0, 0.3, -0.6}, 0.2)},
    };
    for (const auto& [name, light] : lights) {
        const Scene scene = picture_scene(light);
        renderer().set_scene(scene);
        const Reference truth = renderer().reference(0, {.standard_error = 0.02}, control_);
        dump(truth.area, scene.camera, name + "_truth");
        for (const char* sheets : {"envelope", "bilinear", "tess"}) {
            dump(visibility(scene, "plateaus", with({}, "sheet_mode", sheets)), scene.camera, name + "_" + sheets);
        }
        dump(visibility(scene, "plateaus", with({}, "sides", "both")), scene.camera, name + "_both");
        dump(visibility(scene, "plateaus", with({}, "edges", "all")), scene.camera, name + "_all");
        const auto fan = with(with({}, "sheet_mode", "bilinear"), "cones", "fan");
        dump(visibility(scene, "plateaus", fan), scene.camera, name + "_fan");
    }
}

// Published: nothing inside the hard edge, so the error of a step against a ramp, 1/sqrt(12).
TEST_F(PlateausGl, OnTheStraightEdgeTheOuterFormHasTheErrorOfAHardShadow) {
    const Scene scene = scenes::straight_edge(scenes::rectangle_light({0, 0, 4}, 1, 1), 1.0, 0.0, 1024);
    const double w = 0.5 / 3.0;
    const auto truth = [&](double x) { return std::clamp(0.5 + 0.5 * x / w, 0.0, 1.0); };
    EXPECT_NEAR(penumbra_rmse(scene, {}, truth), 0.289, 0.01);
    EXPECT_LE(penumbra_rmse(scene, with({}, "sides", "both"), truth), 0.01);
}

TEST_F(PlateausGl, OnTheStraightEdgeOfADiscTheTwoSidedFormIsExact) {
    const Scene scene = scenes::straight_edge(disc_light({0, 0, 4}, 0.5), 1.0, 0.0, 1024);
    const double w = 0.5 / 3.0;
    const auto truth = [&](double x) { return plateau::disc_cut(x / w); };
    EXPECT_LE(penumbra_rmse(scene, with({}, "sides", "both"), truth), 0.01);
    EXPECT_GT(penumbra_rmse(scene, {}, truth), 0.289);
}

}  // namespace
}  // namespace penumbra
