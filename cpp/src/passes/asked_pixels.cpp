#include "passes/asked_pixels.h"

#include <algorithm>
#include <span>

#include "geometry/volume_tiles.h"
#include "passes/frame.h"

namespace penumbra {

namespace {

constexpr std::size_t kMostRectangles = 256;  // each is a draw; where a mask is torn into more, its box serves

glm::ivec4 box_of(const std::vector<glm::ivec4>& rectangles) {
    glm::ivec2 low{rectangles.front()};
    glm::ivec2 high = low;
    for (const glm::ivec4& r : rectangles) {
        low = glm::min(low, glm::ivec2{r});
        high = glm::max(high, glm::ivec2{r} + glm::ivec2{r.z, r.w});
    }
    return {low, high - low};
}

}  // namespace

AskedPixels::AskedPixels(const LightSummary& summary) {
    if (summary.keeps("pixel-outside-mask") || summary.view == nullptr) {
        whole_ = true;
        return;
    }
    const int width = summary.view->width;
    const int height = summary.view->height;
    TileGrid grid{width, height};
    for (int y = 0; y < height; ++y) {
        const auto row = std::span{summary.mask}.subspan(static_cast<std::size_t>(y) * width, width);
        for (int x = 0; x < width; x += TileGrid::kTile_px) {
            std::uint8_t& wanted = grid.wanted[grid.tile_of(x, y)];
            if (wanted == 0) {
                const int end = std::min(x + TileGrid::kTile_px, width);
                wanted = std::any_of(row.begin() + x, row.begin() + end, [](std::uint8_t asked) { return asked != 0; })
                             ? 1
                             : 0;
            }
        }
    }
    std::vector<std::int32_t> rectangle_of;
    std::uint64_t inside = 0;
    for (const TileRectangle& r : rectangles_of(grid, rectangle_of)) {
        const glm::ivec2 low = TileGrid::kTile_px * glm::ivec2{r.column, r.row};
        const glm::ivec2 high =
            glm::min(low + TileGrid::kTile_px * glm::ivec2{r.columns, r.rows}, glm::ivec2{width, height});
        rectangles_.emplace_back(low, high - low);
    }
    if (rectangles_.size() > kMostRectangles) {
        rectangles_ = {box_of(rectangles_)};
    }
    for (const glm::ivec4& r : rectangles_) {
        inside += static_cast<std::uint64_t>(r.z) * static_cast<std::uint64_t>(r.w);
    }
    pixels_outside_ = summary.mask.size() - inside;
    whole_ = pixels_outside_ == 0;
}

void AskedPixels::draw(const Frame& frame, RenderTarget& target, const Program& program) const {
    if (whole_) {
        frame.fullscreen().draw(target, program);
        return;
    }
    glEnable(GL_SCISSOR_TEST);
    for (const glm::ivec4& r : rectangles_) {
        glScissor(r.x, r.y, r.z, r.w);
        frame.fullscreen().draw(target, program);
    }
    glDisable(GL_SCISSOR_TEST);
}

void AskedPixels::tell(Plan& plan) const {
    if (pixels_outside_ > 0) {
        plan.leave_out("pixels outside the mask", "pixel-outside-mask",
                       std::to_string(pixels_outside_) +
                           " pixels lie in tiles that see no surface, or surfaces that face away from the whole light");
    }
}

}  // namespace penumbra
