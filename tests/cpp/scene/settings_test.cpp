#include "penumbra/settings.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <limits>

#include "penumbra/error.h"

namespace penumbra {
namespace {

using testing::AllOf;
using testing::HasSubstr;

const std::vector<SettingInfo> kInfos{
    {"size", "Size", "px", "Width of the map.", 1024, 16, 8192, {}, {256, 1024}},
    {"bias", "Bias", "texel", "Constant bias.", 1.5, 0.0, 10.0, {}, {}},
    {"smooth", "Smooth", "", "Filters.", false, 0, 0, {}, {}},
    {"filter", "Filter", "", "Kernel.", std::string{"box"}, 0, 0, {"box", "bicubic"}, {}}};

std::string refusal(const Settings& given) {
    try {
        static_cast<void>(complete("pcf", kInfos, given));
    } catch (const InvalidSettings& error) {
        return error.what();
    }
    return {};
}

TEST(CompleteSettings, FillsInDefaults) {
    const Settings all = complete("pcf", kInfos, {{"size", 64}});
    EXPECT_EQ(all.size(), 4U);
    EXPECT_EQ(get_int(all, "size"), 64);
    EXPECT_EQ(get_double(all, "bias"), 1.5);
    EXPECT_FALSE(get_bool(all, "smooth"));
    EXPECT_EQ(get_choice(all, "filter"), "box");
}

TEST(CompleteSettings, TakesAnIntegerForADoubleOnly) {
    EXPECT_EQ(get_double(complete("pcf", kInfos, {{"bias", 2}}), "bias"), 2.0);
    EXPECT_THAT(refusal({{"size", 64.0}}), AllOf(HasSubstr("pcf.size"), HasSubstr("64"), HasSubstr("whole number")));
    EXPECT_THAT(refusal({{"size", true}}), HasSubstr("true"));
    EXPECT_THAT(refusal({{"smooth", 1}}), HasSubstr("true or false"));
    EXPECT_THAT(refusal({{"bias", std::string{"much"}}}), HasSubstr("\"much\""));
    EXPECT_THAT(refusal({{"filter", 3}}), HasSubstr("name"));
}

TEST(CompleteSettings, TakesTheEndsOfTheRangeAndNothingBeyond) {
    EXPECT_EQ(refusal({{"size", 16}}), "");
    EXPECT_EQ(refusal({{"size", 8192}}), "");
    EXPECT_THAT(refusal({{"size", 15}}), AllOf(HasSubstr("15"), HasSubstr("from 16 to 8192 px")));
    EXPECT_THAT(refusal({{"bias", 10.5}}), HasSubstr("10.5"));
    EXPECT_THAT(refusal({{"bias", std::numeric_limits<double>::quiet_NaN()}}), HasSubstr("nan"));
}

TEST(CompleteSettings, ListsWhatIsKnownWhenANameIsNot) {
    EXPECT_THAT(refusal({{"sizes", 64}}), AllOf(HasSubstr("\"sizes\""), HasSubstr("size, bias, smooth, filter")));
    EXPECT_THAT(refusal({{"filter", std::string{"gauss"}}}), AllOf(HasSubstr("\"gauss\""), HasSubstr("box, bicubic")));
}

TEST(GetSetting, RefusesAMissingOrMistypedValue) {
    EXPECT_THROW(static_cast<void>(get_int({}, "size")), InvalidSettings);
    EXPECT_THROW(static_cast<void>(get_bool({{"size", 1}}, "size")), InvalidSettings);
}

}  // namespace
}  // namespace penumbra
