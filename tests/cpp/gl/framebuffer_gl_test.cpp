#include "gl/framebuffer.h"

#include <gmock/gmock.h>

#include "gl_fixture.h"

namespace penumbra {
namespace {

using testing::HasSubstr;

class FramebufferGl : public GlTest {};

TEST_F(FramebufferGl, ClearsTheLayerThatIsAttachedAndNoOther) {
    gl().run([](Device&) {
        TextureImage colour = TextureImage::make_array(GL_R32F, 2, 2, 2, "colour");
        colour.clear(glm::vec4(0.0F));
        TextureImage depth = TextureImage::make_2d(GL_DEPTH_COMPONENT32F, 2, 2, "depth");
        RenderTarget target("target");
        target.attach_colour(0, colour, 1);
        target.attach_depth(depth);
        target.bind();
        target.clear_colour(0, glm::vec4(3.0F));
        target.clear_depth(0.5F);
        EXPECT_EQ(colour.read<float>(), (std::vector<float>{0, 0, 0, 0, 3, 3, 3, 3}));
        EXPECT_EQ(depth.read<float>(), std::vector<float>(4, 0.5F));
        EXPECT_EQ(target.width(), 2);
        check_gl("clear");
    });
}

TEST_F(FramebufferGl, AnIncompleteOneNamesItselfAndItsAttachments) {
    EXPECT_THAT(message_of<DeviceError>([](Device&) {
                    RenderTarget target("G-buffer");
                    target.bind();
                }),
                HasSubstr("G-buffer: the render target is not complete: nothing is attached"));
    EXPECT_THAT(message_of<DeviceError>([](Device&) {
                    const TextureImage layers = TextureImage::make_array(GL_R32F, 4, 4, 3, "layers");
                    const TextureImage flat = TextureImage::make_2d(GL_DEPTH_COMPONENT32F, 4, 4, "flat");
                    RenderTarget target("mixed");
                    target.attach_colour(0, layers);
                    target.attach_depth(flat);
                    target.bind();
                }),
                HasSubstr("layers (R32F, 4 x 4, all layers)"));
}

TEST_F(FramebufferGl, WorksWithoutAttachments) {
    gl().run([](Device&) {
        RenderTarget target("side effects only");
        target.set_size_without_attachment(8, 4);
        target.bind();
        EXPECT_EQ(target.height(), 4);
        check_gl("bind");
    });
}

}  // namespace
}  // namespace penumbra
