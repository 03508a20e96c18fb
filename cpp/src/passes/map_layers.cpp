#include "passes/map_layers.h"

#include <algorithm>

namespace penumbra {

/// Slots do not overlap and are sorted by their first layer.
struct MapLayers::Array {
    TextureImage texture;
    std::vector<Slot*> slots;

    /// First layer of a gap of that many, else of the free layers at the end.
    [[nodiscard]] int gap(int layers) const noexcept;
    /// Other texture, with the layers in use copied.
    void grow(int layers);
};

struct MapLayers::Slot {
    Slot(std::shared_ptr<Array> shared, int from, int how_many)
        : array{std::move(shared)}, first{from}, count{how_many} {
        const auto after = std::ranges::find_if(array->slots, [&](const Slot* slot) { return slot->first > first; });
        array->slots.insert(after, this);
        look();
    }
    Slot(const Slot&) = delete;
    Slot& operator=(const Slot&) = delete;
    ~Slot() { std::erase(array->slots, this); }

    void look() {
        view = TextureImage::view_of(array->texture, first, count);
        ++generation;
    }

    std::shared_ptr<Array> array;
    int first, count;
    unsigned generation = 0;
    TextureImage view;
};

int MapLayers::Array::gap(int layers) const noexcept {
    int next = 0;
    for (const Slot* slot : slots) {
        if (slot->first - next >= layers) {
            break;
        }
        next = slot->first + slot->count;
    }
    return next;
}

void MapLayers::Array::grow(int layers) {
    TextureImage larger =
        TextureImage::make_array(texture.format(), texture.width(), texture.height(), layers, texture.what());
    for (const Slot* slot : slots) {
        glCopyImageSubData(texture.name(), GL_TEXTURE_2D_ARRAY, 0, 0, 0, slot->first, larger.name(),
                           GL_TEXTURE_2D_ARRAY, 0, 0, 0, slot->first, texture.width(), texture.height(), slot->count);
    }
    texture = std::move(larger);
    for (Slot* slot : slots) {
        slot->look();
    }
}

MapLayers::Lease::Lease() noexcept = default;
MapLayers::Lease::Lease(std::unique_ptr<Slot> slot) noexcept : slot_{std::move(slot)} {}
MapLayers::Lease::Lease(Lease&& other) noexcept = default;
MapLayers::Lease& MapLayers::Lease::operator=(Lease&& other) noexcept = default;
MapLayers::Lease::~Lease() = default;

TextureImage& MapLayers::Lease::texture() noexcept {
    return slot_->view;
}

const TextureImage& MapLayers::Lease::texture() const noexcept {
    return slot_->view;
}

unsigned MapLayers::Lease::generation() const noexcept {
    return slot_->generation;
}

MapLayers::Lease MapLayers::take(GLenum format, int size_px, int layers, std::string_view what) {
    std::erase_if(arrays_, [](const std::weak_ptr<Array>& array) { return array.expired(); });
    for (const std::weak_ptr<Array>& held : arrays_) {
        const std::shared_ptr<Array> array = held.lock();
        if (array->texture.format() == format && array->texture.width() == size_px) {
            const int first = array->gap(layers);
            if (first + layers > array->texture.layers()) {
                array->grow(first + layers);
            }
            return Lease{std::make_unique<Slot>(array, first, layers)};
        }
    }
    auto array = std::make_shared<Array>();
    array->texture = TextureImage::make_array(format, size_px, size_px, layers, what);
    arrays_.push_back(array);
    return Lease{std::make_unique<Slot>(std::move(array), 0, layers)};
}

MapLayers::Usage MapLayers::usage() const noexcept {
    Usage usage;
    for (const std::weak_ptr<Array>& held : arrays_) {
        if (const std::shared_ptr<Array> array = held.lock()) {
            ++usage.arrays;
            usage.layers += array->texture.layers();
            for (const Slot* slot : array->slots) {
                usage.layers_used += slot->count;
            }
        }
    }
    return usage;
}

}  // namespace penumbra
