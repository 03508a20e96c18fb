#include "reference/embree_library.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace penumbra {
namespace {

TEST(EmbreeLibrary, TheLibraryThatAnswersIsOfTheGenerationWeWereBuiltFor) {
    const embree::Table& table = embree::library();
    EXPECT_EQ(table.loaded_version(embree::device()) / 10000, table.compiled_version / 10000);
    EXPECT_THAT(embree::version(), testing::MatchesRegex("[34]\\.[0-9]+\\.[0-9]+"));
}

}  // namespace
}  // namespace penumbra
