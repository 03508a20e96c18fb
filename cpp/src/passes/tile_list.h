#pragma once

#include <cstdint>
#include <vector>

#include "geometry/volume_tiles.h"
#include "gl/buffer.h"
#include "gl/framebuffer.h"
#include "gl/handles.h"
#include "gl/program.h"
#include "gl/texture.h"

namespace penumbra {

class Frame;

/// The tiles of the view that hold pixels of one class, on the device: a list that heads itself with an indirect draw,
/// so that nobody need wait to learn how long it is. Its order means nothing.
class TileList {
public:
    /// What a shader reads; std430.
    struct Tile {
        std::uint32_t column = 0, row = 0;
        float nearest = 0.0F, farthest = 1.0F;  ///< of its wanted pixels: reversed depth
        bool operator==(const Tile&) const = default;
    };

    /// By compute shader, one group per tile, from the classes and positions of all pixels.
    /// @param classes  R8UI of the view's size
    void find(Frame& frame, const TextureImage& classes, unsigned wanted);
    /// For shaders that include lib/wanted_tiles.glsl.
    [[nodiscard]] static Defines defines(bool written = false);
    /// What the processor found.
    void send(const TileGrid& grid);

    void bind_storage() const { buffer_.bind_storage(0); }  ///< as lib/wanted_tiles.glsl has it
    /// A rectangle for each tile. @param program  made with "passes/tile_rectangles.vert"
    void draw(RenderTarget& target, const Program& program) const;

    /// Waits for the device.
    [[nodiscard]] std::vector<Tile> read() const;
    [[nodiscard]] std::size_t bytes() const noexcept { return buffer_.bytes(); }

private:
    void allocate(std::size_t tiles);

    StorageBuffer buffer_;
    VertexArray no_attributes_;
};

}  // namespace penumbra
