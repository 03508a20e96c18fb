#pragma once

#include <glm/glm.hpp>

#include "geometry/smoothie.h"
#include "gl/framebuffer.h"
#include "gl/texture.h"
#include "passes/centre_map.h"
#include "passes/inner_edges.h"
#include "passes/silhouette_pass.h"

namespace penumbra {

class Frame;

/// What is drawn into the smoothie buffer.
struct SmoothieOptions {
    enum class Width { Light, Disc, Fixed };
    enum class Corners { Fan, Thesis, None };
    enum class Passes { Merged, Separate };
    Width width = Width::Light;
    double t = 0.05;  ///< Fixed: half extents of the widest face
    bool remap = true;
    bool resize_per_vertex = false;
    bool depth_from_casters = false;  ///< as published: r comes from the casters alone
    Corners corners = Corners::Fan;
    Passes passes = Passes::Merged;
};

/// Smallest alpha, and nearest smoothie depth where it is asked for, of all smoothies over each texel of a map
/// [Chan2004]. Quads and wedges come straight from the silhouette records; overlaps combine by minimum, so neither the
/// order of triangles nor a doubled edge matters.
class SmoothieBuffer {
public:
    explicit SmoothieBuffer(const SmoothieOptions& options) : options_{options} {}

    /// @param with_depth keep the smoothies' own depth
    /// @throws InvalidSettings or OutOfMemory with size and layers
    void allocate(int size_px, int layers, bool with_depth);
    /// All faces, after CentreMap::update() and SilhouettePass::extract(). Leaves blending and depth test off.
    void draw(Frame& frame, SilhouettePass& silhouettes, CentreMap& map);
    /// Wireframe of what draw() draws, for debug views.
    void draw_outlines(Frame& frame, RenderTarget& target, SilhouettePass& silhouettes, CentreMap& map, int face);

    /// WIDTH_SHAPE, FIXED_WIDTH and REMAP of ramp.glsl, after CentreMap::allocate().
    [[nodiscard]] Defines ramp_defines(Frame& frame, const CentreMap& map) const;
    /// The same widths inside the hard edge: of the band, and for the lookup (light_u_ws, ...).
    [[nodiscard]] InnerEdges::Reach inner_reach(Frame& frame, const CentreMap& map) const;
    void set_light(const Program& program, Frame& frame, const CentreMap& map) const;

    /// R32F alpha, or RG32F alpha and minus the depth (reversed window depth).
    [[nodiscard]] TextureImage& alpha() noexcept { return alpha_; }
    /// Passes::Separate with depth only; else empty.
    [[nodiscard]] TextureImage& depth() noexcept { return depth_; }
    [[nodiscard]] std::size_t bytes() const noexcept;

private:
    [[nodiscard]] bool thesis() const noexcept { return options_.corners == SmoothieOptions::Corners::Thesis; }
    [[nodiscard]] Defines defines(Frame& frame, const CentreMap& map) const;
    [[nodiscard]] const Program& program(Frame& frame, CentreMap& map, int target) const;
    void set_uniforms(const Program& program, Frame& frame, CentreMap& map, int index) const;

    SmoothieOptions options_;
    TextureImage alpha_, depth_;
    StorageBuffer tips_;
    std::vector<RenderTarget> targets_, depth_targets_;
    GLuint attached_ = 0;  ///< depth map that the targets test against
};

/// The plain t as a length in the image plane: t half extents of the map's widest face (tangents; a sun: metres).
[[nodiscard]] double plain_width_ip(const MapFrustum& frustum, double t) noexcept;

}  // namespace penumbra
