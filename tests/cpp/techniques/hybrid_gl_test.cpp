// The hybrid against its own parts: volumes where pixels are tagged, four comparisons elsewhere; and against the closed
// forms of what is exact, what is missed and what is tagged.
#include "geometry/volume_tiles.h"
#include "support/thesis_scenes.h"
#include "techniques/renderer_fixture.h"

namespace penumbra {
namespace {

class HybridGl : public RendererGl {
protected:
    struct Made {
        std::vector<float> hybrid, volumes;
        std::vector<std::uint8_t> tagged, mask;
        Camera camera;
    };
    Made make(const Scene& scene, Settings settings) {
        Made made;
        renderer().set_scene(scene);
        made.camera = scene.camera;
        made.mask = renderer().mask(0, control_);
        made.hybrid = renderer().visibility(0, {"hybrid", settings}, false, control_).visibility;
        const std::vector<std::string> views{"tagged"};
        const auto images = renderer().debug_images(0, {"hybrid", settings}, views, control_);
        for (const glm::vec3& rgb : images.front().image.rgb) {
            made.tagged.push_back(rgb == glm::vec3{0.1F, 0.9F, 0.1F} ? 1 : 0);
        }
        made.volumes = renderer().visibility(0, {"shadow_volume", {}}, false, control_).visibility;
        return made;
    }
    struct Wrong {
        std::size_t missing = 0, falsely_dark = 0, tagged_wrong = 0, tagged = 0, mask = 0;
    };
    static Wrong compare(const Made& made) {
        Wrong wrong;
        for (std::size_t i = 0; i < made.hybrid.size(); ++i) {
            if (made.mask[i] == 0) {
                continue;
            }
            ++wrong.mask;
            wrong.tagged += made.tagged[i];
            if (made.hybrid[i] != made.volumes[i]) {
                wrong.tagged_wrong += made.tagged[i];
                ++(made.hybrid[i] > made.volumes[i] ? wrong.missing : wrong.falsely_dark);
            }
        }
        return wrong;
    }
    static double tagged_share(const Made& made) {
        return static_cast<double>(std::count(made.tagged.begin(), made.tagged.end(), 1)) /
               static_cast<double>(made.tagged.size());
    }
    /// Seen from above, under a sun that shines straight down: the map's texels are axis-aligned squares of this width.
    static double texel_m(const Scene& scene, int map_px) {
        const double seen = 2.0 * scene.camera.half_width_m * (scene.camera.width_px - 1.0) / scene.camera.width_px;
        return seen / (map_px - 4.0);
    }
    /// A blocker seen by the sun alone, one metre over a ground.
    static Scene under_blocker(std::shared_ptr<const Mesh> blocker, int size_px, double turned_rad = 0.0,
                               const glm::dvec2& at = {}) {
        Scene scene;
        scene.instances.push_back(scenes::place(scenes::sheet(-50, 50, -50, 50), "ground"));
        Instance instance = scenes::place(std::move(blocker), "blocker", {at.x, at.y, 1.0});
        instance.world_from_local[0] = {std::cos(turned_rad), std::sin(turned_rad), 0, 0};
        instance.world_from_local[1] = {-std::sin(turned_rad), std::cos(turned_rad), 0, 0};
        instance.visible = false;
        instance.receives = false;
        scene.instances.push_back(instance);
        scene.lights.push_back(scenes::sun_light({0, 0, -1}, 0.0));
        scene.camera = scenes::camera_from_above(2.0, size_px, size_px);
        return scene;
    }

    static constexpr int kStripPhases = 6, kStripPixels = 384;
    struct Strip {
        double mean = 0.0, widest = 0.0;  ///< texels
    };
    /// How much that is lit goes dark beside a line along y, with one reference depth for all four texels and a bias of
    /// so many slopes, while an instance moves through a texel. With the receiver's plane nothing does.
    Strip darkened_strip(Scene scene, std::size_t moved, double bias) {
        constexpr int kMap = 24, kHigh = 24;
        scene.camera.height_px = kHigh;
        const double texel = texel_m(scene, kMap);
        Strip strip;
        for (int phase = 0; phase < kStripPhases; ++phase) {
            scene.instances[moved].world_from_local[3].x = texel * (phase + 0.5) / kStripPhases;
            const Wrong wrong = compare(make(scene, {{"map_size", kMap}, {"receiver_plane", false}, {"bias", bias}}));
            EXPECT_EQ(wrong.missing, 0U) << "no shadow is missed";
            EXPECT_EQ(wrong.tagged_wrong, 0U);
            const double width = static_cast<double>(wrong.falsely_dark) / kHigh * (4.0 / kStripPixels) / texel;
            strip.mean += width / kStripPhases;
            strip.widest = std::max(strip.widest, width);
            const Wrong plane = compare(make(scene, {{"map_size", kMap}, {"bias", bias}}));
            EXPECT_EQ(plane.missing + plane.falsely_dark, 0U) << "the receiver's plane needs no bias";
        }
        return strip;
    }
    static Scene small(Scene scene) {
        scene.camera.width_px = 192;
        scene.camera.height_px = 144;
        return scene;
    }
};

TEST_F(HybridGl, TaggedPixelsAreTheFullVolumesBitForBit) {
    for (const Scene& scene : {small(scenes::cubes()), small(scenes::cage()), small(scenes::tree())}) {
        for (const std::string mask : {"stencil", "tiles"}) {
            SCOPED_TRACE(scene.instances[1].name + ", " + mask);
            const Wrong wrong = compare(make(scene, {{"map_size", 256}, {"mask", mask}}));
            EXPECT_EQ(wrong.tagged_wrong, 0U);
            EXPECT_GT(wrong.tagged, 500U) << "of a mask of " << wrong.mask;
        }
    }
}

TEST_F(HybridGl, EveryMaskGivesTheSameImage) {
    for (const Scene& scene : {small(scenes::cage())}) {
        const std::vector<float> by_stencil = visibility(scene, "hybrid", {{"mask", std::string{"stencil"}}});
        for (const std::string mask : {"auto", "tiles", "depth_bounds", "discard"}) {
            for (const std::string counting : {"auto", "image"}) {
                EXPECT_EQ(by_stencil, visibility(scene, "hybrid", {{"mask", mask}, {"counting", counting}}))
                    << mask << ", " << counting;
            }
        }
    }
}

// The compute shader lists the tiles and draws what touches any; the processor draws in rectangles of them.
TEST_F(HybridGl, TilesOfTheComputeShaderAreTheProcessorsAndSoIsTheImage) {
    const std::vector<std::string> views{"tagged", "tiles"};
    std::vector<Scene> scenes{small(scenes::cubes()), small(scenes::cage()), small(scenes::tree())};
    scenes.push_back(under_blocker(scenes::sheet(-1, 0.3F, -1, 0.2F), 100));  // orthographic, a sun, tiles cut off
    scenes.push_back(small(scenes::cage()));                                  // the eye in a volume: caps
    scenes.back().camera = scenes::camera_towards({-1.2, 1.0, 0.3}, {1, -1, 0.5}, 150, 110);
    scenes.push_back(small(scenes::cubes()));
    scenes.back().lights[0].kind = LightKind::Sun;
    for (const Scene& scene : scenes) {
        SCOPED_TRACE(scene.instances[1].name);
        std::array<DebugImage, 2> pictures;
        std::array<std::vector<float>, 2> images;
        std::array<std::map<std::string, double>, 2> value;
        std::size_t tiles = 0;
        for (const bool on_device : {false, true}) {
            const Settings settings{{"map_size", 128},
                                    {"mask", std::string{"tiles"}},
                                    {"tile_sorting", std::string{on_device ? "gpu" : "cpu"}}};
            renderer().set_scene(scene);
            const auto result = renderer().visibility(0, {"hybrid", settings}, false, control_);
            images[on_device ? 1 : 0] = result.visibility;
            for (const Statistic& statistic : result.statistics) {
                value[on_device ? 1 : 0][statistic.id] = statistic.value;
            }
            const auto debug = renderer().debug_images(0, {"hybrid", settings}, views, control_);
            pictures[on_device ? 1 : 0] = debug[1].image;
            TileGrid grid{scene.camera.width_px, scene.camera.height_px};
            for (int y = 0; y < grid.height_px; ++y) {
                for (int x = 0; x < grid.width_px; ++x) {
                    if (debug[0].image.rgb[static_cast<std::size_t>(y * grid.width_px + x)] ==
                        glm::vec3{0.1F, 0.9F, 0.1F}) {
                        grid.wanted[grid.tile_of(x, y)] = 1;
                    }
                }
            }
            tiles = static_cast<std::size_t>(std::count(grid.wanted.begin(), grid.wanted.end(), 1));
            EXPECT_EQ(value[on_device ? 1 : 0]["tagged_tiles"], static_cast<double>(tiles));
        }
        EXPECT_GT(tiles, 0U);
        EXPECT_EQ(pictures[0].rgb, pictures[1].rgb) << "the same tiles";
        EXPECT_EQ(images[0], images[1]);
        const std::vector<float> by_stencil =
            visibility(scene, "hybrid", {{"map_size", 128}, {"mask", std::string{"stencil"}}});
        EXPECT_EQ(images[1], by_stencil);
        EXPECT_LE(value[1]["drawn_in_tiles"], value[1]["volume_triangles"]);
        EXPECT_GT(value[1]["drawn_in_tiles"], 0.0);
    }
}

TEST_F(HybridGl, TheComputeShaderLeavesOutTrianglesThatTouchNoTaggedTile) {
    // A view of a few of a thousand cubes: most of the others' volumes pass it by.
    const Scene scene = [&] {
        Scene made = small(scenes::cubes());
        made.camera = scenes::camera_towards({0.3, -1.6, 0.7}, {0.4, -0.9, 0.0}, 192, 144);
        made.camera.tan_half_width = 0.1;
        return made;
    }();
    for (const std::string silhouettes : {"cpu", "gpu"}) {
        const Settings settings{{"tile_sorting", std::string{"gpu"}}, {"silhouettes", silhouettes}};
        renderer().set_scene(scene);
        const auto result = renderer().visibility(0, {"hybrid", settings}, false, control_);
        double all = 0.0, drawn = 0.0;
        for (const Statistic& statistic : result.statistics) {
            all = statistic.id == "volume_triangles" ? statistic.value : all;
            drawn = statistic.id == "drawn_in_tiles" ? statistic.value : drawn;
        }
        EXPECT_GT(drawn, 0.0);
        EXPECT_LT(drawn, 0.5 * all) << silhouettes;
        EXPECT_EQ(result.visibility, visibility(scene, "hybrid", {{"mask", std::string{"stencil"}}})) << silhouettes;
    }
}

TEST_F(HybridGl, FewPixelsDifferFromTheVolumes) {
    // What the map does not see: thin twigs, and gaps between them.
    const Wrong cubes = compare(make(small(scenes::cubes()), {{"map_size", 1024}}));
    EXPECT_LT(static_cast<double>(cubes.missing + cubes.falsely_dark), 0.002 * static_cast<double>(cubes.mask));
    const Wrong tree = compare(make(small(scenes::tree()), {{"map_size", 1024}}));
    const Wrong coarse = compare(make(small(scenes::tree()), {{"map_size", 256}}));
    EXPECT_LT(tree.missing + tree.falsely_dark, coarse.missing + coarse.falsely_dark);
}

// 3.1.3: half-plane and complement are convex, so a point lies in the hull of its four centres.
TEST_F(HybridGl, AStraightEdgeHasNoWrongPixelAtAnyMapSizePhaseOrAngle) {
    for (const int map_px : {16, 33, 128}) {
        for (const double turned : {0.0, 0.31, 0.7854, 1.9}) {
            for (const double phase : {0.0, 0.013, -0.027}) {
                const Scene scene = under_blocker(scenes::sheet(-20, phase, -20, 20), 128, turned);
                const Made made = make(scene, {{"map_size", map_px}});
                const Wrong wrong = compare(made);
                EXPECT_EQ(wrong.missing + wrong.falsely_dark, 0U) << map_px << ", " << turned << ", " << phase;
                EXPECT_GT(wrong.tagged, 0U);
            }
        }
    }
}

// 3.3: |cos| + |sin| texels.
TEST_F(HybridGl, TheTaggedBandOfAnEdgeIsAsWideAsTheClosedForm) {
    for (const double turned : {0.0, 0.3, 0.7854, 1.2}) {
        const Scene scene = under_blocker(scenes::sheet(-20, 0.011, -20, 20), 512, turned);
        const Made made = make(scene, {{"map_size", 24}});
        const double length_m = 4.0 / std::max(std::abs(std::cos(turned)), std::abs(std::sin(turned)));
        const double width_texels = 16.0 * tagged_share(made) / length_m / texel_m(scene, 24);
        EXPECT_NEAR(width_texels, std::abs(std::cos(turned)) + std::abs(std::sin(turned)), 0.06) << turned;
    }
}

// 3.4: what a bias below a slope tags on a lit plane, compared with one depth for all four texels.
TEST_F(HybridGl, LowBiasTagsTheShareOfTheClosedForm) {
    for (const glm::dvec2& slope : {glm::dvec2{1.0, 0.0}, glm::dvec2{1.0, 0.6}, glm::dvec2{0.7, 0.7}}) {
        Scene scene = under_blocker(scenes::sheet(-0.1, 0.1, 30, 30.2), 256);
        scene.instances[0].world_from_local[0] = {1, 0, slope.x, 0};
        scene.instances[0].world_from_local[1] = {0, 1, slope.y, 0};
        scene.camera.far_m = 400.0;
        scene.camera.world_from_camera[3].z = 200.0;
        scene.instances[1].world_from_local[3] = {0, 0, 60, 1};
        const double a = std::max(slope.x, slope.y), b = std::min(slope.x, slope.y);
        for (const double bias : {0.3, 0.65, 1.1, 2.0}) {
            const double expected = bias >= a + b ? 0.0
                                    : bias > a    ? (a + b - bias) * (a + b - bias) / (2 * a * b)
                                    : bias > b    ? 1 - (bias - 0.5 * b) / a
                                                  : 1 - bias * bias / (2 * a * b);
            const Made one = make(scene, {{"map_size", 100}, {"receiver_plane", false}, {"bias", bias}});
            EXPECT_NEAR(tagged_share(one), expected, 0.03) << slope.x << ", " << slope.y << ", bias " << bias;
            const Made plane = make(scene, {{"map_size", 100}, {"bias", bias}});
            EXPECT_EQ(tagged_share(plane), 0.0) << "the receiver's plane needs none";
        }
    }
}

// 3.2: a convex tip between two texel centres is lost, up to 1 / (4 tan(th / 2)) square texels; nothing is gained.
TEST_F(HybridGl, TipsLoseNoMoreThanTheClosedFormAndGainNothing) {
    constexpr int kMap = 40;
    for (const double apex : {0.5236, 1.0472, 1.5708}) {
        const double half = std::tan(0.5 * apex);
        std::size_t most = 0;
        double texel = 0.0;
        for (int phase = 0; phase < 12; ++phase) {
            const auto spike = scenes::mesh(
                "spike", {{0, 0, 0}, {-10, static_cast<float>(-10 * half), 0}, {-10, static_cast<float>(10 * half), 0}},
                {{0, 1, 2}});
            const Scene scene = under_blocker(spike, 512, 0.0, {0.3 + 0.0173 * phase, 0.0083 * phase});
            texel = texel_m(scene, kMap);
            const Wrong wrong = compare(make(scene, {{"map_size", kMap}}));
            EXPECT_EQ(wrong.falsely_dark, 0U) << apex << ", " << phase;
            EXPECT_EQ(wrong.tagged_wrong, 0U);
            most = std::max(most, wrong.missing);
        }
        const double pixel = 4.0 / 512.0;
        const double lost = static_cast<double>(most) * pixel * pixel / (texel * texel);
        const double bound = 1.0 / (4.0 * half);
        EXPECT_LE(lost, bound + 0.02) << apex;
        EXPECT_GT(lost, 0.25 * bound) << apex << ": some phase must come near it";
    }
}

// 3.1.6: a strip narrower than a texel is there as a whole or not at all.
TEST_F(HybridGl, AStripNarrowerThanATexelIsAllThereOrNotAtAll) {
    int absent = 0;
    constexpr int kRuns = 16;
    for (int run = 0; run < kRuns; ++run) {
        Scene scene = under_blocker(scenes::sheet(0, 1, -20, 20), 256);
        const double texel = texel_m(scene, 32);
        scene.instances[1].mesh = scenes::sheet(0.0, 0.5 * texel, -20, 20);
        scene.instances[1].world_from_local[3].x = 0.2 + texel * (run + 0.5) / kRuns;
        const Made made = make(scene, {{"map_size", 32}});
        const Wrong wrong = compare(made);
        const auto dark = static_cast<std::size_t>(std::count(made.volumes.begin(), made.volumes.end(), 0.0F));
        EXPECT_EQ(wrong.falsely_dark, 0U);
        EXPECT_TRUE(wrong.missing == 0 || wrong.missing == dark) << wrong.missing << " of " << dark;
        absent += wrong.missing == dark ? 1 : 0;
    }
    EXPECT_EQ(absent, kRuns / 2) << "with probability 1 - width";
}

TEST_F(HybridGl, ThePublishedFilteredFetchTagsNoMoreThanTheFourComparisons) {
    const Scene scene = small(scenes::cage());
    const Made pcf = make(scene, {{"test", std::string{"pcf"}}, {"bias", 0.5}});
    const Made gather = make(scene, {{"receiver_plane", false}, {"bias", 0.5}});
    for (std::size_t i = 0; i < pcf.tagged.size(); ++i) {
        ASSERT_LE(pcf.tagged[i], gather.tagged[i]) << i;
    }
    EXPECT_EQ(compare(pcf).tagged_wrong, 0U);
}

// 2.2: one depth for four texels goes wrong where acne and occlusion meet. The specification's figures of boxes on a
// floor, 512 x 512, a map of 128: 454 wrong pixels and 13 551 tagged ones become 1 and 4 899.
TEST_F(HybridGl, TheReceiversPlaneLeavesNoFalseShadowAndOneTipOfBoxesOnAFloor) {
    Scene scene;
    scene.instances.push_back(scenes::place(scenes::sheet(-4, 4, -4, 4), "floor"));
    for (int i = 0; i < 5; ++i) {
        const auto height = static_cast<float>(0.4 + 0.2 * i);
        scene.instances.push_back(scenes::place(scenes::box({-0.3F, -0.25F, 0}, {0.3F, 0.25F, height}), "box",
                                                {1.4 * i - 2.8, 0.9 * (i % 3) - 0.8, 0}));
        const double turned = 0.3 + 0.7 * i;
        scene.instances.back().world_from_local[0] = {std::cos(turned), std::sin(turned), 0, 0};
        scene.instances.back().world_from_local[1] = {-std::sin(turned), std::cos(turned), 0, 0};
    }
    scene.lights.push_back(scenes::point_light({1.3, -2.1, 6.0}, 0.0));
    scene.camera = scenes::camera_towards({1.0, -6.0, 5.0}, {0, 0, 0.2}, 512, 512);
    const Wrong plane = compare(make(scene, {{"map_size", 128}}));
    EXPECT_EQ(plane.falsely_dark, 0U);
    EXPECT_LE(plane.missing, 1U);
    EXPECT_EQ(plane.tagged_wrong, 0U);
    const Wrong one = compare(make(scene, {{"map_size", 128}, {"receiver_plane", false}}));
    EXPECT_GT(one.falsely_dark, 100U);
    EXPECT_EQ(one.missing, plane.missing) << "the same tip: a low bias misses no shadow";
    EXPECT_GT(one.tagged, 3 * plane.tagged);
}

// 3.2: a lit strip along a shadow's edge goes dark where the deeper texels lie in the real shadow and the nearer ones
// fail by acne: 1 - B / g - x of a texel at phase x, in the mean (1 - B / g)^2 / 2, none from B = g on.
TEST_F(HybridGl, ALowBiasLosesALitSliverOfTheClosedFormAtAShadowsEdge) {
    Scene scene = under_blocker(scenes::sheet(-20, 0, -20, 20), kStripPixels);
    scene.instances[0].world_from_local[0] = {1, 0, 1, 0};  // deeper where the shadow is
    scene.instances[1].world_from_local[3].z = 30.0;
    scene.camera.far_m = 400.0;
    scene.camera.world_from_camera[3].z = 200.0;
    for (const double bias : {0.1, 0.5, 1.02}) {
        const Strip strip = darkened_strip(scene, 1, bias);
        const double lost = std::max(0.0, 1.0 - bias);
        EXPECT_NEAR(strip.mean, 0.5 * lost * lost, 0.03) << bias;
        EXPECT_LE(strip.widest, lost + 0.07) << bias;  // a pixel is 0.054 texels wide
        EXPECT_GE(strip.widest, lost - 1.0 / kStripPhases - 0.07) << bias;
    }
}

// 3.2: at the bottom of a valley that opens towards the light all four texels lie higher: a strip of up to a texel, in
// the mean (1 - 2 B / g)^2 / 2, none from B = g / 2 on.
TEST_F(HybridGl, ALowBiasDarkensACreaseByTheClosedForm) {
    Scene scene = under_blocker(scenes::sheet(-0.1, 0.1, 30, 30.2), kStripPixels);
    scene.instances[1].world_from_local[3].z = 30.0;
    scene.instances[0].mesh =
        scenes::mesh("valley", {{-10, -10, 10}, {0, -10, 0}, {10, -10, 10}, {-10, 10, 10}, {0, 10, 0}, {10, 10, 10}},
                     {{0, 1, 4}, {0, 4, 3}, {1, 2, 5}, {1, 5, 4}});
    for (const double bias : {0.1, 0.3, 0.52}) {
        const Strip strip = darkened_strip(scene, 0, bias);
        const double lost = std::max(0.0, 1.0 - 2.0 * bias);
        EXPECT_NEAR(strip.mean, 0.5 * lost * lost, 0.03) << bias;
        EXPECT_LE(strip.widest, lost + 0.07) << bias;
        EXPECT_GE(strip.widest, lost - 2.0 / kStripPhases - 0.07) << bias;
    }
}

// 2.6: dropped only where a texel's longer extent is under a pixel. The nearest texel's centre is then within
// sqrt(1/2) of a pixel, on the receiver's plane, and V is the truth of that point: where it is wrong an edge passes at
// that distance. Seen on a picture of seven times the resolution, for pixels whose neighbours lie in their plane.
TEST_F(HybridGl, ConservativeRatioCullingMovesEdgesByLessThanAPixel) {
    // The light of the cage has one face. Side faces, as the cubes have, are fitted to the few receivers in them, and
    // texels there may be finer than pixels in any map.
    const Scene one_face = small(scenes::cage());
    EXPECT_EQ(compare(make(one_face, {{"map_size", 64}, {"ratio_culling", std::string{"conservative"}}})).tagged,
              compare(make(one_face, {{"map_size", 64}})).tagged)
        << "texels wider than pixels everywhere";
    const Scene scene = small(scenes::cubes());
    const Made all = make(scene, {{"map_size", 2048}});
    const Made culled = make(scene, {{"map_size", 2048}, {"ratio_culling", std::string{"conservative"}}});
    const auto view = renderer().view(control_);
    constexpr int kFine = 7;
    Scene fine = scene;
    fine.camera.width_px *= kFine;
    fine.camera.height_px *= kFine;
    const std::vector<float> truth = visibility(fine, "shadow_volume");
    const int width = scene.camera.width_px;
    constexpr int kReach = 5;  // samples: 0.71 of a pixel
    int wrong = 0;
    for (int y = 1; y + 1 < scene.camera.height_px; ++y) {
        for (int x = 1; x + 1 < width; ++x) {
            const auto i = static_cast<std::size_t>(y * width + x);
            if (all.tagged[i] == 0 || culled.tagged[i] != 0 || culled.hybrid[i] == all.volumes[i]) {
                continue;
            }
            bool flat = true;
            for (const int j : {-width - 1, -width, -width + 1, -1, 1, width - 1, width, width + 1}) {
                const auto at = i + static_cast<std::size_t>(j);
                flat = flat &&
                       std::abs(glm::dot(view->normal_ws[i], view->position_cr[at] - view->position_cr[i])) < 1e-3F;
            }
            if (!flat) {
                continue;
            }
            ++wrong;
            bool near_by = false;
            for (int dy = -kReach; dy <= kReach; ++dy) {
                for (int dx = -kReach; dx <= kReach; ++dx) {
                    const int at = (y * kFine + kFine / 2 + dy) * width * kFine + x * kFine + kFine / 2 + dx;
                    near_by = near_by || (dx * dx + dy * dy <= kReach * kReach &&
                                          truth[static_cast<std::size_t>(at)] == culled.hybrid[i]);
                }
            }
            EXPECT_TRUE(near_by) << x << ", " << y;
        }
    }
    EXPECT_GT(wrong, 10) << "edges do move";
    EXPECT_LT(compare(culled).tagged, compare(all).tagged);
    // The published estimate is no upper bound, so it drops more.
    const Made scalar = make(scene, {{"map_size", 2048}, {"ratio_culling", std::string{"scalar"}}});
    EXPECT_GE(compare(culled).tagged, compare(scalar).tagged);
}

TEST_F(HybridGl, OmniLightsAreClassifiedAcrossTheFacesOfTheirCube) {
    Scene scene;
    scene.instances.push_back(scenes::place(scenes::sheet(-8, 8, -8, 8), "ground"));
    for (int i = 0; i < 12; ++i) {
        const double angle = 0.5236 * i + 0.1;
        scene.instances.push_back(scenes::place(scenes::box({-0.2F, -0.2F, 0}, {0.2F, 0.2F, 2.2F}),
                                                "post " + std::to_string(i),
                                                {2 * std::cos(angle), 2 * std::sin(angle), 0}));
    }
    scene.lights.push_back(scenes::point_light({0.05, 0.02, 1.0}, 0.0));
    scene.camera = scenes::camera_from_above(6.0, 256, 256);
    const Made made = make(scene, {{"map_size", 128}});
    const Wrong wrong = compare(made);
    EXPECT_EQ(wrong.tagged_wrong, 0U);
    EXPECT_LE(wrong.missing + wrong.falsely_dark, wrong.mask / 1000);
    EXPECT_GT(wrong.tagged, 100U);
}

TEST_F(HybridGl, SingularLightsAndMapsAreServed) {
    // A light within a solid, a map of 16 texels, a bias of 0, an eye within a volume.
    Scene scene = small(scenes::cage());
    scene.lights[0].position_ws = {0.05, 0.1, 1.4};
    for (const int map_px : {16, 512}) {
        const Wrong wrong = compare(make(scene, {{"map_size", map_px}}));
        EXPECT_EQ(wrong.tagged_wrong, 0U);
        EXPECT_LE(wrong.missing + wrong.falsely_dark, wrong.mask / 50);
    }
    scene = small(scenes::cage());
    scene.camera = scenes::camera_towards({-1.2, 1.0, 0.3}, {1, -1, 0.5}, 256, 192);
    EXPECT_EQ(compare(make(scene, {{"bias", 0.0}})).tagged_wrong, 0U);
    EXPECT_EQ(compare(make(scene, {{"map_size", 16}})).tagged_wrong, 0U);
}

TEST_F(HybridGl, APlaneUnderGrazingLightIsNotDarkFromItsOwnRoundedDepths) {
    // Vertices are snapped to 1/256 of a texel and positions rounded: at a slope of 100 more than a bias in texels'
    // widths.
    Scene scene;
    scene.instances.push_back(scenes::place(scenes::sheet(-20, 20, -20, 20), "ground"));
    scene.instances.push_back(scenes::place(scenes::box({-1.1F, -0.1F, 0.0F}, {-0.9F, 0.1F, 1.0F}), "post"));
    scene.camera = scenes::camera_towards({0.0, -11.0, 16.5}, {0.0, 0.0, 0.3}, 96, 72);
    scene.camera.tan_half_width = 0.15;
    for (const double height_m : {0.4, 0.04, 0.004}) {
        scene.lights = {scenes::point_light({-4.0, 0.0, height_m}, 0.0)};
        for (const int map_px : {128, 512, 2048}) {
            const Wrong wrong = compare(make(scene, {{"map_size", map_px}}));
            EXPECT_EQ(wrong.falsely_dark, 0U) << height_m << " m, " << map_px << " texels";
            EXPECT_EQ(wrong.missing, 0U) << height_m << " m, " << map_px << " texels";
        }
    }
}

TEST_F(HybridGl, MoreThan127VolumesInEachOtherAreStillCounted) {
    Scene scene = under_blocker(scenes::sheet(-20, 0.013, -20, 20), 64);
    const Instance blocker = scene.instances[1];
    for (int i = 1; i < 128; ++i) {
        Instance next = blocker;
        next.world_from_local[3].z = 1.0 + 0.001 * i;
        scene.instances.push_back(next);
    }
    const Wrong counted = compare(make(scene, {{"map_size", 32}}));
    EXPECT_EQ(counted.missing, 0U);
    const Wrong wrapped = compare(
        make(scene, {{"map_size", 32}, {"counting", std::string{"stencil"}}, {"mask", std::string{"stencil"}}}));
    EXPECT_GT(wrapped.missing, 0U) << "128 nested volumes are none modulo 128, as the specification says";
}

TEST_F(HybridGl, CastersThatLieInShadowAltogetherAreCulled) {
    Scene scene = small(scenes::cage());
    scene.instances.push_back(scenes::place(scenes::sheet(-1, 1, -1, 1), "awning", {1.9, -1.5, 4.9}));
    scene.instances.push_back(
        scenes::place(scenes::box({-0.1F, -0.1F, 0}, {0.1F, 0.1F, 0.2F}), "under it", {-2.3, 1.8, 0.0}));
    scene.instances.push_back(
        scenes::place(scenes::box({-0.1F, -0.1F, 0}, {0.1F, 0.1F, 0.2F}), "in the open", {0.5, -2.5, 0}));
    scene.lights[0] = scenes::sun_light({-4.2, 3.3, -4.8}, 0.0);
    for (const std::string mask : {"stencil", "tiles"}) {
        const Settings culling{{"caster_culling", true}, {"mask", mask}};
        renderer().set_scene(scene);
        const auto culled = renderer().visibility(0, {"hybrid", culling}, false, control_);
        EXPECT_EQ(culled.visibility, visibility(scene, "hybrid", {{"mask", mask}})) << mask;
        const auto found = std::find_if(culled.statistics.begin(), culled.statistics.end(),
                                        [](const Statistic& s) { return s.id == "culled_casters"; });
        ASSERT_NE(found, culled.statistics.end());
        EXPECT_EQ(found->value, 1.0) << mask << ": the box under the awning";
    }
}

// What lies in a culled caster's shadow lies in its rectangle, so its four texels lie in the rectangle made a texel
// larger, and all of them show something nearer than the caster: such pixels are dark and not tagged. So culling closes
// no gap that the map has not closed: it changes no pixel, and what is lost is the map's, whole slits that no texel's
// centre meets.
TEST_F(HybridGl, CasterCullingUnderSlitsNarrowerThanATexelChangesNoPixel) {
    constexpr int kRuns = 16, kMap = 32;
    int unseen = 0;
    for (int run = 0; run < kRuns; ++run) {
        Scene scene = under_blocker(scenes::sheet(-20, 0, -20, 20), 256);
        const double texel = texel_m(scene, kMap);
        scene.instances[1].world_from_local[3] = {texel * run / kRuns, 0, 2, 1};
        Instance half = scene.instances[1];  // the roof's other half, half a texel away
        half.name = "other half";
        half.mesh = scenes::sheet(0.5 * texel, 20, -20, 20);
        scene.instances.push_back(half);
        Instance box = scenes::place(scenes::box({-0.5F, -0.4F, 0.3F}, {0.5F, 0.4F, 0.7F}), "box");
        box.visible = false;
        box.receives = false;
        scene.instances.push_back(box);
        const Made kept = make(scene, {{"map_size", kMap}});
        const Made culled = make(scene, {{"map_size", kMap}, {"caster_culling", true}});
        EXPECT_EQ(kept.hybrid, culled.hybrid) << run;
        const auto result =
            renderer().visibility(0, {"hybrid", {{"map_size", kMap}, {"caster_culling", true}}}, false, control_);
        const auto found = std::find_if(result.statistics.begin(), result.statistics.end(),
                                        [](const Statistic& s) { return s.id == "culled_casters"; });
        ASSERT_NE(found, result.statistics.end());
        const Wrong wrong = compare(culled);
        const auto lit = static_cast<std::size_t>(std::count(culled.volumes.begin(), culled.volumes.end(), 1.0F));
        EXPECT_GT(lit, 0U) << "through the slit, beside the box";
        EXPECT_EQ(wrong.missing, 0U);
        EXPECT_EQ(wrong.falsely_dark, found->value == 2.0 ? lit : 0U) << run;
        unseen += found->value == 2.0 ? 1 : 0;  // the box, and the ground itself
    }
    EXPECT_EQ(unseen, kRuns / 2) << "with probability 1 - width";
}

TEST_F(HybridGl, WithNothingTaggedTheMapDecidesAlone) {
    Scene scene = under_blocker(scenes::sheet(-30, 30, -30, 30), 64);  // no edge in sight
    for (const std::string mask : {"stencil", "tiles", "discard"}) {
        const Made made = make(scene, {{"mask", mask}});
        EXPECT_EQ(compare(made).tagged, 0U);
        EXPECT_EQ(std::count(made.hybrid.begin(), made.hybrid.end(), 0.0F), 64 * 64);
    }
    const Made listed = make(scene, {{"tile_sorting", std::string{"gpu"}}});
    EXPECT_EQ(compare(listed).tagged, 0U);
    EXPECT_EQ(std::count(listed.hybrid.begin(), listed.hybrid.end(), 0.0F), 64 * 64);
}

TEST_F(HybridGl, ThePlanSaysWhatMaskServesWhereTheDeviceHasNoDepthBounds) {
    renderer().set_scene(small(scenes::cage()));
    const Job job{"hybrid", {{"mask", std::string{"depth_bounds"}}}};
    const Plan plan = renderer().visibility(0, job, false, control_).plan;
    const auto step =
        std::find_if(plan.steps.begin(), plan.steps.end(), [](const Step& s) { return s.name == "depth bounds"; });
    if (step != plan.steps.end()) {  // a device that has them says nothing
        EXPECT_EQ(step->rule, "device-without-depth-bounds");
        EXPECT_NE(step->reason.find("stencil"), std::string::npos) << step->reason;
        EXPECT_NE(step->reason.find(renderer().environment().gl_renderer), std::string::npos) << step->reason;
    }
    EXPECT_FALSE(renderer().visibility(0, {"hybrid", {}}, false, control_).plan.runs("depth bounds"));
}

TEST_F(HybridGl, StatisticsAreWhatTheThesisReports) {
    const Scene scene = small(scenes::cage());
    renderer().set_scene(scene);
    const auto result = renderer().visibility(0, {"hybrid", {}}, false, control_);
    std::map<std::string, double> value;
    for (const Statistic& statistic : result.statistics) {
        value[statistic.id] = statistic.value;
    }
    EXPECT_GT(value["overdraw"], 40.0);
    EXPECT_LT(value["masked_overdraw"], 0.2 * value["overdraw"]);
    EXPECT_GT(value["tagged_share"], 0.02);
    EXPECT_LT(value["tagged_share"], 0.15);
    EXPECT_EQ(renderer().debug_images(0, {"hybrid", {}}, {}, control_).size(), 7U);
}

}  // namespace
}  // namespace penumbra
