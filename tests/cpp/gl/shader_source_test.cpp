#include "gl/shader_source.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "penumbra/error.h"

namespace penumbra {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::Not;

std::string refusal(const ShaderSources& sources, std::string_view key) {
    try {
        static_cast<void>(expand(sources, key, {}));
    } catch (const DeviceError& error) {
        return error.what();
    }
    return "nothing was thrown";
}

/// "file:line" for every line of the text.
std::vector<std::string> places(const ExpandedSource& source) {
    std::vector<std::string> result;
    for (const ExpandedSource::Place& place : source.places) {
        result.push_back(source.files.at(place.file) + ":" + std::to_string(place.line));
    }
    return result;
}

TEST(Expand, WritesVersionAndDefinesAboveTheEntryFile) {
    const ShaderSources sources{{"a.frag", "void main() {}\n"}};
    const Defines defines{{"COUNT", "4"}, {"FAST"}};
    const ExpandedSource source = expand(sources, "a.frag", defines);
    EXPECT_EQ(source.text, "#version 450 core\n#define COUNT 4\n#define FAST 1\nvoid main() {}\n");
    EXPECT_THAT(places(source), ElementsAre("(version and defines):1", "(version and defines):2",
                                            "(version and defines):3", "a.frag:1"));
}

TEST(Expand, PutsEachIncludeInPlaceOnceAndKnowsWhereEachLineComesFrom) {
    const ShaderSources sources{{"a.frag", "#include \"lib/b.glsl\"\n#include \"lib/c.glsl\"\nlast\n"},
                                {"lib/b.glsl", "  #  include \"lib/c.glsl\" // why\nb\n"},
                                {"lib/c.glsl", "#pragma once\nc\n"}};
    const ExpandedSource source = expand(sources, "a.frag", {});
    EXPECT_EQ(source.text, "#version 450 core\nc\nb\nlast\n");
    EXPECT_THAT(places(source), ElementsAre("(version and defines):1", "lib/c.glsl:2", "lib/b.glsl:2", "a.frag:3"));
}

TEST(Expand, AFileThatIncludesItselfIsTakenOnce) {
    const ShaderSources sources{{"a.frag", "#include \"a.frag\"\nx\n"}};
    EXPECT_EQ(expand(sources, "a.frag", {}).text, "#version 450 core\nx\n");
}

TEST(Expand, LeavesOutWhatOnlyCppReads) {
    const ShaderSources sources{{"a.frag",
                                 "#ifdef __cplusplus\n#include <glm/glm.hpp>\n#if 1\n#endif\n#else\nglsl\n#endif\n"
                                 "#ifndef __cplusplus\nalso glsl\n#else\ncpp\n#endif\n#ifdef OTHER\nkept\n#endif\n"}};
    const ExpandedSource source = expand(sources, "a.frag", {});
    EXPECT_EQ(source.text, "#version 450 core\nglsl\nalso glsl\n#ifdef OTHER\nkept\n#endif\n");
    EXPECT_THAT(places(source),
                ElementsAre("(version and defines):1", "a.frag:6", "a.frag:9", "a.frag:13", "a.frag:14", "a.frag:15"));
}

TEST(Expand, NamesThePlaceOfAMissingInclude) {
    EXPECT_THAT(refusal({{"a.frag", "\n\n#include \"lib/no.glsl\"\n"}}, "a.frag"),
                HasSubstr("a.frag:3: include \"lib/no.glsl\" does not exist"));
    EXPECT_THAT(refusal({}, "a.frag"), HasSubstr("shader \"a.frag\" does not exist"));
    EXPECT_THAT(refusal({{"a.frag", "#include <glm/glm.hpp>\n"}}, "a.frag"), HasSubstr("a.frag:1: "));
    EXPECT_THAT(refusal({{"a.frag", "x\n#version 330\n"}}, "a.frag"), HasSubstr("a.frag:2: #version"));
}

TEST(ReadableLog, LeadsThePlacesOfAllDriversBackToFileAndLine) {
    const ShaderSources sources{{"a.frag", "one\n#include \"lib/b.glsl\"\n  two;\n"}, {"lib/b.glsl", "\nthree\n"}};
    const ExpandedSource source = expand(sources, "a.frag", {});  // version, one, empty, three, two
    EXPECT_EQ(readable_log("0:5(5): error: `x' undeclared\n", source), "a.frag:3: error: `x' undeclared\n    two;");
    EXPECT_EQ(readable_log("0(4) : error C1008: undefined\n", source),
              "lib/b.glsl:2: error C1008: undefined\n    three");
    EXPECT_EQ(readable_log("ERROR: 0:2: 'x' : undeclared\n", source), "a.frag:1: error: 'x' : undeclared\n    one");
}

TEST(ReadableLog, KeepsLinesWithoutAKnownPlace) {
    const ExpandedSource source = expand({{"a.frag", "x\n"}}, "a.frag", {});
    EXPECT_EQ(readable_log("linking failed\n0:7(1): error: x\n", source), "linking failed\n0:7(1): error: x");
}

TEST(EmbeddedShaders, AreKeyedByFolderAndBringNoVersion) {
    for (const auto& [key, text] : embedded_shaders()) {
        EXPECT_NE(key.find('/'), std::string::npos) << key;
        EXPECT_THAT(text, Not(HasSubstr("#version"))) << key;
    }
}

TEST(EmbeddedShaders, FindAllTheirIncludes) {
    for (const auto& [key, text] : embedded_shaders()) {
        EXPECT_NO_THROW(static_cast<void>(expand(embedded_shaders(), key, {}))) << key;
    }
}

}  // namespace
}  // namespace penumbra
