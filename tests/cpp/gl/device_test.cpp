#include "gl/device.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "penumbra/error.h"

namespace penumbra {
namespace {

using testing::HasSubstr;

DeviceInfo device(int index, std::string name, bool software, bool usable = true) {
    DeviceInfo info;
    info.index = index;
    info.name = std::move(name);
    info.gl_version = "4.5 (Core Profile)";
    info.software = software;
    info.usable = usable;
    info.reason = usable ? "" : "its driver gives no OpenGL 4.5 core context (EGL_BAD_MATCH)";
    return info;
}

std::string refusal(const std::vector<DeviceInfo>& devices, std::string_view wanted) {
    try {
        static_cast<void>(choose_device(devices, wanted));
    } catch (const DeviceError& error) {
        return error.what();
    }
    return "nothing was thrown";
}

const std::vector<DeviceInfo> kThree{device(0, "llvmpipe (LLVM 15)", true), device(1, "Old Card", false, false),
                                     device(2, "GeForce RTX", false)};

TEST(ChooseDevice, TakesTheFirstUsableHardwareDeviceByDefault) {
    EXPECT_EQ(choose_device(kThree, ""), 2U);
}

TEST(ChooseDevice, FallsBackToSoftwareWhereNoHardwareIsUsable) {
    const std::vector<DeviceInfo> devices{device(0, "Old Card", false, false), device(1, "llvmpipe", true)};
    EXPECT_EQ(choose_device(devices, ""), 1U);
}

TEST(ChooseDevice, TakesAnIndexOrPartOfANameInAnyCase) {
    EXPECT_EQ(choose_device(kThree, "0"), 0U);
    EXPECT_EQ(choose_device(kThree, "LLVMPIPE"), 0U);
    EXPECT_EQ(choose_device(kThree, "geforce"), 2U);
}

TEST(ChooseDevice, PrefersAUsableOneAmongThoseThatMatch) {
    const std::vector<DeviceInfo> devices{device(0, "Card A", false, false), device(1, "Card B", false)};
    EXPECT_EQ(choose_device(devices, "card"), 1U);
}

TEST(ChooseDevice, ListsTheDevicesWhenNothingMatches) {
    for (const char* wanted : {"nonsense", "7", "-1", "1.5", "99999999999999999999999"}) {
        const std::string message = refusal(kThree, wanted);
        EXPECT_THAT(message, HasSubstr("no device matches \"" + std::string(wanted) + "\""));
        EXPECT_THAT(message, HasSubstr("0: llvmpipe (LLVM 15)"));
        EXPECT_THAT(message, HasSubstr("2: GeForce RTX"));
    }
}

TEST(ChooseDevice, SaysWhyTheOneThatMatchesIsNotUsable) {
    EXPECT_THAT(refusal(kThree, "1"), HasSubstr("1: Old Card, not usable: its driver gives no OpenGL 4.5"));
}

TEST(ChooseDevice, NamesThePackagesWhenThereIsNone) {
    EXPECT_THAT(refusal({}, ""), HasSubstr("libegl1 libgl1-mesa-dri"));
    EXPECT_THAT(refusal({device(0, "Old Card", false, false)}, ""), HasSubstr("libegl1 libgl1-mesa-dri"));
}

TEST(ListDevices, WithoutLibEglIsEmptyAndNamesTheLibraryAndThePackages) {
    DeviceOptions options;
    options.egl_library = "libNoSuchEGL.so.1";
    std::string problem;
    EXPECT_TRUE(list_devices(options, &problem).empty());
    EXPECT_THAT(problem, HasSubstr("\"libNoSuchEGL.so.1\" cannot be opened"));
    EXPECT_THAT(problem, HasSubstr("libegl1 libgl1-mesa-dri"));
    EXPECT_EQ(problem.find('\n'), std::string::npos);
}

TEST(ListDevices, SaysSoWhenTheLibraryIsNotEgl) {
    DeviceOptions options;
    options.egl_library = "libm.so.6";
    std::string problem;
    EXPECT_TRUE(list_devices(options, &problem).empty());
    EXPECT_THAT(problem, HasSubstr("\"libm.so.6\" is not an EGL library"));
}

}  // namespace
}  // namespace penumbra
