#pragma once

#include <array>
#include <vector>

#include "geometry/linear_light.h"
#include "gl/buffer.h"
#include "gl/framebuffer.h"
#include "gl/handles.h"
#include "gl/texture.h"
#include "techniques/linear_light_maps/linear_views.h"

namespace penumbra {

class Frame;

/// The second channel of linear light maps: where a depth map of one sample jumps, a skin hangs between the caster's
/// edge and what lies behind it, and is drawn as the neighbouring sample sees it. Nothing is read back: spans are
/// appended to buffers that begin with the command of the indirect draw which uses them.
class SkinPass {
public:
    explicit SkinPass(const SkinRules& rules) : rules_{rules} {}

    /// @param layers  of the depth array
    void allocate(int size_px, int layers);
    /// Channels of all samples of a rod, from `depths`, whose layer first_layer + window * samples + sample is what
    /// that sample sees.
    void draw(Frame& frame, const LinearViews& views, const TextureImage& depths, int first_layer);

    /// Every entry what it is where no skin is drawn.
    void clear(int first_layer, int count);

    /// RG16F: what of the segment before (r) and after (g) the sample is seen by one whom it lights; 1/2 without a
    /// skin.
    [[nodiscard]] const TextureImage& channels() const noexcept { return channels_; }
    /// Longest skin that casters at `nearest_m` can have, in texels.
    [[nodiscard]] static double longest_skin_px(const LinearViews& views, std::size_t window);
    [[nodiscard]] std::size_t bytes() const noexcept;

    /// Of the last draw(): waits for the GPU.
    struct Counts {
        std::size_t spans = 0, dropped = 0;
    };
    void count_spans(bool on) noexcept { counting_ = on; }
    [[nodiscard]] const Counts& counts() const noexcept { return counts_; }
    void reset_counts() noexcept { counts_ = {}; }

private:
    void find(Frame& frame, const LinearViews& views, std::size_t window, int sample, int layer);
    void draw_towards(Frame& frame, const LinearViews& views, std::size_t window, int from, int to, int first_layer);

    SkinRules rules_;
    bool counting_ = false;
    Counts counts_;
    int size_px_ = 0;
    int capacity_ = 0;
    TextureImage channels_, order_;
    std::vector<RenderTarget> targets_;
    RenderTarget search_;
    std::array<StorageBuffer, 2> spans_;  ///< towards the next sample, towards the one before
    VertexArray no_attributes_;
};

}  // namespace penumbra
