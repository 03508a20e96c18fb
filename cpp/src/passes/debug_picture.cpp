#include "passes/debug_picture.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>

#include "passes/centre_map.h"
#include "passes/frame.h"
#include "passes/silhouette_pass.h"

namespace penumbra {

namespace {

constexpr const char* kFullscreen = "lib/fullscreen.vert";

/// Puts `tile` beside what is there already.
void append_right(DebugImage& image, const std::vector<glm::vec3>& tile, int width_px, int height_px) {
    DebugImage wider = image;
    wider.width_px = image.width_px + width_px;
    wider.height_px = std::max(image.height_px, height_px);
    wider.rgb.assign(static_cast<std::size_t>(wider.width_px) * static_cast<std::size_t>(wider.height_px),
                     glm::vec3{0.0F});
    const auto copy = [&](const std::vector<glm::vec3>& from, int from_width, int from_height, int at_x) {
        for (int y = 0; y < from_height; ++y) {
            std::copy_n(from.begin() + static_cast<std::ptrdiff_t>(y) * from_width, from_width,
                        wider.rgb.begin() + static_cast<std::ptrdiff_t>(y) * wider.width_px + at_x);
        }
    };
    copy(image.rgb, image.width_px, image.height_px, 0);
    copy(tile, width_px, height_px, image.width_px);
    image = std::move(wider);
}

std::vector<glm::vec3> read_rgb(const TextureImage& colours) {
    const auto texels = colours.read<glm::vec4>();
    std::vector<glm::vec3> rgb(texels.size());
    std::ranges::transform(texels, rgb.begin(), [](const glm::vec4& texel) { return glm::vec3{texel}; });
    return rgb;
}

/// Stored depths to show as dark and bright: without the outermost fiftieths, since one near fence would leave the rest
/// black.
glm::vec2 range_of(std::vector<float> stored) {
    std::erase(stored, 0.0F);
    if (stored.empty()) {
        return {0.0F, 1.0F};
    }
    std::ranges::sort(stored);
    const std::size_t cut = stored.size() / 50;
    const float low = stored[cut];
    const float high = stored[stored.size() - 1 - cut];
    return {low, high > low ? high : low + 1e-6F};
}

/// State that an overlay starts from and that nobody after it is left with.
void draw_overlay(RenderTarget& target, const std::function<void()>& draw) {
    target.bind();
    glDisable(GL_DEPTH_TEST);
    glDisable(GL_BLEND);
    glDisable(GL_CULL_FACE);
    draw();
    glDisable(GL_BLEND);
    glPolygonMode(GL_FRONT_AND_BACK, GL_FILL);
}

}  // namespace

DebugImage view_picture(const Frame& frame, std::string caption, const std::function<void(RenderTarget&)>& draw) {
    const TextureImage colours =
        TextureImage::make_2d(GL_RGBA32F, frame.view().width, frame.view().height, "debug picture");
    RenderTarget target{"debug picture"};
    target.attach_colour(0, colours);
    frame.bind_view();
    glDisable(GL_BLEND);
    frame.fullscreen().draw(target, frame.device().programs.get({kFullscreen, "passes/debug_view.frag"}));
    draw_overlay(target, [&] { draw(target); });
    return {frame.view().width, frame.view().height, read_rgb(colours), std::move(caption)};
}

DebugImage map_picture(const Frame& frame, CentreMap& map, std::string caption,
                       const std::function<void(int face, RenderTarget&)>& draw) {
    DebugImage image;
    image.caption = std::move(caption);
    const TextureImage colours = TextureImage::make_2d(GL_RGBA32F, map.size_px(), map.size_px(), "debug picture");
    RenderTarget target{"debug picture"};
    target.attach_colour(0, colours);
    Defines defines = map.defines();
    std::erase_if(defines, [](const Define& define) { return !define.name.starts_with("MAP_"); });
    const Program& background = frame.device().programs.get({kFullscreen, "passes/debug_map.frag"}, defines);
    const auto depths = map.texture().read<float>();
    const auto layer_size = static_cast<std::ptrdiff_t>(map.size_px()) * map.size_px();
    for (std::size_t i = 0; i < map.frustum().faces.size(); ++i) {
        const auto first = depths.begin() + static_cast<std::ptrdiff_t>(i) * layer_size;
        background.set("dark_bright", range_of({first, first + layer_size}));
        const int face = static_cast<int>(i);
        map.bind_space();
        map.texture().bind(2);
        background.set("layer", face);
        frame.fullscreen().draw(target, background);
        draw_overlay(target, [&] { draw(face, target); });
        append_right(image, read_rgb(colours), map.size_px(), map.size_px());
    }
    return image;
}

DebugView depth_map_view() {
    return {"depth_map", "Depth map"};
}

DebugImage depth_map_picture(const Frame& frame, CentreMap& map) {
    return map_picture(frame, map, "what the light's centre sees, nearest brightest, one square per face of the map",
                       [](int, RenderTarget&) {});
}

DebugImage texture_picture(const TextureImage& texture, int component, float low, float high, std::string caption) {
    DebugImage image;
    std::array<char, 64> range{};
    std::snprintf(range.data(), range.size(), " (black %.3g, white %.3g)", static_cast<double>(low),
                  static_cast<double>(high));
    image.caption = std::move(caption) + range.data();
    const auto components = static_cast<std::size_t>(texture.components());
    std::vector<float> values;
    if (components == 1) {
        values = texture.read<float>();
    } else {
        const auto flatten = [&values](const auto& texels) {
            for (const auto& texel : texels) {
                for (glm::length_t i = 0; i < texel.length(); ++i) {
                    values.push_back(texel[i]);
                }
            }
        };
        if (components == 2) {
            flatten(texture.read<glm::vec2>());
        } else {
            flatten(texture.read<glm::vec4>());
        }
    }
    const std::size_t layer_size =
        static_cast<std::size_t>(texture.width()) * static_cast<std::size_t>(texture.height());
    for (int layer = 0; layer < texture.layers(); ++layer) {
        std::vector<glm::vec3> tile(layer_size);
        for (std::size_t i = 0; i < layer_size; ++i) {
            const float value = values[(static_cast<std::size_t>(layer) * layer_size + i) * components +
                                       static_cast<std::size_t>(component)];
            tile[i] = std::isfinite(value) ? glm::vec3{std::clamp((value - low) / (high - low), 0.0F, 1.0F)}
                                           : glm::vec3{1.0F, 0.0F, 1.0F};
        }
        append_right(image, tile, texture.width(), texture.height());
    }
    return image;
}

void draw_silhouettes_in_view(Frame& frame, RenderTarget& target, SilhouettePass& silhouettes,
                              const glm::dvec3& origin_ws, const glm::vec3& colour) {
    const Program& program =
        frame.device().programs.get({"passes/debug_lines_in_view.vert", "passes/debug_lines_in_view.frag"});
    target.bind();
    program.set("clip_from_rel", glm::mat4{clip_from_rel(frame.scene().camera)});
    program.set("origin_cr", glm::vec3{origin_ws - frame.summary().eye_ws});
    program.set("colour", colour);
    frame.bind_view();
    silhouettes.bind(0);
    program.use();
    glEnable(GL_BLEND);
    glBlendEquation(GL_FUNC_ADD);
    glBlendFunc(GL_SRC_ALPHA, GL_ONE_MINUS_SRC_ALPHA);
    silhouettes.draw(frame, GL_LINES, 2);
    glDisable(GL_BLEND);
}

void draw_silhouettes_in_map(Frame& frame, RenderTarget& target, SilhouettePass& silhouettes, CentreMap& map, int face,
                             const glm::vec3& colour) {
    Defines defines = map.defines();
    std::erase_if(defines, [](const Define& define) { return !define.name.starts_with("MAP_"); });
    const Program& program =
        frame.device().programs.get({"passes/debug_lines_in_map.vert", "passes/debug_flat.frag"}, defines);
    target.bind();
    map.bind_space();
    program.set("face_index", face);
    program.set("colour", colour);
    silhouettes.bind(0);
    program.use();
    silhouettes.draw(frame, GL_LINES, 2);
}

}  // namespace penumbra
