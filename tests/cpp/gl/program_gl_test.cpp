#include "gl/program.h"

#include <gmock/gmock.h>

#include <cmath>

#include "gl/buffer.h"
#include "gl/framebuffer.h"
#include "gl_fixture.h"

namespace penumbra {
namespace {

using testing::HasSubstr;
using testing::Not;

class ProgramGl : public GlTest {};

const char* const kFullscreen = R"(
void main() {
    vec2 corner = vec2((gl_VertexID << 1) & 2, gl_VertexID & 2);
    gl_Position = vec4(corner * 2.0 - 1.0, 0.5, 1.0);
}
)";

TEST_F(ProgramGl, IsCompiledOnceForTheSameFilesAndDefinesInAnyOrder) {
    gl().run([](Device&) {
        const ShaderSources sources{
            {"a.vert", kFullscreen},
            {"a.frag", "layout(location = 0) out float v;\nvoid main() { v = float(A + B); }\n"}};
        ProgramLibrary library(sources);
        EXPECT_EQ(library.compiled(), 0);
        const Program& first = library.get({"a.vert", "a.frag"}, {{"A", "1"}, {"B", "2"}});
        EXPECT_GT(library.compile_ms(), 0.0);
        const double once = library.compile_ms();
        const Program& again = library.get({"a.vert", "a.frag"}, {{"B", "2"}, {"A", "1"}});
        EXPECT_EQ(&first, &again);
        EXPECT_EQ(library.compiled(), 1);
        EXPECT_EQ(library.compile_ms(), once);
        const Program& other = library.get({"a.vert", "a.frag"}, {{"A", "1"}, {"B", "3"}});
        EXPECT_NE(&first, &other);
        EXPECT_EQ(library.compiled(), 2);
    });
}

TEST_F(ProgramGl, ErrorsNameTheFileAndLineOfTheIncludeAndShowTheLine) {
    const ShaderSources sources{
        {"techniques/x/x.frag",
         "// first\n#include \"lib/good.glsl\"\n#include \"lib/bad.glsl\"\nout float v;\nvoid main() { v = 1.0; }\n"},
        {"lib/good.glsl", "float good() { return 1.0; }\n"},
        {"lib/bad.glsl", "#include \"lib/good.glsl\"\n\nfloat bad() {\n    return not_declared;\n}\n"}};
    const std::string message = message_of<DeviceError>([&](Device&) {
        ProgramLibrary library(sources);
        library.get({"techniques/x/x.frag"});
    });
    EXPECT_THAT(message, HasSubstr("shader techniques/x/x.frag does not compile"));
    EXPECT_THAT(message, HasSubstr("lib/bad.glsl:4: "));
    EXPECT_THAT(message, HasSubstr("not_declared"));
    EXPECT_THAT(message, HasSubstr("\n    return not_declared;"));
}

TEST_F(ProgramGl, ErrorsAfterAnIncludeNameTheEntryFile) {
    const ShaderSources sources{{"a.frag", "#include \"b.glsl\"\n\nvoid main() { wrong; }\n"}, {"b.glsl", "\n\n\n\n"}};
    EXPECT_THAT(message_of<DeviceError>([&](Device&) { ProgramLibrary(sources).get({"a.frag"}); }),
                HasSubstr("a.frag:3: "));
}

TEST_F(ProgramGl, LinkErrorsNameTheProgramAndAFailureLeavesNothing) {
    const ShaderSources sources{
        {"a.vert", "out vec3 colour;\nvoid main() { colour = vec3(1); gl_Position = vec4(0); }\n"},
        {"a.frag", "in vec4 colour;\nlayout(location = 0) out vec4 v;\nvoid main() { v = colour; }\n"}};
    const std::string message = message_of<DeviceError>([&](Device&) {
        const long before = live_handle_count();
        ProgramLibrary library(sources);
        try {
            library.get({"a.vert", "a.frag"});
        } catch (...) {
            EXPECT_EQ(live_handle_count(), before);
            EXPECT_EQ(library.compiled(), 0);
            throw;
        }
    });
    EXPECT_THAT(message, HasSubstr("program a.vert + a.frag does not link"));
    EXPECT_THAT(message, HasSubstr("colour"));
}

TEST_F(ProgramGl, AFileWithoutAStageSuffixIsRefused) {
    EXPECT_THAT(message_of<DeviceError>([](Device&) {
                    ProgramLibrary(ShaderSources{{"a.glsl", ""}}).get({"a.glsl"});
                }),
                HasSubstr("\"a.glsl\" does not tell its stage"));
}

TEST_F(ProgramGl, UniformsArriveByNameAndUnreadOnesAreIgnored) {
    gl().run([](Device&) {
        const ShaderSources sources{{"a.vert", kFullscreen}, {"a.frag", R"(
uniform float scale;
uniform vec4 weights[2];
uniform mat4 turn;
uniform dmat4 fine;
uniform int count;
uniform float unread;
layout(location = 0) out vec4 v;
void main() { v = turn * (weights[0] + weights[1]) * scale * float(count) + vec4(fine[3]); }
)"}};
        ProgramLibrary library(sources);
        const Program& program = library.get({"a.vert", "a.frag"});
        program.set("scale", 2.0F);
        program.set("count", 3);
        program.set("unread", 1.0F);
        program.set("turn", glm::mat4(0.5F));
        glm::dmat4 fine(1.0);
        fine[3] = glm::dvec4(1.0, 2.0, 3.0, 4.0);
        program.set("fine", fine);
        const std::vector<glm::vec4> weights{glm::vec4(1.0F), glm::vec4(0.0F, 1.0F, 2.0F, 3.0F)};
        program.set("weights", std::span<const glm::vec4>(weights));
        EXPECT_TRUE(program.has("scale"));
        EXPECT_FALSE(program.has("unread"));

        const TextureImage image = TextureImage::make_2d(GL_RGBA32F, 1, 1, "result");
        RenderTarget target("result");
        target.attach_colour(0, image);
        target.bind();
        const VertexArray array = VertexArray::create();
        glBindVertexArray(array.name());
        program.use();
        glDrawArrays(GL_TRIANGLES, 0, 3);
        check_gl("draw");
        EXPECT_EQ(image.read<glm::vec4>().at(0), glm::vec4(4.0F, 8.0F, 12.0F, 16.0F));
    });
}

TEST_F(ProgramGl, DoublesKeepTheirFullPrecisionThroughAComputeShader) {
    gl().run([](Device&) {
        // What the resolve of the view relies on: positions far from the origin, made relative in float64.
        const ShaderSources sources{{"far.comp", R"(
layout(local_size_x = 64) in;
layout(std430, binding = 0) readonly buffer In { double position_ws[]; };
layout(std430, binding = 1) writeonly buffer Out { double position_cr[]; };
layout(std430, binding = 2) writeonly buffer Lengths { double lengths[]; };
uniform double eye_ws;
void main() {
    uint i = gl_GlobalInvocationID.x;
    if (i < position_ws.length()) {
        double p = position_ws[i] - eye_ws;
        position_cr[i] = p;
        lengths[i] = sqrt(p * p + 1.0LF) / 3.0LF;
    }
}
)"}};
        ProgramLibrary library(sources);
        const Program& program = library.get({"far.comp"});
        const double eye = 1e6 + 1.0 / 3.0;
        std::vector<double> positions(1000);
        for (std::size_t i = 0; i < positions.size(); ++i) {
            positions[i] = eye + 1e-9 * static_cast<double>(i * i);
        }
        const StorageBuffer in = StorageBuffer::from(positions, "positions");
        const StorageBuffer out(in.bytes(), "relative");
        const StorageBuffer lengths(in.bytes(), "lengths");
        in.bind_storage(0);
        out.bind_storage(1);
        lengths.bind_storage(2);
        program.set("eye_ws", eye);
        program.use();
        glDispatchCompute(16, 1, 1);
        check_gl("compute");
        const std::vector<double> relative = out.read<double>();
        const std::vector<double> measured = lengths.read<double>();
        for (std::size_t i = 0; i < positions.size(); ++i) {
            const double p = positions[i] - eye;
            ASSERT_EQ(relative[i], p) << i;  // one subtraction: exact rounding
            ASSERT_NEAR(measured[i], std::sqrt(p * p + 1.0) / 3.0, 4e-16) << i;
        }
    });
}

}  // namespace
}  // namespace penumbra
