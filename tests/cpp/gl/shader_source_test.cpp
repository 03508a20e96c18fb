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

TEST(Expand, WritesVersionAndDefinesAboveTheEntryFile) {
    const ShaderSources sources{{"a.frag", "void main() {}\n"}};
    const Defines defines{{"COUNT", "4"}, {"FAST"}};
    EXPECT_EQ(expand(sources, "a.frag", defines).text,
              "#version 450 core\n#define COUNT 4\n#define FAST 1\n#line 1 1\nvoid main() {}\n");
}

TEST(Expand, PutsEachIncludeInPlaceOnceAndMarksLines) {
    const ShaderSources sources{{"a.frag", "#include \"lib/b.glsl\"\n#include \"lib/c.glsl\"\nlast\n"},
                                {"lib/b.glsl", "  #  include \"lib/c.glsl\" // why\nb\n"},
                                {"lib/c.glsl", "#pragma once\nc\n"}};
    const ExpandedSource source = expand(sources, "a.frag", {});
    EXPECT_THAT(source.files, ElementsAre("(version and defines)", "a.frag", "lib/b.glsl", "lib/c.glsl"));
    EXPECT_EQ(source.text,
              "#version 450 core\n#line 1 1\n#line 1 2\n#line 1 3\n\nc\n#line 2 2\nb\n#line 2 1\n#line 3 1\nlast\n");
}

TEST(Expand, AFileThatIncludesItselfIsTakenOnce) {
    const ShaderSources sources{{"a.frag", "#include \"a.frag\"\nx\n"}};
    EXPECT_EQ(expand(sources, "a.frag", {}).text, "#version 450 core\n#line 1 1\n#line 2 1\nx\n");
}

TEST(Expand, LeavesOutWhatOnlyCppReadsAndKeepsLineNumbers) {
    const ShaderSources sources{{"a.frag",
                                 "#ifdef __cplusplus\n#include <glm/glm.hpp>\n#if 1\n#endif\n#else\nglsl\n#endif\n"
                                 "#ifndef __cplusplus\nalso glsl\n#else\ncpp\n#endif\n#ifdef OTHER\nkept\n#endif\n"}};
    EXPECT_EQ(expand(sources, "a.frag", {}).text,
              "#version 450 core\n#line 1 1\n\n\n\n\n\nglsl\n\n\nalso glsl\n\n\n\n#ifdef OTHER\nkept\n#endif\n");
}

TEST(Expand, NamesThePlaceOfAMissingInclude) {
    EXPECT_THAT(refusal({{"a.frag", "\n\n#include \"lib/no.glsl\"\n"}}, "a.frag"),
                HasSubstr("a.frag:3: include \"lib/no.glsl\" does not exist"));
    EXPECT_THAT(refusal({}, "a.frag"), HasSubstr("shader \"a.frag\" does not exist"));
    EXPECT_THAT(refusal({{"a.frag", "#include <glm/glm.hpp>\n"}}, "a.frag"), HasSubstr("a.frag:1: "));
    EXPECT_THAT(refusal({{"a.frag", "x\n#version 330\n"}}, "a.frag"), HasSubstr("a.frag:2: #version"));
}

TEST(ReadableLog, LeadsThePlacesOfAllDriversBackToFileAndLine) {
    const ShaderSources sources{{"a.frag", "one\n  two;\n"}, {"lib/b.glsl", "three\n"}};
    ExpandedSource source;
    source.files = {"(version and defines)", "a.frag", "lib/b.glsl"};
    EXPECT_EQ(readable_log("1:2(5): error: `x' undeclared\n", source, sources),
              "a.frag:2: error: `x' undeclared\n    two;");
    EXPECT_EQ(readable_log("2(1) : error C1008: undefined\n", source, sources),
              "lib/b.glsl:1: error C1008: undefined\n    three");
    EXPECT_EQ(readable_log("ERROR: 1:2: 'x' : undeclared\n", source, sources),
              "a.frag:2: error: 'x' : undeclared\n    two;");
}

TEST(ReadableLog, KeepsLinesWithoutAKnownPlace) {
    const ExpandedSource source{"", {"(version and defines)"}};
    EXPECT_EQ(readable_log("linking failed\n7:3(1): error: x\n", source, {}), "linking failed\n7:3(1): error: x");
}

TEST(EmbeddedShaders, AreKeyedByFolderAndBringNoVersion) {
    for (const auto& [key, text] : embedded_shaders()) {
        EXPECT_NE(key.find('/'), std::string::npos) << key;
        EXPECT_THAT(text, Not(HasSubstr("#version"))) << key;
    }
}

}  // namespace
}  // namespace penumbra
