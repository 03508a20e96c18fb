#include <gmock/gmock.h>

#include <cstdlib>

#include "gl_fixture.h"

namespace penumbra {
namespace {

using testing::HasSubstr;

class DeviceGl : public GlTest {};

/// Sets an environment variable until the end of the block.
class Environment {
public:
    Environment(const char* name, const char* value) : name_{name} {
        if (const char* before = std::getenv(name)) {
            before_ = before;
            existed_ = true;
        }
        setenv(name, value, 1);
    }
    ~Environment() {
        if (existed_) {
            setenv(name_, before_.c_str(), 1);
        } else {
            unsetenv(name_);
        }
    }
    Environment(const Environment&) = delete;
    Environment& operator=(const Environment&) = delete;

private:
    const char* name_;
    std::string before_;
    bool existed_ = false;
};

std::string refusal(const DeviceOptions& options) {
    try {
        const RenderThread thread(options);
    } catch (const DeviceError& error) {
        return error.what();
    }
    return "nothing was thrown";
}

TEST_F(DeviceGl, ListHasADeviceWithOpenGl45) {
    const std::vector<DeviceInfo> devices = list_devices();
    ASSERT_FALSE(devices.empty());
    for (const DeviceInfo& device : devices) {
        EXPECT_EQ(device.usable, device.reason.empty()) << describe(device);
        EXPECT_FALSE(device.name.empty());
    }
    const DeviceInfo& chosen = devices[choose_device(devices, "")];
    EXPECT_GE(std::strtod(chosen.gl_version.c_str(), nullptr), 4.5) << describe(chosen);
}

TEST_F(DeviceGl, TheEnvironmentVariableWithNonsenseListsTheDevices) {
    const Environment set("PENUMBRA_DEVICE", "no such card");
    const std::string message = refusal({});
    EXPECT_THAT(message, HasSubstr("no device matches \"no such card\""));
    EXPECT_THAT(message, HasSubstr(gl().info().name));
}

TEST_F(DeviceGl, TheOptionBeatsTheEnvironmentVariable) {
    const Environment set("PENUMBRA_DEVICE", "no such card");
    DeviceOptions options;
    options.device = gl().info().name;
    const RenderThread thread(options);
    EXPECT_EQ(thread.info().name, gl().info().name);
}

TEST_F(DeviceGl, AMissingLibEglIsOneSentenceThatNamesThePackages) {
    const Environment set("PENUMBRA_EGL_LIBRARY", "libNoSuchEGL.so.1");
    const std::string message = refusal({});
    EXPECT_THAT(message, HasSubstr("libegl1 libgl1-mesa-dri"));
    EXPECT_EQ(message.find('\n'), std::string::npos);
}

TEST_F(DeviceGl, WorksAgainAfterAMissingLibrary) {
    {
        const Environment set("PENUMBRA_EGL_LIBRARY", "libNoSuchEGL.so.1");
        EXPECT_TRUE(list_devices().empty());
    }
    EXPECT_FALSE(list_devices().empty());
}

}  // namespace
}  // namespace penumbra
