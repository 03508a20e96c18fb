// The mask by depth bounds, which few devices offer: Mesa's softpipe does and llvmpipe does not. Where the device at
// hand lacks the extension, the program runs itself again on softpipe.
#include <gtest/gtest.h>

#include <array>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <string>

#include "gl/render_thread.h"
#include "passes/frame.h"
#include "passes/volume_pass.h"
#include "support/scenes.h"
#include "support/skip.h"

namespace penumbra {
namespace {

/// So that no pixel is seen along an edge.
constexpr glm::dvec3 kBox{0.013, 0.007, 0.5};

/// A ground seen from straight above in perspective, so at one depth, and a box over it that casts to the left.
Scene ground_and_box() {
    Scene scene;
    scene.instances.push_back(scenes::place(scenes::sheet(-50, 50, -50, 50), "ground"));
    scene.instances.push_back(scenes::place(scenes::box({-1, -1, 0}, {1, 1, 1}), "box", kBox));
    scene.lights.push_back(scenes::point_light({4.03, 0.11, 6.07}, 0.0));
    scene.camera = scenes::camera_from_above(4.0, 96, 64, 20.0);
    scene.camera.orthographic = false;
    scene.camera.tan_half_width = 4.0 / 20.0;
    return scene;
}

/// The ground alone.
View view_of(const Camera& camera) {
    View view;
    view.width = camera.width_px;
    view.height = camera.height_px;
    view.eye_ws = glm::dvec3{camera.world_from_camera[3]};
    for (int y = 0; y < view.height; ++y) {
        for (int x = 0; x < view.width; ++x) {
            const double step = 2.0 * camera.tan_half_width * view.eye_ws.z / view.width;
            view.position_cr.emplace_back(step * (x + 0.5 - 0.5 * view.width), step * (y + 0.5 - 0.5 * view.height),
                                          -view.eye_ws.z);
            view.normal_ws.emplace_back(0.0F, 0.0F, 1.0F);
            view.shading_normal_ws.emplace_back(0.0F, 0.0F, 1.0F);
            view.albedo.emplace_back(0.8F);
            view.instance.push_back(0);
            view.triangle.push_back(0);
        }
    }
    return view;
}

bool offers_depth_bounds() {
    RenderThread thread;
    return thread.run([](Device& device) { return device.context.extensions().depth_bounds_test; });
}

/// Counts at all pixels, with the depth of the lower half set to 0 as the mask has it where nothing is wanted.
std::vector<std::int32_t> counted(Device& device, Scene& scene, const View& view) {
    GpuScene gpu_scene;
    gpu_scene.update(scene);
    GpuAdjacency adjacency;
    ViewPass view_pass;
    FullscreenPass fullscreen;
    StepClock clock{true};
    Control control;
    TextureImage visibility;
    RenderTarget target;
    const LightSummary summary = summarise_light(scene, view, scene.lights[0],
                                                 {bounds_of(scene.instances[0]), bounds_of(scene.instances[1])}, false);
    const Plan plan;
    Frame frame{{device,
                 scene,
                 gpu_scene,
                 adjacency,
                 view_pass,
                 view,
                 summary,
                 fullscreen,
                 clock,
                 control,
                 {},
                 visibility,
                 target},
                plan};
    const glm::dvec4 ground = clip_from_rel(scene.camera) * glm::dvec4{glm::dvec3{view.position_cr[0]}, 1.0};
    const TextureImage depth = TextureImage::make_2d(GL_DEPTH32F_STENCIL8, view.width, view.height, "masked depth");
    RenderTarget depth_target{"masked depth"};
    depth_target.attach_depth(depth);
    depth_target.clear_depth_stencil(static_cast<float>(ground.z / ground.w), 0);
    glEnable(GL_SCISSOR_TEST);
    glScissor(0, 0, view.width, view.height / 2);
    depth_target.clear_depth_stencil(0.0F, 0);
    glDisable(GL_SCISSOR_TEST);
    VolumePass volumes{{.source = SilhouettePass::Source::Cpu, .counting = VolumePass::Counting::Stencil}};
    volumes.prepare(frame);
    volumes.extract(frame);
    VolumeMask mask;
    mask.kind = VolumeMask::Kind::DepthBounds;
    mask.depth_stencil = &depth;
    volumes.count(frame, mask);
    check_gl("depth bounds");
    return volumes.read_counts();
}

/// Runs this test in a process of its own, on softpipe: it has all that is needed of OpenGL 4.5 but says 3.3.
/// @return what it said
std::string on_softpipe(int& status) {
    const std::string command =
        "env -u PENUMBRA_MUST_RUN GALLIUM_DRIVER=softpipe MESA_GL_VERSION_OVERRIDE=4.5 MESA_GLSL_VERSION_OVERRIDE=450 "
        "PENUMBRA_IN_CHILD=1 '" +
        std::filesystem::read_symlink("/proc/self/exe").string() + "' --gtest_filter=DepthBounds.* 2>&1";
    FILE* child = popen(command.c_str(), "r");
    std::string said;
    std::array<char, 512> piece{};
    while (child != nullptr && std::fgets(piece.data(), static_cast<int>(piece.size()), child) != nullptr) {
        said += piece.data();
    }
    status = child != nullptr ? pclose(child) : -1;
    return said;
}

TEST(DepthBounds, VolumesAreCountedWhereTheMaskedDepthIsAndNowhereElse) {
    const bool in_child = std::getenv("PENUMBRA_IN_CHILD") != nullptr;
    bool offered = false;
    try {
        offered = offers_depth_bounds();
    } catch (const DeviceError& error) {
        if (!in_child) {
            PENUMBRA_SKIP(error.what());
        }
    }
    if (!offered) {
        if (in_child) {
            GTEST_SKIP() << "no depth bounds";
        }
        int status = 0;
        const std::string said = on_softpipe(status);
        if (said.find("no depth bounds") != std::string::npos) {
            GTEST_SKIP() << "neither this device nor softpipe has GL_EXT_depth_bounds_test";
        }
        EXPECT_EQ(status, 0) << said;
        EXPECT_NE(said.find("[       OK ]"), std::string::npos) << said;
        return;
    }
    Scene scene = ground_and_box();
    validate(scene);
    const View view = view_of(scene.camera);
    RenderThread thread;
    const std::vector<std::int32_t> counts = thread.run([&](Device& device) { return counted(device, scene, view); });
    const Mesh& box = *scene.instances[1].mesh;
    int dark = 0, unwanted = 0;
    for (std::size_t i = 0; i < counts.size(); ++i) {
        const glm::dvec3 p_box = view.eye_ws + glm::dvec3{view.position_cr[i]} - kBox;
        const int expected =
            count_crossings(box, {scene.lights[0].position_ws - kBox, 1.0}, p_box, VolumeFaces::Towards);
        if (count_crossings(box, {view.eye_ws - kBox, 1.0}, p_box, VolumeFaces::Towards) != 0) {
            continue;  // the box hides this ground
        }
        const bool wanted = i >= counts.size() / 2;
        EXPECT_EQ(counts[i], wanted ? expected : 0) << i;
        (wanted ? dark : unwanted) += expected != 0 ? 1 : 0;
    }
    EXPECT_GT(dark, 100) << "some of the shadow is in the half that counts";
    EXPECT_GT(unwanted, 100) << "and some in the other";
}

}  // namespace
}  // namespace penumbra
