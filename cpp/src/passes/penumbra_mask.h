#pragma once

#include <cstdint>
#include <span>
#include <string_view>
#include <vector>

#include "geometry/light_region.h"
#include "gl/program.h"
#include "passes/depth_map.h"
#include "passes/depth_pyramid.h"
#include "passes/mask_edges.h"
#include "penumbra/technique.h"

namespace penumbra {

class Frame;

/// Which pixels surely see all of the light, surely nothing of it, and which may lie in a penumbra: Chan's computation
/// mask [Chan2004] carried to lights with region, for every technique that is costly per pixel.
///
/// From the light's centre two maps are drawn: the nearest caster, and the nearest *edge that may be a silhouette from
/// some point of the light* (geometry/region_silhouettes). A pixel is sure if no such edge lies in the window that
/// light and pixel span through the map, nearer than the pixel: V changes over the light only where a ray grazes such
/// an edge. Then the light's centre speaks for all of the light. Proof, limits and figures:
/// docs/decisions/0011-penumbra-mask.md.
class PenumbraMask {
public:
    enum class Class : std::uint8_t { Maybe = 0, Lit = 1, Umbra = 2 };
    enum class Test {
        Edges,  ///< no possible silhouette in the window
        Depth,  ///< all depths of the window on one side: for comparison, not sound (decision 11)
    };
    struct Options {
        int size_px = 512;           ///< made a power of two
        double margin_texels = 1.0;  ///< half the width of an edge in the map, at least sqrt(1/2)
        Test test = Test::Edges;
    };
    explicit PenumbraMask(const Options& options);
    /// The settings mask_size and mask_margin of every technique that has a mask of this kind.
    [[nodiscard]] static std::vector<SettingInfo> settings();
    [[nodiscard]] static Options options_from(const Settings& settings);

    /// The step that finds penumbrae, run or left out: the maps' own, or another's in their place.
    /// @return false if nothing is to be classified: the reason is in the plan
    static bool plan(const LightSummary& summary, Plan& plan, std::string_view step = "penumbra mask");

    void prepare(Frame& frame);
    /// Light space: maps.
    void update(Frame& frame);
    /// View space: classes of all pixels.
    void classify(Frame& frame);

    /// Marks the pixels that may lie in a penumbra with 1 in the stencil of a target of the view's size, the others
    /// with 0. A stencil test then keeps the others from being shaded at all, which `discard` does not on every
    /// rasteriser.
    void write_stencil(Frame& frame, RenderTarget& target) const;

    /// R8 of the view's size, lib/mask_class.glsl. After classify().
    [[nodiscard]] const TextureImage& classes() const noexcept { return classes_; }
    /// The same in main memory; waits for the device.
    void read_classes(std::span<std::uint8_t> classes) const { classes_.read_into(classes); }
    /// Why every pixel is Maybe, or empty: a caster that meets the light, or stands beside a round one.
    [[nodiscard]] std::string_view undecided() const noexcept { return undecided_; }

    [[nodiscard]] std::size_t bytes() const noexcept;
    /// Of the mask's pixels: mask_lit, mask_umbra, mask_maybe.
    [[nodiscard]] static std::vector<Statistic> statistics(const LightSummary& summary,
                                                           std::span<const std::uint8_t> classes);

    [[nodiscard]] static std::vector<DebugView> debug_views();
    [[nodiscard]] DebugImage debug_image(Frame& frame, std::string_view id);

private:
    void fit(const LightSummary& summary);
    [[nodiscard]] Defines defines() const;
    void find_edges(Frame& frame);
    void draw_edges(Frame& frame);
    void make_pyramid(Frame& frame);

    Options options_;
    LightRegion region_;
    MapFrustum frustum_;
    std::vector<MaskFace> faces_;
    gpu::MapBlock block_{};
    DepthMap map_;
    MapSetup setup_;
    std::string_view undecided_;
    std::vector<std::vector<gpu::MaskEdge>> edges_;  ///< per face
    StorageBuffer edge_buffer_;
    DepthPyramid pyramid_;  ///< Test::Depth
    TextureImage nearest_edge_;
    std::vector<std::vector<RenderTarget>> levels_;  ///< per face
    VertexArray no_attributes_;
    TextureImage classes_;
    RenderTarget classes_target_;
};

}  // namespace penumbra
