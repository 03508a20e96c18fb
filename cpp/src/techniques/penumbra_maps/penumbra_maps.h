#pragma once

#include <optional>
#include <vector>

#include "geometry/cone_base.h"
#include "passes/centre_map.h"
#include "passes/inner_edges.h"
#include "passes/silhouette_pass.h"
#include "penumbra/technique.h"

namespace penumbra {

/// Penumbra maps [WymanHansen2003]: a second map beside the depth map from the light's centre keeps, for the nearest
/// surface of each texel, how far it is out of the hard shadow's edge: cones hang from silhouette vertices and sheets
/// from silhouette edges, as wide as the light makes them, and the darkest wins. The hard shadow stands in for the
/// umbra, so the published form makes the outer half of the penumbra only: V = 0 at the hard edge, and on a straight
/// edge the error is that of a step. `sides = both` (ours) is right there and reaches inwards.
///
/// Modes: exact (default) draws homogeneously with analytic cones and affine 1/depth; literal as published, with fans
/// of facets and subdivided sheets in perspective. What is exact, what is wrong by construction and by how much:
/// docs/techniques/penumbra_maps.md.
class PenumbraMaps final : public Technique {
public:
    explicit PenumbraMaps(const Settings& settings);
    [[nodiscard]] static const TechniqueInfo& description();

    [[nodiscard]] const TechniqueInfo& info() const noexcept override { return description(); }
    [[nodiscard]] Verdict supports(const Light& light) const override;
    [[nodiscard]] Plan plan(const LightSummary& summary) const override;
    [[nodiscard]] FieldOfUse field_of_use() const override;
    void prepare(Frame& frame) override;
    void update(Frame& frame) override;
    void resolve(Frame& frame) override;
    [[nodiscard]] std::size_t memory_bytes() const noexcept override;
    [[nodiscard]] std::vector<DebugView> debug_views(const Plan& plan) const override;
    [[nodiscard]] DebugImage debug_image(Frame& frame, std::string_view id) override;
    [[nodiscard]] std::vector<Statistic> statistics(Frame& frame) override;

private:
    enum class Ramp { Depth, Image, Exact };
    enum class Falloff { Smoothstep, Linear, Area };  ///< FALLOFF of ramp.glsl
    struct Options {
        bool literal = false, both_sides = false, gather = false, by_depth_test = false, trim = true, packed = false;
        Ramp ramp = Ramp::Depth;
        std::optional<Falloff> falloff;  ///< none: by sides and shape
        ConeShape shape = ConeShape::Disc;
        GLenum format = GL_R32F;
        int facets = 24, parts = 8;
        int caster_triangles = 0;  ///< 0: in full
    };
    [[nodiscard]] static Options options_from(const Settings& settings);

    [[nodiscard]] std::string too_narrow(const LightSummary& summary) const;
    [[nodiscard]] Falloff falloff() const;
    [[nodiscard]] Defines shape_defines() const;
    [[nodiscard]] Defines drawing_defines() const;
    [[nodiscard]] const Program& lookup(Frame& frame) const;
    void allocate(Frame& frame);
    void attach();
    void simplify_casters(Frame& frame);
    void draw_penumbra(Frame& frame);
    /// Cones and sheets of one face, with the mode's own fragment shader unless `fragment` names another.
    void draw_primitives(Frame& frame, std::size_t face_index, std::string_view fragment);
    static void set_shape(const Program& program, const ConeBase& base);
    static void set_contact(const Program& program, const MapFace& face);
    void pack(Frame& frame);

    Options options_;
    bool soft_ = false;  ///< the plan has a penumbra
    CentreMap map_;
    SilhouettePass silhouettes_;
    GpuScene caster_scene_;  ///< with simplified meshes, the same instances
    GpuAdjacency caster_adjacency_;
    InnerEdges inner_;
    std::vector<ConeBase> bases_;         ///< one per face
    MapLayers::Lease penumbra_, packed_;  ///< layers of arrays that lights share, as the depth map's are
    TextureImage order_;
    std::vector<RenderTarget> targets_, packed_targets_;
    glm::uvec2 attached_{0};  ///< generations of the leases that the targets hold
};

}  // namespace penumbra
