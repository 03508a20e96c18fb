// Volumes against rays to the light's centre: the same truth by other means, so that pixels may differ on edges only.
#include <random>

#include "geometry/shadow_volume.h"
#include "techniques/renderer_fixture.h"

namespace penumbra {
namespace {

class ShadowVolumeGl : public RendererGl {
protected:
    struct Differences {
        std::size_t on_edges = 0, elsewhere = 0, dark = 0, mask = 0;
    };
    /// Elsewhere: the rays say the same of the pixel and its eight neighbours, of which all are in the mask.
    Differences against_rays(const Scene& scene, const Settings& settings = {}) {
        renderer().set_scene(scene);
        const std::vector<float> volumes =
            renderer().visibility(0, {"shadow_volume", settings}, false, control_).visibility;
        const std::vector<float> rays = renderer().visibility(0, {"ray_traced", {}}, false, control_).visibility;
        const std::vector<std::uint8_t> mask = renderer().mask(0, control_);
        const int width = scene.camera.width_px, height = scene.camera.height_px;
        Differences found;
        for (int y = 0; y < height; ++y) {
            for (int x = 0; x < width; ++x) {
                const auto i = static_cast<std::size_t>(y * width + x);
                found.mask += mask[i];
                found.dark += mask[i] != 0 && rays[i] == 0.0F ? 1 : 0;
                if (mask[i] == 0 || volumes[i] == rays[i]) {
                    continue;
                }
                bool edge = false;
                for (int v = std::max(0, y - 1); v <= std::min(height - 1, y + 1); ++v) {
                    for (int u = std::max(0, x - 1); u <= std::min(width - 1, x + 1); ++u) {
                        const auto j = static_cast<std::size_t>(v * width + u);
                        edge = edge || rays[j] != rays[i] || mask[j] == 0;
                    }
                }
                ++(edge ? found.on_edges : found.elsewhere);
            }
        }
        return found;
    }
    void expect_the_rays_answer(const Scene& scene, const Settings& settings = {}) {
        const Differences found = against_rays(scene, settings);
        EXPECT_EQ(found.elsewhere, 0U);
        EXPECT_LE(static_cast<double>(found.on_edges), 0.002 * static_cast<double>(found.mask)) << "of " << found.mask;
        EXPECT_GT(found.dark, 0U) << "nothing to see";
        EXPECT_LT(found.dark, found.mask) << "nothing to see";
    }
    /// Looks from `eye` towards `at`, z up.
    static Camera look(const glm::dvec3& eye, const glm::dvec3& at, int width_px = 160, int height_px = 120) {
        Camera camera;
        const glm::dvec3 back = glm::normalize(eye - at);
        const glm::dvec3 right = glm::normalize(glm::cross(glm::dvec3{0, 0, 1}, back));
        camera.world_from_camera = glm::dmat4{glm::dmat3{right, glm::cross(back, right), back}};
        camera.world_from_camera[3] = glm::dvec4{eye, 1.0};
        camera.tan_half_width = 0.5;
        camera.width_px = width_px;
        camera.height_px = height_px;
        return camera;
    }
    static std::shared_ptr<Mesh> turned_inside_out(const std::shared_ptr<Mesh>& mesh) {
        auto made = std::make_shared<Mesh>(*mesh);
        for (glm::uvec3& t : made->triangles) {
            std::swap(t.y, t.z);
        }
        return made;
    }
    /// A court: walls as boxes, a ball, an arch of bars, a leaning sheet, a plate near the ground.
    static Scene court(const Light& light) {
        Scene scene;
        scene.instances.push_back(scenes::place(scenes::sheet(-12, 12, -12, 12), "ground"));
        scene.instances.push_back(scenes::place(scenes::box({-3, 2, 0}, {3, 2.3F, 2}), "wall"));
        scene.instances.push_back(scenes::place(scenes::sphere(12, false), "ball", {0.8, 0.3, 1.2}));
        for (int i = 0; i < 6; ++i) {
            scene.instances.push_back(scenes::place(scenes::box({-0.05F, -0.05F, 0}, {0.05F, 0.05F, 1.2F}),
                                                    "bar " + std::to_string(i), {-2.2 + 0.4 * i, -0.8, 0}));
        }
        Instance sheet = scenes::place(scenes::sheet(-0.7, 0.7, -0.5, 0.5), "leaning sheet", {-1.2, 0.6, 1.0});
        sheet.world_from_local = sheet.world_from_local * glm::dmat4{scenes::odd_turn()};
        scene.instances.push_back(sheet);
        scene.instances.push_back(scenes::place(scenes::sheet(1.0, 2.4, -1.6, -0.6), "plate", {0, 0, 0.02}));
        Instance mirrored = scenes::place(scenes::sphere(6, false), "mirrored ball", {2.2, 1.0, 0.6});
        mirrored.world_from_local[0] = {-0.5, 0, 0, 0};
        mirrored.world_from_local[1] = {0.1, 0.6, 0, 0};
        scene.instances.push_back(mirrored);
        scene.lights.push_back(light);
        scene.camera = look({1.0, -7.0, 4.0}, {0, 0, 0.5});
        return scene;
    }
};

TEST_F(ShadowVolumeGl, EveryPixelOfACourtIsTheRays) {
    expect_the_rays_answer(court(scenes::point_light({2.0, -1.5, 4.0}, 0.0)));
    expect_the_rays_answer(court(scenes::point_light({-3.0, 5.0, 3.0}, 0.0)));
    expect_the_rays_answer(court(scenes::sun_light({0.3, 0.5, -1.0}, 0.0)));
    expect_the_rays_answer(court(scenes::sun_light({-1.0, 0.1, -0.2}, 0.0)));
}

TEST_F(ShadowVolumeGl, EveryWayOfCountingGivesTheSameImage) {
    const Scene scene = court(scenes::point_light({2.0, -1.5, 4.0}, 0.0));
    const std::vector<float> automatic = visibility(scene, "shadow_volume");
    for (const std::string counting : {"stencil", "image"}) {
        for (const std::string faces : {"auto", "all"}) {
            EXPECT_LE(
                share_that_differs(automatic,
                                   visibility(scene, "shadow_volume", {{"counting", counting}, {"faces", faces}}), 0.5),
                0.001)
                << counting << ", " << faces;
        }
    }
    EXPECT_EQ(visibility(scene, "shadow_volume", {{"counting", std::string{"stencil"}}}),
              visibility(scene, "shadow_volume", {{"counting", std::string{"image"}}}));
}

TEST_F(ShadowVolumeGl, DeviceAndProcessorFindTheSameVolumes) {
    for (const std::string faces : {"auto", "light_facing", "all"}) {
        for (const Light& light :
             {scenes::point_light({2.0, -1.5, 4.0}, 0.0), scenes::sun_light({0.3, 0.5, -1.0}, 0.0)}) {
            const Scene scene = court(light);
            const Settings cpu{{"faces", faces}, {"silhouettes", std::string{"cpu"}}};
            const Settings gpu{{"faces", faces}, {"silhouettes", std::string{"gpu"}}};
            EXPECT_LE(share_that_differs(visibility(scene, "shadow_volume", cpu),
                                         visibility(scene, "shadow_volume", gpu), 0.5),
                      0.0005)
                << faces;
            const auto triangles = [&](const Settings& settings) {
                renderer().set_scene(scene);
                return renderer().visibility(0, {"shadow_volume", settings}, false, control_).statistics.front().value;
            };
            EXPECT_EQ(triangles(cpu), triangles(gpu)) << faces;
        }
    }
    expect_the_rays_answer(court(scenes::point_light({2.0, -1.5, 4.0}, 0.0)), {{"silhouettes", std::string{"gpu"}}});
}

TEST_F(ShadowVolumeGl, ALightWithinASolidLightsItsInsideOnly) {
    // Normals out or in, the camera in or out: the truth knows no sides.
    for (const bool inwards : {false, true}) {
        const auto box = scenes::box({-2, -2, 0}, {2, 2, 3});
        Scene scene;
        scene.instances.push_back(scenes::place(scenes::sheet(-12, 12, -12, 12), "ground", {0, 0, -0.5}));
        scene.instances.push_back(scenes::place(inwards ? turned_inside_out(box) : box, "room"));
        scene.instances.push_back(scenes::place(scenes::sphere(8, false), "ball", {0.5, 0, 1.2}));
        scene.instances.back().world_from_local[0].x = 0.4;
        scene.lights.push_back(scenes::point_light({-1.0, 0.5, 2.0}, 0.0));
        scene.camera = look({0.3, -1.8, 1.5}, {0, 1, 1});
        SCOPED_TRACE(inwards);
        expect_the_rays_answer(scene);
        scene.camera = look({1.0, -9.0, 4.0}, {0, 0, 0.5});
        const Differences outside = against_rays(scene);
        EXPECT_EQ(outside.elsewhere, 0U);
        EXPECT_EQ(outside.dark, outside.mask);
        EXPECT_EQ(outside.on_edges, 0U);
    }
}

TEST_F(ShadowVolumeGl, AHouseOfEitherWindingIsDarkWithin) {
    for (const bool inwards : {false, true}) {
        const auto box = scenes::box({-2, -2, 0}, {2, 2, 3});
        Scene scene;
        scene.instances.push_back(scenes::place(inwards ? turned_inside_out(box) : box, "house"));
        scene.instances.push_back(scenes::place(scenes::sheet(-12, 12, -12, 12), "ground", {0, 0, -0.1}));
        scene.lights.push_back(scenes::point_light({1.0, 4.5, 6.0}, 0.0));
        scene.camera = look({0.3, -1.8, 1.5}, {0, 1, 1});
        const Differences within = against_rays(scene);
        EXPECT_EQ(within.elsewhere + within.on_edges, 0U) << inwards;
        EXPECT_EQ(within.dark, within.mask);
        scene.camera = look({4.0, -9.0, 4.0}, {0, 0, 0.5});
        expect_the_rays_answer(scene);
    }
}

TEST_F(ShadowVolumeGl, TheEyeWithinAVolumeSeesTheSameShadows) {
    Scene scene = court(scenes::point_light({0.0, 6.0, 3.0}, 0.0));
    scene.camera = look({3.0, 0.0, 0.5}, {6.0, -2.0, 0.0});  // behind the wall, as the light sees it
    expect_the_rays_answer(scene);
    scene.camera = look({0.5, 1.5, 0.2}, {-2, -3, 0.0});
    expect_the_rays_answer(scene);
}

TEST_F(ShadowVolumeGl, NearAndFarPlanesThatCutCastersChangeNothing) {
    Scene scene = court(scenes::point_light({2.0, -1.5, 4.0}, 0.0));
    scene.camera.near_m = 5.5;  // through bars and plate
    expect_the_rays_answer(scene);
    scene.camera.near_m = 0.01;
    scene.camera.far_m = 8.0;  // through ball and ground: what is beyond still casts
    expect_the_rays_answer(scene);
    Scene beyond = court(scenes::point_light({0.0, 9.0, 3.0}, 0.0));
    beyond.camera.far_m = 8.5;  // before the wall, which casts onto all that is seen
    expect_the_rays_answer(beyond);
}

TEST_F(ShadowVolumeGl, OrthographicShiftedAndOffsetCamerasAreServed) {
    for (const Light& light : {scenes::point_light({2.0, -1.5, 4.0}, 0.0), scenes::sun_light({0, 0, -1.0}, 0.0),
                               scenes::sun_light({0.4, 0.2, -1.0}, 0.0), scenes::point_light({0, 0, 8}, 0.0)}) {
        Scene scene = court(light);
        scene.camera.shift = {0.2, -0.1};
        scene.camera.pixel_offset = {0.3, -0.2};
        expect_the_rays_answer(scene);
        scene.camera = scenes::camera_from_above(3.0, 160, 120);
        if (light.direction_ws != glm::dvec3{0, 0, -1} || light.kind != LightKind::Sun) {
            expect_the_rays_answer(scene);
        } else {  // every shadow is hidden by its caster
            const Differences found = against_rays(scene);
            EXPECT_EQ(found.dark + found.elsewhere + found.on_edges, 0U);
        }
        scene.camera = look({1.0, -7.0, 4.0}, {0, 0, 0.5});
        scene.camera.orthographic = true;
        expect_the_rays_answer(scene);
    }
}

TEST_F(ShadowVolumeGl, AViewAlongTheSunsRaysIsServed) {
    // Far ends of all volumes meet in one point of the view, and for an orthographic one in all.
    Scene scene = court(scenes::sun_light({-0.1, 0.7, -0.4}, 0.0));
    const glm::dvec3 along = glm::normalize(glm::dvec3{-0.1, 0.7, -0.4});
    scene.camera = look(glm::dvec3{0, 0, 0.5} - 8.0 * along, {0, 0, 0.5});
    scene.instances.push_back(scenes::place(scenes::box({-0.3F, -0.3F, -0.3F}, {0.3F, 0.3F, 0.3F}), "behind the eye",
                                            glm::dvec3{0, 0, 0.5} - 12.0 * along));
    const Differences perspective = against_rays(scene);
    EXPECT_EQ(perspective.elsewhere, 0U);
    scene.camera.orthographic = true;
    const Differences orthographic = against_rays(scene);
    EXPECT_EQ(orthographic.elsewhere, 0U);
}

TEST_F(ShadowVolumeGl, SoupsOfTrianglesBlockFromBothSides) {
    std::mt19937 random{5};
    std::uniform_real_distribution<float> at{-1.0F, 1.0F};
    auto soup = std::make_shared<Mesh>();
    soup->name = "soup";
    for (unsigned i = 0; i < 60; ++i) {
        const glm::vec3 corner{at(random), at(random), at(random)};
        for (int k = 0; k < 3; ++k) {
            soup->positions_local.push_back(corner + 0.6F * glm::vec3{at(random), at(random), at(random)});
        }
        soup->triangles.emplace_back(3 * i, 3 * i + 1, 3 * i + 2);
        if (i % 3 == 2) {  // three triangles at one edge, and one twice
            soup->triangles.emplace_back(3 * i, 3 * i + 1, 3 * i - 1);
            soup->triangles.emplace_back(3 * i, 3 * i + 1, 3 * i - 2);
            soup->triangles.emplace_back(3 * i - 3, 3 * i - 1, 3 * i - 2);
            soup->triangles.emplace_back(3 * i, 3 * i, 3 * i - 2);
        }
    }
    Scene scene = court(scenes::point_light({2.0, -1.5, 4.0}, 0.0));
    scene.instances.push_back(scenes::place(soup, "soup", {-0.5, -0.5, 1.5}));
    expect_the_rays_answer(scene);
    scene.lights[0] = scenes::point_light({-0.4, -0.6, 1.6}, 0.0);  // in the midst of it
    expect_the_rays_answer(scene);
}

TEST_F(ShadowVolumeGl, ATriangleWhosePlaneHoldsTheLightShadesNothing) {
    // A light in the ground's own plane, within its outline: the ground's volume is neither the half-space above nor
    // that below, and what stands on it is lit from the side.
    Scene scene;
    scene.instances.push_back(scenes::place(scenes::sheet(-12, 12, -12, 12), "ground"));
    scene.instances.push_back(scenes::place(scenes::box({-1, -1, 0}, {1, 1, 1}), "box"));
    scene.instances.back().receives = true;
    scene.instances.front().receives = false;  // seen edge-on: rays and counts may say what they like there
    scene.instances.push_back(scenes::place(scenes::box({2, -0.2F, 0.0F}, {2.2F, 0.2F, 0.5F}), "post"));
    scene.lights.push_back(scenes::point_light({4.0, 0.0, 0.0}, 0.0));
    scene.camera = look({6.0, -4.0, 3.0}, {0.5, 0.0, 0.3});
    for (const char* silhouettes : {"gpu", "cpu"}) {
        expect_the_rays_answer(scene, {{"silhouettes", std::string{silhouettes}}});
    }
}

TEST_F(ShadowVolumeGl, CasterAndReceiverThatTouchLeaveNoGap) {
    // A box on the ground, seen from close by: no bias, so no strip of light at its foot.
    Scene scene;
    scene.instances.push_back(scenes::place(scenes::sheet(-12, 12, -12, 12), "ground"));
    scene.instances.push_back(scenes::place(scenes::box({-1, -1, 0}, {1, 1, 1}), "box"));
    scene.lights.push_back(scenes::point_light({4.0, 1.0, 3.0}, 0.0));
    scene.camera = look({1.8, -2.5, 0.8}, {1.0, -1.0, 0.0});
    scene.camera.near_m = 0.01;
    expect_the_rays_answer(scene);
}

TEST_F(ShadowVolumeGl, MoreThan255VolumesInEachOtherAreStillCounted) {
    // n sheets over each other: the count is n, and 256 would be 0 modulo 256.
    Scene scene = scenes::straight_edge(scenes::point_light({0, 0, 4}, 0.0), 1.0, 0.0, 64, 1.0);
    const Instance blocker = scene.instances[1];
    for (int i = 1; i < 256; ++i) {
        Instance next = blocker;
        next.world_from_local[3].z = 1.0 + 0.001 * i;
        scene.instances.push_back(next);
    }
    const auto dark = [&](const Settings& settings) {
        const std::vector<float> v = visibility(scene, "shadow_volume", settings);
        return std::count(v.begin(), v.end(), 0.0F);
    };
    EXPECT_EQ(dark({{"counting", std::string{"stencil"}}}), 0) << "256 nested volumes wrap to none, as the thesis says";
    EXPECT_EQ(dark({}), 64 * 8 / 2);
    scene.instances.pop_back();
    EXPECT_EQ(dark({{"counting", std::string{"stencil"}}}), 64 * 8 / 2);
}

TEST_F(ShadowVolumeGl, ExtremeScalesAndPlacesGiveTheSameImage) {
    const Scene scene = court(scenes::point_light({2.0, -1.5, 4.0}, 0.0));
    const std::vector<float> original = visibility(scene, "shadow_volume");
    for (const double scale : {1e-3, 1e3}) {
        const Scene moved = scenes::transformed(scene, scale, scenes::odd_turn(), {1e5, -1e5, 1e5});
        EXPECT_LE(share_that_differs(original, visibility(moved, "shadow_volume"), 0.5), 0.001) << scale;
    }
}

TEST_F(ShadowVolumeGl, PermutedTrianglesGiveTheSameImage) {
    Scene scene = court(scenes::point_light({2.0, -1.5, 4.0}, 0.0));
    const std::vector<float> original = visibility(scene, "shadow_volume");
    std::mt19937 random{7};
    for (Instance& instance : scene.instances) {
        auto mesh = std::make_shared<Mesh>(*instance.mesh);
        std::shuffle(mesh->triangles.begin(), mesh->triangles.end(), random);
        instance.mesh = mesh;
    }
    EXPECT_EQ(original, visibility(scene, "shadow_volume"));
}

TEST_F(ShadowVolumeGl, LightsOneAfterTheOtherDoNotDisturbEachOther) {
    Scene scene = court(scenes::point_light({2.0, -1.5, 4.0}, 0.0));
    const std::vector<float> alone = visibility(scene, "shadow_volume");
    scene.lights.push_back(scenes::sun_light({-1.0, 0.1, -0.2}, 0.0));
    renderer().set_scene(scene);
    static_cast<void>(renderer().visibility(1, {"shadow_volume", {}}, false, control_));
    EXPECT_EQ(renderer().visibility(0, {"shadow_volume", {}}, false, control_).visibility, alone);
}

TEST_F(ShadowVolumeGl, CapsAreLeftOutWhereTheEyeIsOutside) {
    Scene scene = court(scenes::point_light({2.0, -1.5, 4.0}, 0.0));
    scene.instances.push_back(scenes::place(scenes::sphere(6, false), "between eye and light", {1.5, -4.2, 4.0}));
    renderer().set_scene(scene);
    const auto left_out = [&](bool keep) {
        const Plan plan = renderer().visibility(0, {"shadow_volume", {}}, keep, control_).plan;
        for (const Step& step : plan.steps) {
            if (step.rule == "eye-outside-volume") {
                return step.reason;
            }
        }
        return std::string{};
    };
    EXPECT_NE(left_out(false), "");
    EXPECT_EQ(left_out(true), "");
    EXPECT_EQ(visibility(scene, "shadow_volume", {}, false), visibility(scene, "shadow_volume", {}, true));
    expect_the_rays_answer(scene);
    scene.camera = scenes::camera_from_above(3.0, 160, 120);
    renderer().set_scene(scene);
    EXPECT_EQ(left_out(false), "") << "rays of an orthographic camera come from behind it";
}

TEST_F(ShadowVolumeGl, DebugPicturesAndStatisticsAreMade) {
    const Scene scene = court(scenes::point_light({2.0, -1.5, 4.0}, 0.0));
    renderer().set_scene(scene);
    const auto images = renderer().debug_images(0, {"shadow_volume", {}}, {}, control_);
    ASSERT_EQ(images.size(), 3U);
    for (const NamedDebugImage& named : images) {
        EXPECT_EQ(named.image.rgb.size(), 160U * 120U);
        EXPECT_FALSE(named.image.caption.empty());
    }
    const auto result = renderer().visibility(0, {"shadow_volume", {}}, false, control_);
    double overdraw = 0.0;
    for (const Statistic& statistic : result.statistics) {
        overdraw = statistic.id == "overdraw" ? statistic.value : overdraw;
    }
    EXPECT_GT(overdraw, 1.0);
    EXPECT_LT(overdraw, 100.0);
}

}  // namespace
}  // namespace penumbra
