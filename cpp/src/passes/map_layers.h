#pragma once

#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "gl/texture.h"

namespace penumbra {

/// Map arrays that several lights share: maps of one format and size are layers of one texture array, however many
/// lights and faces they belong to. A lease is a texture view of its own layers, so that shaders and passes see an
/// array that begins at 0 and know of no other light. An array grows by what is asked for and is gone with its last
/// lease; layers that are given back serve the next who fit. On the render thread.
class MapLayers {
    struct Array;
    struct Slot;

public:
    /// Some layers of a shared array; gives them back when it goes. Must not outlive its context.
    class Lease {
    public:
        Lease() noexcept;
        Lease(Lease&& other) noexcept;
        Lease& operator=(Lease&& other) noexcept;
        Lease(const Lease&) = delete;
        Lease& operator=(const Lease&) = delete;
        ~Lease();

        [[nodiscard]] explicit operator bool() const noexcept { return slot_ != nullptr; }
        /// The layers as an array. Another texture after the array has grown: bind it anew for each pass.
        [[nodiscard]] TextureImage& texture() noexcept;
        [[nodiscard]] const TextureImage& texture() const noexcept;
        /// Counts up when texture() became another one, which framebuffers must attach anew.
        [[nodiscard]] unsigned generation() const noexcept;

    private:
        friend class MapLayers;
        explicit Lease(std::unique_ptr<Slot> slot) noexcept;
        std::unique_ptr<Slot> slot_;
    };

    /// Contents are undefined. Those of other leases stay as they are, though their textures may become others.
    /// @param what for messages, of the array's first maps
    /// @throws InvalidSettings or OutOfMemory with size and layers; all leases are then as before
    [[nodiscard]] Lease take(GLenum format, int size_px, int layers, std::string_view what);

    struct Usage {
        int arrays = 0, layers = 0, layers_used = 0;
    };
    [[nodiscard]] Usage usage() const noexcept;

private:
    std::vector<std::weak_ptr<Array>> arrays_;
};

}  // namespace penumbra
