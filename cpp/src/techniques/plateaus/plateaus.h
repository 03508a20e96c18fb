#pragma once

#include "passes/centre_map.h"
#include "passes/silhouette_pass.h"
#include "penumbra/technique.h"
#include "techniques/plateaus/plane_block.h"

namespace penumbra {

/// Plateaus [Haines2001]: on each receiver plane a texture of the hard shadow with slopes around it, a cone for each
/// silhouette vertex and a sheet for each silhouette edge, as wide as the light's image through them; where slopes
/// overlap the darkest stays. One pass, no noise, no bias; exact in width outside the hard shadow, nothing inside
/// unless `sides` is `both`. Pixels on no plane take the depth map's hard shadow and the slopes of the plane behind
/// them. Formulas, variants and their errors: docs/techniques/plateaus.md.
class Plateaus final : public Technique {
public:
    explicit Plateaus(const Settings& settings);
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
    [[nodiscard]] std::vector<BakedTexture> bake(Frame& frame) override;

private:
    enum class Sheets { Envelope, Bilinear, Tessellated };
    enum class Store { Float, Byte, Depth };
    /// Of slopes cut to tiles, on one plane; the rest stays whole.
    static constexpr std::size_t kMostPieces = std::size_t{1} << 19U;
    static constexpr int kLevels = 5;  ///< of covered_; every second one is used: cells of 4, 16 and 64 texels

    /// Planes, textures and what they hold: from view and light alone.
    struct Layout {
        PlanarReceivers receivers;
        std::vector<gpu::PlateauPlane> blocks;
        std::vector<PlateauLight::Frame> frames;
        glm::dvec3 origin_ws{0.0};
        int width_px = 1, height_px = 1;  ///< of a layer
        double widest_texels = 0.0;       ///< largest radius of a penumbra
        bool hard = false;                ///< no penumbra is wider than half a texel: the depth map alone
        bool map = false;                 ///< the depth map is looked up
    };
    [[nodiscard]] Layout lay_out(const LightSummary& summary) const;
    /// Instances whose shadow can meet the plane's texture.
    [[nodiscard]] static std::vector<std::uint32_t> casters_onto(const LightSummary& summary, const Layout& layout,
                                                                 std::size_t plane);
    [[nodiscard]] static std::string step_of(const Layout& layout, std::size_t plane);
    [[nodiscard]] bool slopes_off_planes(const Layout& layout) const noexcept;
    /// Slopes inside the hard shadow are read by nobody.
    [[nodiscard]] bool skips_umbra() const noexcept;
    /// Silhouettes whose slopes change nothing are not drawn, nor texels that no pixel looks up.
    [[nodiscard]] bool sifts(const LightSummary& summary, const Layout& layout) const noexcept;
    [[nodiscard]] bool skips_unseen(const LightSummary& summary, const Layout& layout) const noexcept;
    [[nodiscard]] Defines defines(std::size_t plane) const;
    [[nodiscard]] const Program& lookup(Frame& frame) const;
    /// One indirect draw for each listed silhouette, or several, row by row.
    struct Draw {
        Defines defines;
        int per_edge = 0;
        int rows = 0;  ///< of a tessellated sheet, one draw each; 0: not rows
    };
    [[nodiscard]] bool draws_tight() const noexcept;
    /// What the settings draw for each silhouette, at most three.
    [[nodiscard]] std::vector<Draw> draws() const;
    [[nodiscard]] std::vector<std::uint16_t> texels_looked_up(const View& view) const;
    /// @param whole  texels that no pixel looks up too, for those who keep or show the texture
    void draw_plane(Frame& frame, std::size_t plane, bool whole);
    void draw_umbra(Frame& frame, std::size_t plane, bool whole);
    void find_covered(Frame& frame, std::size_t plane, bool whole);
    void sift(Frame& frame, std::size_t plane, bool keep_all, bool tiles);
    /// Wide slopes are cut to tiles.
    [[nodiscard]] bool cuts_to_tiles(const LightSummary& summary, const Layout& layout) const noexcept;
    /// Where in `listed_` pieces are, behind all records, and the wide records that they are cut from.
    [[nodiscard]] std::uint64_t first_piece() const noexcept;
    [[nodiscard]] std::uint64_t first_wide() const noexcept;
    void draw_slopes(Frame& frame, std::size_t plane);
    void draw_primitives(Frame& frame, std::size_t plane);
    [[nodiscard]] DebugImage primitives_picture(Frame& frame);
    void send_mail(Frame& frame);
    void bind_block();

    PlanarReceiverOptions finding_;
    PlateauOptions shape_;
    double plane_tolerance_;
    int size_px_;
    Sheets sheets_;
    int cells_;
    bool fans_;
    int segments_;
    EdgeChoice edges_;
    Store store_;
    glm::vec2 hither_yon_;
    int falloff_;
    double dark_;
    bool both_sides_;
    bool narrow_;
    bool soft_off_planes_;
    bool wireframe_ = false;    ///< while the picture of the primitives is drawn,
    bool show_hidden_ = false;  ///< in the colour of those that are left out
    bool drawn_whole_ = true;   ///< the textures hold texels that no pixel looks up
    bool sifts_ = false;
    bool cuts_to_tiles_ = false;

    CentreMap map_;
    SilhouettePass silhouettes_;
    Layout layout_;
    PlateauLight light_;
    StorageBuffer instances_, block_, mailboxes_, first_box_;
    StorageBuffer listed_, draws_;  ///< sift.vert: records of the plane at hand; counts and indirect draws by plane
    StorageBuffer darkness_;        ///< of the tiles of the plane at hand: lambda is nowhere above
    VertexArray no_attributes_;
    TextureImage skip_depth_;  ///< 0 in the hard shadow and where nobody looks: slopes are not even computed there
    TextureImage covered_;     ///< the plane at hand: pyramid of covered.comp
    TextureImage wanted_;      ///< 1 where a pixel looks the texel up
    TextureImage slopes_, umbra_, darkest_, plane_of_pixel_;
    std::vector<RenderTarget> umbra_targets_, slope_targets_;
};

}  // namespace penumbra
