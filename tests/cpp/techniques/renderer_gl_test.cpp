#include <atomic>
#include <chrono>
#include <thread>

#include "techniques/renderer_fixture.h"

namespace penumbra {
namespace {

class RendererContract : public RendererGl {
protected:
    static Scene edge() { return scenes::straight_edge(scenes::rectangle_light({0, 0, 4}, 1, 1), 1.0, 0.0, 128); }
    template <class F>
    static std::string message_of(F&& call) {
        try {
            call();
        } catch (const Error& error) {
            return error.what();
        }
        return "no error";
    }
};

TEST_F(RendererContract, UnknownTechniqueNamesTheKnownOnes) {
    renderer().set_scene(edge());
    const std::string message = message_of([&] {
        static_cast<void>(renderer().visibility(0, {"shadow_mop", {}}, false, control_));
    });
    EXPECT_NE(message.find("shadow_mop"), std::string::npos);
    EXPECT_NE(message.find("light_samples"), std::string::npos);
}

TEST_F(RendererContract, BadSettingsSayWhichAndTheRange) {
    renderer().set_scene(edge());
    EXPECT_THROW(static_cast<void>(renderer().visibility(0, {"pcf", {{"kernel", 1000}}}, false, control_)),
                 InvalidSettings);
    EXPECT_THROW(static_cast<void>(renderer().visibility(0, {"pcf", {{"colour", 1}}}, false, control_)),
                 InvalidSettings);
    EXPECT_THROW(
        static_cast<void>(renderer().visibility(0, {"pcf", {{"filter", std::string{"tent"}}}}, false, control_)),
        InvalidSettings);
}

TEST_F(RendererContract, ALightThatDoesNotExistIsASentence) {
    renderer().set_scene(edge());
    EXPECT_NE(message_of([&] { static_cast<void>(renderer().mask(7, control_)); }).find("no light 7"),
              std::string::npos);
}

TEST_F(RendererContract, AnInvalidSceneLeavesTheFormerOne) {
    renderer().set_scene(edge());
    Scene broken = edge();
    broken.lights[0].position_ws.x = std::nan("");
    EXPECT_THROW(renderer().set_scene(broken), InvalidScene);
    EXPECT_EQ(renderer().view(control_)->width, 128);
}

TEST_F(RendererContract, TooLargeAMapIsASentence) {
    renderer().set_scene(edge());
    EXPECT_THROW(
        static_cast<void>(renderer().visibility(
            0, {"light_samples", {{"map_size", 16384}, {"samples", 64}, {"memory_mib", 65536}}}, false, control_)),
        Error);
    // and the renderer goes on
    EXPECT_EQ(renderer().visibility(0, {"shadow_map", {}}, false, control_).visibility.size(), 128U * 16U);
}

TEST_F(RendererContract, CancelStopsALongReferenceWhileMostOfItIsStillToDo) {
    Scene scene = edge();
    scene.camera = scenes::camera_from_above(0.3, 512, 512);
    renderer().set_scene(scene);
    Control control;
    std::thread canceller([&] {
        // By progress and not by the clock: under ThreadSanitizer on a busy machine the view alone takes seconds.
        while (control.progress() == 0.0F) {
            std::this_thread::sleep_for(std::chrono::milliseconds(1));
        }
        control.cancel();
    });
    EXPECT_THROW(static_cast<void>(renderer().reference(0, {.standard_error = 1e-5}, control)), Cancelled);
    canceller.join();
    EXPECT_LT(control.progress(), 0.5F);
}

TEST_F(RendererContract, TwoRenderersLiveSideBySide) {
    Renderer second;
    renderer().set_scene(edge());
    second.set_scene(edge());
    const auto a = renderer().visibility(0, {"shadow_map", {}}, false, control_).visibility;
    const auto b = second.visibility(0, {"shadow_map", {}}, false, control_).visibility;
    EXPECT_EQ(a, b);
}

TEST_F(RendererContract, MeasuringForNoNumberOfSecondsIsASentence) {
    renderer().set_scene(edge());
    const std::vector<Job> jobs{{"shadow_map", {}}};
    for (const double seconds :
         {std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity(), -1.0}) {
        TimingOptions timing;
        timing.max_seconds = seconds;
        EXPECT_THROW(static_cast<void>(renderer().measure(0, jobs, false, timing, control_)), InvalidSettings);
    }
}

TEST_F(RendererContract, MeasuringGivesEveryTimeAndEveryStep) {
    renderer().set_scene(edge());
    const std::vector<Job> jobs{{"shadow_map", {}}, {"light_samples", {{"samples", 4}}}, {"ray_traced", {{"rays", 4}}}};
    TimingOptions timing;
    timing.min_runs = 3;
    timing.max_runs = 4;
    timing.max_seconds = 0.5;
    const auto measured = renderer().measure(0, jobs, false, timing, control_);
    ASSERT_EQ(measured.size(), 3U);
    for (const Measurement& m : measured) {
        EXPECT_GE(m.dynamic_frame.runs, 3);
        EXPECT_GE(m.static_frame.runs, 3);
        EXPECT_GT(m.dynamic_frame.median, 0.0);
        EXPECT_GT(m.view.median, 0.0);
        EXPECT_LE(m.dynamic_frame.p10, m.dynamic_frame.median);
        EXPECT_GE(m.dynamic_frame.p90, m.dynamic_frame.median);
        for (const Step& step : m.plan.steps) {
            if (step.run) {
                EXPECT_GT(step.time_ms, 0.0) << step.name;
            }
        }
    }
    EXPECT_GT(measured[1].memory_bytes, measured[0].memory_bytes) << "four maps against one";
}

TEST_F(RendererContract, StatisticsAreOfTheFrameJustMade) {
    renderer().set_scene(edge());
    const std::uint64_t asked = renderer().light_report(0, false, control_).lit_pixels;
    const auto result = renderer().visibility(0, {"ray_traced", {{"rays", 3}}}, false, control_);
    ASSERT_EQ(result.statistics.size(), 1U);
    EXPECT_EQ(result.statistics[0].id, "rays");
    EXPECT_EQ(result.statistics[0].value, 3.0 * static_cast<double>(asked));

    const Job uncounted{.technique = "ray_traced", .settings = {{"rays", 3}}, .statistics = false};
    EXPECT_TRUE(renderer().visibility(0, uncounted, false, control_).statistics.empty()) << "nobody asked";

    Scene lonely = edge();
    lonely.instances.resize(1);
    lonely.instances[0].casts = false;
    renderer().set_scene(lonely);
    EXPECT_TRUE(renderer().visibility(0, {"ray_traced", {}}, false, control_).statistics.empty()) << "no ray was cast";
}

TEST_F(RendererContract, ProgressOfMeasuringNeverFalls) {
    renderer().set_scene(edge());
    const std::vector<Job> jobs{{"ray_traced", {{"rays", 64}}}};
    TimingOptions timing;
    timing.max_seconds = 0.5;
    std::atomic<bool> done{false};
    float furthest = 0.0F;
    float fall = 0.0F;
    std::jthread watcher{[&] {
        while (!done) {
            const float progress = control_.progress();
            fall = std::max(fall, furthest - progress);
            furthest = std::max(furthest, progress);
            std::this_thread::yield();
        }
    }};
    static_cast<void>(renderer().measure(0, jobs, false, timing, control_));
    done = true;
    watcher.join();
    EXPECT_EQ(fall, 0.0F) << "a traced frame tells its own progress, which is not that of the measuring";
    EXPECT_EQ(control_.progress(), 1.0F);
}

TEST_F(RendererContract, IrradianceOnTheAxisOfASmallLightIsItsClosedForm) {
    Scene scene = edge();
    scene.lights[0] = scenes::point_light({0, 0, 4}, 0.0);
    scene.lights[0].power_w = glm::dvec3{100.0};
    scene.camera = scenes::camera_from_above(0.01, 8, 8);
    renderer().set_scene(scene);
    const auto e = renderer().irradiance(0, control_);
    // Blender: I = P / (4 pi) for a point lamp; E = I / d^2 below it.
    EXPECT_NEAR(e[27].x, 100.0 / (4.0 * scenes::kPi) / 16.0, 1e-4 * e[27].x);
}

TEST_F(RendererContract, MaskIsZeroWhereNothingReceives) {
    Scene scene = edge();
    scene.instances[0].receives = false;
    renderer().set_scene(scene);
    for (const std::uint8_t asked : renderer().mask(0, control_)) {
        EXPECT_EQ(asked, 0);
    }
}

}  // namespace
}  // namespace penumbra
