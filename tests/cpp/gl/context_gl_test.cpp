#include "gl/context.h"

#include <glad/egl.h>
#include <gmock/gmock.h>

#include <fstream>
#include <thread>

#include "gl/buffer.h"
#include "gl/egl.h"
#include "gl/texture.h"
#include "gl_fixture.h"

namespace penumbra {
namespace {

using testing::HasSubstr;

class ContextGl : public GlTest {};

int threads_of_process() {
    std::ifstream status("/proc/self/status");
    std::string word;
    while (status >> word) {
        if (word == "Threads:") {
            int count = 0;
            status >> count;
            return count;
        }
    }
    return 0;
}

TEST_F(ContextGl, FiftyContextsComeAndGoWithoutLeavingThreadsOrHandles) {
    { const RenderThread first; }  // what the driver sets up once
    const int threads = threads_of_process();
    for (int i = 0; i < 50; ++i) {
        RenderThread thread;
        EXPECT_EQ(thread.run([](Device& device) {
            const StorageBuffer buffer(1024, "scratch");
            check_gl("scratch");
            return device.context.lost();
        }),
                  false);
    }
    EXPECT_EQ(threads_of_process(), threads);
}

TEST_F(ContextGl, TwoContextsOfOneDeviceLiveSideBySideAndOneSurvivesTheOther) {
    const std::vector<float> texels{1.0F, 2.0F, 3.0F, 4.0F};
    auto other = std::make_unique<RenderThread>();
    const auto round_trip = [&](Device&) {
        TextureImage image = TextureImage::make_2d(GL_R32F, 2, 2, "square");
        image.upload(std::span<const float>(texels));
        return image.read<float>();
    };
    EXPECT_EQ(other->run(round_trip), texels);
    EXPECT_EQ(gl().run(round_trip), texels);
    other.reset();
    EXPECT_EQ(gl().run(round_trip), texels);
}

TEST_F(ContextGl, TwoContextsOnOneThreadTakeTurns) {
    std::thread([&] {
        Context first;
        EXPECT_EQ(Context::current(), &first);
        Context second;
        EXPECT_EQ(Context::current(), &second);
        first.make_current();
        EXPECT_EQ(Context::current(), &first);
        first.check("turn");
        first.release();
        EXPECT_EQ(Context::current(), nullptr);
        second.make_current();
        second.check("turn");
    }).join();
}

TEST_F(ContextGl, TheContextOfAnotherLibraryOnTheCallersThreadStaysCurrent) {
    std::thread([&] {
        // As another library would: its own context on the same display, current on the thread that calls us.
        const std::vector<egl::Candidate> candidates = egl::enumerate();
        const std::vector<DeviceInfo> devices = list_devices();
        egl::RawContext theirs = egl::create_context(candidates.at(choose_device(devices, "")), false);
        egl::make_current(theirs);
        {
            RenderThread thread;
            EXPECT_EQ(eglGetCurrentContext(), theirs.context);
            EXPECT_NE(thread.run([](Device&) { return eglGetCurrentContext(); }), theirs.context);
            EXPECT_FALSE(list_devices().empty());
            EXPECT_EQ(eglGetCurrentContext(), theirs.context);
        }
        EXPECT_EQ(eglGetCurrentContext(), theirs.context);
        EXPECT_NE(glGetString(GL_RENDERER), nullptr);
        EXPECT_EQ(Context::current(), nullptr);
        egl::release_current(theirs);
        egl::destroy(theirs);
        egl::release_thread();
    }).join();
}

TEST_F(ContextGl, MesasSurfacelessPlatformServesWhereNoDeviceCanBeListed) {
    std::thread([&] {
        const egl::Candidate surfaceless;  // without a device
        egl::RawContext raw;
        try {
            raw = egl::create_context(surfaceless, false);
        } catch (const DeviceError& error) {
            GTEST_SKIP() << "not a Mesa driver: " << error.what();
        }
        egl::make_current(raw);
        GLint major = 0;
        glGetIntegerv(GL_MAJOR_VERSION, &major);
        EXPECT_EQ(major, 4);
        egl::release_current(raw);
        egl::destroy(raw);
        egl::release_thread();
    }).join();
}

TEST_F(ContextGl, ADisplayThatAnotherLibraryTerminatesServesTheLivingContextAndTheNext) {
    const EGLDisplay display = gl().run([](Device&) { return eglGetCurrentDisplay(); });
    ASSERT_EQ(eglTerminate(display), EGL_TRUE);
    const auto round_trip = [](Device&) {
        TextureImage image = TextureImage::make_2d(GL_R32F, 2, 2, "square");
        image.clear(glm::vec4(3.0F));
        return image.read<float>();
    };
    EXPECT_EQ(gl().run(round_trip), std::vector<float>(4, 3.0F));
    RenderThread next;
    EXPECT_EQ(next.run(round_trip), std::vector<float>(4, 3.0F));
    EXPECT_EQ(gl().run(round_trip), std::vector<float>(4, 3.0F));
}

TEST_F(ContextGl, ErrorsNameTheStepAndAreForgottenAfterwards) {
    EXPECT_THAT(message_of<DeviceError>([](Device&) {
                    glEnable(GL_TEXTURE_2D_ARRAY);
                    check_gl("depth map, face +x");
                }),
                HasSubstr("depth map, face +x: OpenGL reports GL_INVALID_ENUM"));
    EXPECT_NO_THROW(gl().run([](Device&) { check_gl("next"); }));
}

TEST_F(ContextGl, AnErrorThatWorkLeavesBehindBecomesItsException) {
    EXPECT_THROW(gl().run([](Device&) { glEnable(GL_TEXTURE_2D_ARRAY); }), DeviceError);
    EXPECT_THROW(gl().run([](Device&) {
        glEnable(GL_TEXTURE_2D_ARRAY);
        throw InvalidScene("first");
    }),
                 InvalidScene);
    EXPECT_NO_THROW(gl().run([](Device&) {}));
}

TEST_F(ContextGl, InDebugTheDriversOwnWordsAreInTheMessage) {
    DeviceOptions options;
    options.debug = true;
    RenderThread debug(options);
    try {
        debug.run([](Device& device) {
            EXPECT_TRUE(device.context.debug());
            glBindTextureUnit(0, 4711);
        });
        ADD_FAILURE() << "nothing was thrown";
    } catch (const DeviceError& error) {
        EXPECT_THAT(error.what(), HasSubstr("glBindTextureUnit"));
    }
    EXPECT_NO_THROW(debug.run([](Device&) { check_gl("next"); }));
}

TEST_F(ContextGl, AfterALostContextAllWorkFailsWithTheReason) {
    gl().run([](Device& device) {
        device.context.check("before");
        EXPECT_FALSE(device.context.lost());
    });
    EXPECT_THROW(gl().run([](Device& device) { device.context.mark_lost("the graphics driver was reset"); }),
                 DeviceError);
    EXPECT_EQ(message_of<DeviceError>([](Device&) { ADD_FAILURE() << "must not run"; }),
              "the graphics driver was reset");
}

TEST_F(ContextGl, LimitsMeetWhatTheTechniquesNeed) {
    gl().run([](Device& device) {
        const DeviceLimits& limits = device.context.limits();
        EXPECT_GE(limits.max_texture_size_px, 4096);
        EXPECT_GE(limits.max_cube_map_size_px, 4096);
        EXPECT_GE(limits.max_array_layers, 256);
        EXPECT_GE(limits.max_storage_bytes, 1 << 24);
        EXPECT_FALSE(device.context.extension_names().empty());
    });
}

}  // namespace
}  // namespace penumbra
