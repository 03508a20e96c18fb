#pragma once

#include <glm/glm.hpp>
#include <vector>

#include "gl/framebuffer.h"
#include "gl/texture.h"
#include "passes/centre_map.h"
#include "passes/silhouette_pass.h"

namespace penumbra {

class Frame;

/// For techniques that let a penumbra reach into the hard shadow (`sides = both`): per texel of the map, the nearest
/// silhouette edge seen from inside the shadow, as (outer unit normal xy, distance, w of the edge's nearest point).
/// Drawn from the inner sides of the silhouette records: a sheet per edge, a wedge where sheets leave a gap; where
/// several overlap, the one with the least distance over reach is kept. An edge behind whose outer side a caster
/// blocks at the edge's own depth or nearer (casters that touch, an edge in another caster's shadow) is not drawn.
///
/// Lengths are "unit": the image plane (tangents; orthographic: metres) after the inverse of `ip_from_unit`. w: 1/z_ls,
/// orthographic -z_ls. See lib/edge_space.glsl. The receiver's own depth is not needed here: it is known at lookup,
/// where lib/inner_edges.glsl gives the receiver's distance from the edge and how far it is open beyond.
///
///     InnerEdges inner;
///     prepare:  inner.allocate(map.size_px(), faces);
///     update:   after CentreMap::update and SilhouettePass::extract, in a step of your own:
///               inner.draw(frame, silhouettes, map, {.fixed = t});      // or .per_w = r, .ip_from_unit = ...
///     resolve:  defines + inner.defines(unit); inner.bind(unit); inner.set_uniforms(program)
///               in GLSL: InnerEdge edge = read_inner_edge(look); float open = open_beyond(edge, look, reach);
///               with `reach` the half width of the penumbra at the receiver and u = -edge.distance / reach:
///               V = edge.found ? fraction(u) - fraction(-(edge.distance + open) / reach) : 0
///               (open == reach: nothing to take off, since then fraction(<= -1) = 0).
class InnerEdges {
public:
    /// Half width of the inner band at an edge: fixed + per_w * (w_edge - w of the deepest receiver), unit lengths.
    struct Reach {
        double fixed = 0.0;
        double per_w = 0.0;
        glm::dmat2 ip_from_unit{1.0};  ///< of positive determinant
    };

    /// @throws InvalidSettings or OutOfMemory with size and layers
    void allocate(int size_px, int layers);
    /// All faces. Leaves blending and the depth test off.
    void draw(Frame& frame, SilhouettePass& silhouettes, CentreMap& map, const Reach& reach);

    /// INNER_BINDING for lib/inner_edges.glsl.
    [[nodiscard]] static Define define(int unit) { return {"INNER_BINDING", std::to_string(unit)}; }
    void bind(int unit) const { texture_.bind(static_cast<GLuint>(unit)); }
    /// Lookup programs: `unit_from_ip` and `ip_from_unit` as in the last draw().
    void set_uniforms(const Program& program) const;

    /// RGBA32F, one layer per face; z < 0 where there is no edge.
    [[nodiscard]] const TextureImage& texture() const noexcept { return texture_; }
    [[nodiscard]] std::size_t bytes() const noexcept;

private:
    Reach reach_;
    TextureImage texture_, depth_;
    std::vector<RenderTarget> targets_;
};

}  // namespace penumbra
