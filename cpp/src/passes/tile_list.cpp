#include "passes/tile_list.h"

#include <array>

#include "passes/frame.h"

namespace penumbra {

namespace {

/// An indirect draw, as OpenGL has it.
struct Header {
    std::uint32_t vertices = 4, tiles = 0, first_vertex = 0, first_instance = 0;
};

}  // namespace

void TileList::allocate(std::size_t tiles) {
    const std::size_t bytes = sizeof(Header) + tiles * sizeof(Tile);
    if (buffer_.bytes() < bytes) {
        buffer_ = StorageBuffer();
        buffer_ = StorageBuffer(bytes, "wanted tiles");
    }
    if (!no_attributes_) {
        no_attributes_ = VertexArray::create();
    }
}

Defines TileList::defines(bool written) {
    return {{"TILE_PX", std::to_string(TileGrid::kTile_px)}, {"WANTED_TILES_ACCESS", written ? "" : "readonly"}};
}

void TileList::find(Frame& frame, const TextureImage& classes, unsigned wanted) {
    const TileGrid grid{classes.width(), classes.height()};
    allocate(grid.wanted.size());
    const std::array<Header, 1> header;
    buffer_.upload(std::span<const Header>{header});
    const Program& program = frame.device().programs.get({"passes/tile_list.comp"}, defines(true));
    program.set("wanted_class", wanted);
    program.set("clip_from_rel", glm::mat4{clip_from_rel(frame.scene().camera)});
    frame.bind_view();
    classes.bind(1);
    bind_storage();
    program.use();
    glDispatchCompute(static_cast<GLuint>(grid.columns), static_cast<GLuint>(grid.rows), 1);
    StorageBuffer::barrier();
}

void TileList::send(const TileGrid& grid) {
    std::vector<Tile> tiles;
    for (std::size_t i = 0; i < grid.wanted.size(); ++i) {
        if (grid.wanted[i] != 0) {
            const auto columns = static_cast<std::size_t>(grid.columns);
            tiles.push_back({static_cast<std::uint32_t>(i % columns), static_cast<std::uint32_t>(i / columns),
                             grid.nearest[i], grid.farthest[i]});
        }
    }
    allocate(tiles.size());
    const std::array<Header, 1> header{Header{.tiles = static_cast<std::uint32_t>(tiles.size())}};
    buffer_.upload(std::span<const Header>{header});
    static_assert(sizeof(Header) == sizeof(Tile));
    buffer_.upload(std::span<const Tile>{tiles}, 1);
}

void TileList::draw(RenderTarget& target, const Program& program) const {
    target.bind();
    program.set("tiles_per_view", glm::vec2{static_cast<float>(target.width()), static_cast<float>(target.height())} /
                                      static_cast<float>(TileGrid::kTile_px));
    program.use();
    bind_storage();
    glDisable(GL_DEPTH_TEST);
    glDepthMask(GL_FALSE);
    glBindVertexArray(no_attributes_.name());
    glBindBuffer(GL_DRAW_INDIRECT_BUFFER, buffer_.name());
    glDrawArraysIndirect(GL_TRIANGLE_STRIP, buffer_offset(0));
    glBindVertexArray(0);
}

std::vector<TileList::Tile> TileList::read() const {
    const Header header = buffer_.read<Header>().front();
    const std::vector<Tile> all = buffer_.read<Tile>();  // the header has the size of one
    return {all.begin() + 1, all.begin() + 1 + header.tiles};
}

}  // namespace penumbra
