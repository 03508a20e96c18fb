// The textures as they are kept, and pictures of their inside.
#include <algorithm>
#include <array>
#include <cmath>

#include "passes/debug_picture.h"
#include "passes/frame.h"
#include "techniques/plateaus/plateaus.h"

namespace penumbra {

namespace {

/// Textures in a row, bottom aligned.
DebugImage side_by_side(const std::vector<BakedTexture>& textures, std::string caption) {
    DebugImage image;
    image.caption = std::move(caption);
    for (const BakedTexture& texture : textures) {
        image.width_px += texture.width_px;
        image.height_px = std::max(image.height_px, texture.height_px);
    }
    image.rgb.assign(static_cast<std::size_t>(image.width_px) * image.height_px, glm::vec3{0.25F});
    int left = 0;
    for (const BakedTexture& texture : textures) {
        for (int y = 0; y < texture.height_px; ++y) {
            for (int x = 0; x < texture.width_px; ++x) {
                image.rgb[static_cast<std::size_t>(y) * image.width_px + left + x] =
                    glm::vec3{texture.visibility[static_cast<std::size_t>(y) * texture.width_px + x]};
            }
        }
        left += texture.width_px;
    }
    return image;
}

DebugImage planes_picture(const View& view, const PlanarReceivers& receivers) {
    DebugImage image{view.width, view.height, {}, "Each plane with a texture in a colour of its own; grey: none."};
    for (std::size_t i = 0; i < view.size(); ++i) {
        const std::uint8_t p = receivers.plane_of_pixel[i];
        const float hue = 2.399963F * static_cast<float>(p);  // the golden angle keeps neighbours apart
        const glm::vec3 colour = 0.6F + 0.3F * glm::cos(hue + glm::vec3{0.0F, 2.094F, 4.189F});
        const float shade = 0.4F + 0.6F * std::abs(view.normal_ws[i].z);
        image.rgb.push_back(!view.hit(i) ? glm::vec3{0.0F}
                                         : (p == PlanarReceivers::kNone ? glm::vec3{0.5F * shade} : shade * colour));
    }
    return image;
}

}  // namespace

std::vector<DebugView> Plateaus::debug_views(const Plan& plan) const {
    std::vector<DebugView> views;
    if (plan.runs("silhouettes")) {
        views.push_back({"silhouettes", "Silhouettes as the light's centre sees them"});
        views.push_back({"plateaus", "Plateaus: the texture of each plane"});
        views.push_back({"primitives", "Sheets and cones as triangles over the first plane's texture"});
        views.push_back({"planes", "Receiver planes found in the view"});
    }
    return views;
}

DebugImage Plateaus::debug_image(Frame& frame, std::string_view id) {
    if (id == "silhouettes") {
        return view_picture(
            frame, "Edges where light-facing and averted triangles meet: slopes grow from them.",
            [&](RenderTarget& target) {
                draw_silhouettes_in_view(frame, target, silhouettes_, layout_.origin_ws, {1.0F, 0.6F, 0.1F});
            });
    }
    if (id == "planes") {
        return planes_picture(frame.view(), layout_.receivers);
    }
    if (id == "primitives") {
        return primitives_picture(frame);
    }
    const std::vector<BakedTexture> textures = bake(frame);
    return side_by_side(textures, "V on each plane, largest first; black is the hard shadow, its rim the slopes.");
}

DebugImage Plateaus::primitives_picture(Frame& frame) {
    if (layout_.blocks.empty()) {
        return {};
    }
    std::vector<BakedTexture> textures = bake(frame);
    textures.resize(1);
    DebugImage image = side_by_side(textures, "");
    const glm::ivec4 size = layout_.blocks[0].size;
    const TextureImage colour = TextureImage::make_2d(GL_RGBA32F, size.x, size.y, "picture of sheets and cones");
    RenderTarget target{"picture of sheets and cones"};
    target.attach_colour(0, colour);
    // What was left out first, then what was drawn over it. The counts are those of the frame, not of the whole
    // texture, so the umbra is drawn once more as for that.
    draw_umbra(frame, 0, false);
    if (sifts_) {
        find_covered(frame, 0, false);
    }
    target.bind();
    target.clear_colour(0, glm::vec4{0.0F});
    wireframe_ = true;
    for (const bool hidden_ones : {true, false}) {
        sift(frame, 0, hidden_ones || !sifts_, false);
        target.bind();
        glDisable(GL_DEPTH_TEST);
        glDisable(GL_BLEND);
        glPolygonMode(GL_FRONT_AND_BACK, GL_LINE);
        show_hidden_ = hidden_ones && sifts_;
        draw_primitives(frame, 0);
        glPolygonMode(GL_FRONT_AND_BACK, GL_FILL);
    }
    wireframe_ = false;
    show_hidden_ = false;
    const gpu::PlaneDraws counts = draws_.read<gpu::PlaneDraws>()[0];
    sift(frame, 0, !sifts_, cuts_to_tiles_);
    draw_slopes(frame, 0);
    drawn_whole_ = drawn_whole_ && !wanted_;
    const std::vector<glm::vec4> lines = colour.read<glm::vec4>();
    for (std::size_t i = 0; i < lines.size() && i < image.rgb.size(); ++i) {
        image.rgb[i] = lines[i].w > 0.0F ? glm::vec3{lines[i]} : 0.75F * image.rgb[i];
    }
    image.caption = "Triangles of the slopes over the first plane's texture: sheets blue, cones orange; red: " +
                    std::to_string(counts.hidden) + " of " + std::to_string(counts.in_window) +
                    " silhouettes were left out, under the umbra or where no pixel looks.";
    return image;
}

std::vector<BakedTexture> Plateaus::bake(Frame& frame) {
    std::vector<BakedTexture> textures;
    if (!frame.plan().runs("silhouettes")) {
        return textures;
    }
    for (std::size_t p = 0; p < layout_.blocks.size() && !drawn_whole_; ++p) {
        draw_plane(frame, p, true);
    }
    drawn_whole_ = true;
    const std::vector<float> all = slopes_.read<float>();
    const std::size_t layer = static_cast<std::size_t>(layout_.width_px) * layout_.height_px;
    for (std::size_t p = 0; p < layout_.blocks.size(); ++p) {
        const PlanarReceiver& plane = layout_.receivers.planes[p];
        const gpu::PlateauPlane& block = layout_.blocks[p];
        BakedTexture& texture = textures.emplace_back();
        texture.name = plane.name;
        texture.width_px = block.size.x;
        texture.height_px = block.size.y;
        for (int y = 0; y < block.size.y; ++y) {
            for (int x = 0; x < block.size.x; ++x) {
                double v = all[p * layer + static_cast<std::size_t>(y) * layout_.width_px + x];
                if (store_ == Store::Depth) {
                    v = (v - hither_yon_.x) / static_cast<double>(hither_yon_.y - hither_yon_.x);
                }
                v = std::min(std::abs(v), 1.0);
                v = both_sides_ ? v : plateau::falloff(static_cast<plateau::Falloff>(falloff_), v);
                texture.visibility.push_back(static_cast<float>(dark_ + (1.0 - dark_) * v));
            }
        }
        const glm::dvec2 low{block.window};
        const glm::dvec2 high = low + static_cast<double>(block.window.z) * glm::dvec2{block.size};
        const std::array<glm::dvec2, 4> uv{low, {high.x, low.y}, high, {low.x, high.y}};
        for (std::size_t c = 0; c < 4; ++c) {
            texture.corners_ws[c] = plane.origin_ws + uv[c].x * plane.axis_x + uv[c].y * plane.axis_y;
        }
    }
    return textures;
}

}  // namespace penumbra
