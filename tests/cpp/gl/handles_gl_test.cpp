#include "gl/handles.h"

#include "gl/buffer.h"
#include "gl_fixture.h"

namespace penumbra {
namespace {

class HandlesGl : public GlTest {};

TEST_F(HandlesGl, EveryKindIsFreedOnceAtTheEndOfItsBlock) {
    gl().run([](Device&) {
        const long before = live_handle_count();
        GLuint buffer_name = 0;
        GLuint texture_name = 0;
        {
            const Buffer buffer = Buffer::create();
            const Texture texture = Texture::create(static_cast<GLenum>(GL_TEXTURE_2D));
            const Framebuffer framebuffer = Framebuffer::create();
            const VertexArray array = VertexArray::create();
            const ProgramObject program = ProgramObject::create();
            const ShaderObject shader = ShaderObject::create(static_cast<GLenum>(GL_VERTEX_SHADER));
            const Query query = Query::create(static_cast<GLenum>(GL_TIMESTAMP));
            const Sampler sampler = Sampler::create();
            EXPECT_EQ(live_handle_count(), before + 8);
            for (GLuint name : {buffer.name(), texture.name(), framebuffer.name(), array.name(), program.name(),
                                shader.name(), query.name(), sampler.name()}) {
                EXPECT_NE(name, 0U);
            }
            buffer_name = buffer.name();
            texture_name = texture.name();
            EXPECT_TRUE(glIsBuffer(buffer_name));
            EXPECT_TRUE(glIsTexture(texture_name));
        }
        EXPECT_EQ(live_handle_count(), before);
        EXPECT_FALSE(glIsBuffer(buffer_name));
        EXPECT_FALSE(glIsTexture(texture_name));
    });
}

TEST_F(HandlesGl, MovingHandsOverTheNameAndFreesTheOldOne) {
    gl().run([](Device&) {
        const long before = live_handle_count();
        Buffer first = Buffer::create();
        const GLuint name = first.name();
        Buffer second = std::move(first);
        EXPECT_FALSE(first);  // NOLINT(bugprone-use-after-move): an empty handle is defined
        EXPECT_EQ(second.name(), name);
        second = Buffer::create();
        EXPECT_FALSE(glIsBuffer(name));
        EXPECT_EQ(live_handle_count(), before + 1);
        second = Buffer();
        EXPECT_EQ(live_handle_count(), before);
    });
}

class StorageBufferGl : public GlTest {};

TEST_F(StorageBufferGl, GivesBackWhatWasUploaded) {
    gl().run([](Device&) {
        std::vector<double> values(1000);
        for (std::size_t i = 0; i < values.size(); ++i) {
            values[i] = 1e-300 * static_cast<double>(i) + 1.0 / 3.0;
        }
        StorageBuffer buffer = StorageBuffer::from(values, "doubles");
        EXPECT_EQ(buffer.bytes(), 8000U);
        EXPECT_EQ(buffer.read<double>(), values);
        const std::vector<double> two{1.0, 2.0};
        buffer.upload(std::span<const double>(two), 998);
        values[998] = 1.0;
        values[999] = 2.0;
        EXPECT_EQ(buffer.read<double>(), values);
        buffer.fill_zero();
        EXPECT_EQ(buffer.read<double>(), std::vector<double>(1000, 0.0));
        EXPECT_THROW(buffer.upload(std::span<const double>(two), 999), DeviceError);
    });
}

TEST_F(StorageBufferGl, ReplaceKeepsTheStorageWhereTheSizeFits) {
    gl().run([](Device&) {
        StorageBuffer buffer = StorageBuffer::from(std::vector<int>{1, 2, 3}, "numbers");
        const GLuint name = buffer.name();
        const std::vector<int> same{4, 5, 6};
        buffer.replace(std::span<const int>(same));
        EXPECT_EQ(buffer.name(), name);
        EXPECT_EQ(buffer.read<int>(), same);
        const std::vector<int> more{7, 8, 9, 10};
        buffer.replace(std::span<const int>(more));
        EXPECT_EQ(buffer.read<int>(), more);
    });
}

TEST_F(StorageBufferGl, AnEmptyOneCanBeBoundAndRead) {
    gl().run([](Device&) {
        const StorageBuffer buffer = StorageBuffer::from(std::vector<float>(), "nothing");
        buffer.bind_storage(0);
        EXPECT_EQ(buffer.bytes(), 0U);
        EXPECT_TRUE(buffer.read<float>().empty());
        check_gl("nothing");
    });
}

}  // namespace
}  // namespace penumbra
