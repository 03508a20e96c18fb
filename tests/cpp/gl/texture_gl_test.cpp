#include "gl/texture.h"

#include <gmock/gmock.h>

#include <numeric>

#include "gl/texture_formats.h"
#include "gl_fixture.h"

namespace penumbra {
namespace {

using testing::HasSubstr;

class TextureGl : public GlTest {
protected:
    // Odd sizes: rows that are no multiple of four bytes must come without gaps.
    static constexpr int kWidth = 5;
    static constexpr int kHeight = 3;

    template <class T>
    void expect_round_trip(TextureImage& image, const std::vector<T>& texels) {
        image.upload(std::span<const T>(texels));
        EXPECT_EQ(image.read<T>(), texels) << format_info(image.format()).name;
        check_gl("round trip");
    }
};

TEST_F(TextureGl, Float32FormatsGiveBackWhatWasUploaded) {
    gl().run([&](Device&) {
        std::vector<float> one(kWidth * kHeight);
        std::iota(one.begin(), one.end(), 0.1F);
        TextureImage r = TextureImage::make_2d(GL_R32F, kWidth, kHeight, "r");
        expect_round_trip(r, one);
        EXPECT_EQ(r.bytes(), one.size() * 4);

        std::vector<glm::vec2> two(kWidth * kHeight);
        std::vector<glm::vec4> four(kWidth * kHeight);
        for (std::size_t i = 0; i < two.size(); ++i) {
            const auto f = static_cast<float>(i);
            two[i] = glm::vec2(f * 1e-30F, -f * 1e30F);
            four[i] = glm::vec4(f, -f, f * 1e-7F, 1.0F / (f + 1.0F));
        }
        TextureImage rg = TextureImage::make_2d(GL_RG32F, kWidth, kHeight, "rg");
        expect_round_trip(rg, two);
        TextureImage rgba = TextureImage::make_2d(GL_RGBA32F, kWidth, kHeight, "rgba");
        expect_round_trip(rgba, four);
        EXPECT_EQ(rgba.bytes(), four.size() * 16);
    });
}

TEST_F(TextureGl, IntegerDepthAndByteFormatsGiveBackWhatWasUploaded) {
    gl().run([&](Device&) {
        std::vector<std::uint32_t> ids(kWidth * kHeight);
        std::iota(ids.begin(), ids.end(), 0xfffffff0U);
        TextureImage r32ui = TextureImage::make_2d(GL_R32UI, kWidth, kHeight, "ids");
        expect_round_trip(r32ui, ids);
        std::vector<std::int32_t> signed_ids(kWidth * kHeight, -1);
        TextureImage r32i = TextureImage::make_2d(GL_R32I, kWidth, kHeight, "signed ids");
        expect_round_trip(r32i, signed_ids);
        std::vector<std::uint8_t> bytes(kWidth * kHeight);
        std::iota(bytes.begin(), bytes.end(), std::uint8_t{250});
        TextureImage r8 = TextureImage::make_2d(GL_R8, kWidth, kHeight, "bytes");
        expect_round_trip(r8, bytes);
        std::vector<float> depths(kWidth * kHeight);
        for (std::size_t i = 0; i < depths.size(); ++i) {
            depths[i] = 1.0F / static_cast<float>(i + 1);
        }
        TextureImage depth = TextureImage::make_2d(GL_DEPTH_COMPONENT32F, kWidth, kHeight, "depth");
        expect_round_trip(depth, depths);
    });
}

TEST_F(TextureGl, LayersAndCubeFacesKeepTheirOrder) {
    gl().run([&](Device&) {
        std::vector<float> layered(kWidth * kHeight * 7);
        std::iota(layered.begin(), layered.end(), 0.0F);
        TextureImage array = TextureImage::make_array(GL_R32F, kWidth, kHeight, 7, "layers");
        expect_round_trip(array, layered);
        std::vector<float> depth_values(kWidth * kHeight * 2, 0.25F);
        depth_values.back() = 0.75F;
        TextureImage depth = TextureImage::make_array(GL_DEPTH_COMPONENT32F, kWidth, kHeight, 2, "depth layers");
        expect_round_trip(depth, depth_values);
        std::vector<float> faces(4 * 4 * 6);
        std::iota(faces.begin(), faces.end(), 0.0F);
        TextureImage cube = TextureImage::make_cube(GL_R32F, 4, "cube");
        EXPECT_EQ(cube.layers(), 6);
        expect_round_trip(cube, faces);
    });
}

TEST_F(TextureGl, ClearFillsEveryLayer) {
    gl().run([](Device&) {
        TextureImage array = TextureImage::make_array(GL_RG32F, 3, 2, 2, "colour");
        array.clear(glm::vec4(0.5F, -2.0F, 0.0F, 0.0F));
        EXPECT_EQ(array.read<glm::vec2>(), std::vector<glm::vec2>(12, glm::vec2(0.5F, -2.0F)));
        TextureImage depth = TextureImage::make_array(GL_DEPTH_COMPONENT32F, 3, 2, 2, "depth");
        depth.clear(glm::vec4(0.25F));
        EXPECT_EQ(depth.read<float>(), std::vector<float>(12, 0.25F));
        TextureImage ids = TextureImage::make_2d(GL_R32I, 3, 2, "ids");
        ids.clear(glm::ivec4(-1));
        EXPECT_EQ(ids.read<std::int32_t>(), std::vector<std::int32_t>(6, -1));
        TextureImage both = TextureImage::make_2d(GL_DEPTH32F_STENCIL8, 3, 2, "depth and stencil");
        both.clear(glm::vec4(0.5F, 7.0F, 0.0F, 0.0F));
        EXPECT_EQ(both.read<float>(), std::vector<float>(6, 0.5F));
        EXPECT_EQ(both.read<std::uint8_t>(), std::vector<std::uint8_t>(6, 7));
        check_gl("clear");
    });
}

TEST_F(TextureGl, MipmapsAverageAndCountAsMemory) {
    gl().run([](Device&) {
        TextureImage image = TextureImage::make_2d(GL_R32F, 4, 4, "levels", 3);
        std::vector<float> texels(16);
        std::iota(texels.begin(), texels.end(), 0.0F);
        image.upload(std::span<const float>(texels));
        image.make_mipmaps();
        EXPECT_EQ(image.read<float>(2), std::vector<float>{7.5F});
        EXPECT_EQ(image.bytes(), (16U + 4U + 1U) * 4U);
    });
}

TEST_F(TextureGl, TooLargeATextureIsRefusedWithTheLimit) {
    gl().run([&](Device& device) {
        const DeviceLimits& limits = device.context.limits();
        const int side = limits.max_texture_size_px + 1;
        try {
            static_cast<void>(TextureImage::make_2d(GL_R32F, side, 1, "shadow map"));
            ADD_FAILURE() << "nothing was thrown";
        } catch (const InvalidSettings& error) {
            EXPECT_THAT(error.what(), HasSubstr("shadow map: a texture of " + std::to_string(side) + " x 1 texels"));
            EXPECT_THAT(error.what(), HasSubstr(std::to_string(limits.max_texture_size_px) + " texels a side"));
        }
        EXPECT_THROW(static_cast<void>(TextureImage::make_cube(GL_R32F, limits.max_cube_map_size_px + 1, "cube")),
                     InvalidSettings);
        EXPECT_THROW(static_cast<void>(TextureImage::make_array(GL_R32F, 1, 1, limits.max_array_layers + 1, "layers")),
                     InvalidSettings);
        EXPECT_THROW(static_cast<void>(TextureImage::make_2d(GL_R32F, 0, 4, "empty")), InvalidSettings);
    });
}

TEST_F(TextureGl, MoreMemoryThanThereIsBecomesOutOfMemoryAndLeavesTheContextUsable) {
    gl().run([&](Device& device) {
        const DeviceLimits& limits = device.context.limits();
        const int side = limits.max_texture_size_px;
        try {
            static_cast<void>(
                TextureImage::make_array(GL_RGBA32F, side, side, limits.max_array_layers, "far too much"));
            ADD_FAILURE() << "nothing was thrown";
        } catch (const OutOfMemory& error) {
            EXPECT_THAT(error.what(), HasSubstr("far too much: a texture of"));
            EXPECT_THAT(error.what(), HasSubstr("MiB"));
        }
        TextureImage small = TextureImage::make_2d(GL_R32F, 2, 2, "small");
        EXPECT_EQ(small.read<float>().size(), 4U);
    });
}

TEST_F(TextureGl, AWrongNumberOfTexelsIsRefusedBeforeTheDriverReadsThem) {
    EXPECT_THROW(gl().run([](Device&) {
        TextureImage image = TextureImage::make_2d(GL_RG32F, 2, 2, "square");
        const std::vector<float> texels(4);
        image.upload(std::span<const float>(texels));
    }),
                 DeviceError);
}

}  // namespace
}  // namespace penumbra
