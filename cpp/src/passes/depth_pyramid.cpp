#include "passes/depth_pyramid.h"

#include <algorithm>
#include <bit>

#include "passes/frame.h"

namespace penumbra {

void DepthPyramid::update(Frame& frame, const TextureImage& depth_map) {
    const int size = std::max(1, depth_map.width() / 2);
    if (!texture_ || texture_.width() != size || texture_.layers() != depth_map.layers()) {
        const int level_count = static_cast<int>(std::bit_width(static_cast<unsigned>(size)));
        levels_.clear();
        texture_ = TextureImage::make_array(GL_RG32F, size, size, depth_map.layers(), "depth pyramid", level_count);
        levels_.resize(static_cast<std::size_t>(depth_map.layers()));
        for (int layer = 0; layer < depth_map.layers(); ++layer) {
            for (int level = 0; level < level_count; ++level) {
                RenderTarget& target = levels_[static_cast<std::size_t>(layer)].emplace_back("depth pyramid");
                target.attach_colour(0, texture_, layer, level);
            }
        }
    }
    ProgramLibrary& programs = frame.device().programs;
    const Program& first = programs.get({"lib/fullscreen.vert", "passes/depth_pyramid.frag"}, {{"FIRST", "1"}});
    const Program& next = programs.get({"lib/fullscreen.vert", "passes/depth_pyramid.frag"}, {{"FIRST", "0"}});
    glDisable(GL_BLEND);
    for (int level = 0; level < texture_.levels(); ++level) {
        const Program& program = level == 0 ? first : next;
        (level == 0 ? depth_map : texture_).bind(2);
        if (level > 0) {  // only the level below is open to reading while this one is written
            glTextureParameteri(texture_.name(), GL_TEXTURE_BASE_LEVEL, level - 1);
            glTextureParameteri(texture_.name(), GL_TEXTURE_MAX_LEVEL, level - 1);
        }
        for (std::size_t layer = 0; layer < levels_.size(); ++layer) {
            program.set("layer", static_cast<int>(layer));
            frame.fullscreen().draw(levels_[layer][static_cast<std::size_t>(level)], program);
        }
    }
    glTextureParameteri(texture_.name(), GL_TEXTURE_BASE_LEVEL, 0);
    glTextureParameteri(texture_.name(), GL_TEXTURE_MAX_LEVEL, texture_.levels() - 1);
}

}  // namespace penumbra
