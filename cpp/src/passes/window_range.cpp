#include "passes/window_range.h"

#include <algorithm>

#include "passes/frame.h"

namespace penumbra {

void WindowRange::update(Frame& frame, const TextureImage& depth_map, int window_px) {
    const int layers = depth_map.layers();
    if (!textures_[0] || textures_[0].width() != depth_map.width() || textures_[0].layers() != layers) {
        for (std::size_t i = 0; i < textures_.size(); ++i) {
            targets_[i].clear();
            textures_[i] =
                TextureImage::make_array(GL_RG32F, depth_map.width(), depth_map.height(), layers, "window range");
            for (int layer = 0; layer < layers; ++layer) {
                targets_[i].emplace_back("window range").attach_colour(0, textures_[i], layer);
            }
        }
    }
    ProgramLibrary& programs = frame.device().programs;
    glDisable(GL_BLEND);
    bool first = true;
    const auto pass = [&](const glm::ivec2& step) {
        const Program& program =
            programs.get({"lib/fullscreen.vert", "passes/window_range.frag"}, {{"FIRST", first ? "1" : "0"}});
        (first ? depth_map : textures_[last_]).bind(2);
        last_ = 1 - last_;
        program.set("further", step);
        for (int layer = 0; layer < layers; ++layer) {
            program.set("layer", layer);
            frame.fullscreen().draw(targets_[last_][static_cast<std::size_t>(layer)], program);
        }
        first = false;
    };
    // What covers n texels and its copy up to n further cover up to 2 n.
    for (const glm::ivec2& axis : {glm::ivec2{1, 0}, glm::ivec2{0, 1}}) {
        for (int covered = 1; covered < window_px;) {
            const int step = std::min(covered, window_px - covered);
            pass(step * axis);
            covered += step;
        }
    }
    if (first) {
        pass({0, 0});
    }
}

}  // namespace penumbra
