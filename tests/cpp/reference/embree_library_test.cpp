#include "reference/embree_library.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdlib>

#include "penumbra/error.h"

namespace penumbra {
namespace {

/// Points PENUMBRA_EMBREE at the plugin of this build before any test runs.
class PluginOfThisBuild : public testing::Environment {
public:
    void SetUp() override { setenv("PENUMBRA_EMBREE", PENUMBRA_EMBREE_PLUGIN, 0); }
};
const testing::Environment* const registered = testing::AddGlobalTestEnvironment(new PluginOfThisBuild);

TEST(EmbreeLibrary, TheLibraryThatAnswersIsOfTheGenerationWeWereBuiltFor) {
    ASSERT_NE(registered, nullptr);
    const embree::Table& table = embree::library();
    EXPECT_EQ(table.loaded_version(embree::device()) / 10000, table.compiled_version / 10000);
    EXPECT_THAT(embree::version(), testing::MatchesRegex("[34]\\.[0-9]+\\.[0-9]+"));
}

}  // namespace
}  // namespace penumbra
