#pragma once

#include <optional>

#include "gl/handles.h"
#include "passes/centre_map.h"
#include "passes/tile_list.h"
#include "passes/volume_pass.h"
#include "penumbra/technique.h"
#include "techniques/hybrid/caster_culling.h"

namespace penumbra {

/// Hybrid hard shadows [Chan2004, ChanDurand2004]: a low shadow map decides where its four nearest texels agree; where
/// they differ a shadow's edge may pass, and shadow volumes are counted there alone, under a computation mask. Edges
/// are the volumes' own, whatever the size of the map. What the map does not see at all is missed. Classes, masks,
/// errors by construction: docs/techniques/hybrid.md.
class Hybrid final : public Technique {
public:
    explicit Hybrid(const Settings& settings);
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

    enum class Mask { Auto, Stencil, Tiles, DepthBounds, Discard };
    enum class TileForm { Auto, Gpu, Cpu };
    enum class Ratio { Off, Scalar, Conservative };

private:
    void classify(Frame& frame);
    void install_mask(Frame& frame);
    void find_tagged_tiles(Frame& frame);
    void count(Frame& frame);
    [[nodiscard]] Mask mask_for(const Frame& frame) const;
    [[nodiscard]] bool tiles_on_device(const Frame& frame) const;
    [[nodiscard]] DebugImage class_picture(Frame& frame);
    [[nodiscard]] DebugImage tagged_picture(Frame& frame);
    [[nodiscard]] DebugImage tile_picture(Frame& frame);

    CentreMap map_;
    VolumePass volumes_;
    Mask mask_ = Mask::Auto;
    TileForm tile_form_ = TileForm::Auto;
    Ratio ratio_ = Ratio::Off;
    bool cull_casters_ = false;
    CasterCulling culling_;
    bool pcf_form_ = false, receiver_plane_ = true;
    float bias_texels_ = 0.0F;
    TextureImage classes_;
    RenderTarget class_target_;
    Query any_tagged_;
    TextureImage masked_depth_;  ///< depth bounds only: the view's depth, 0 where no pixel is tagged
    RenderTarget masked_target_;
    VertexArray no_attributes_;
    RenderTarget stencil_target_;
    GLuint stencil_texture_ = 0;  ///< that stencil_target_ has
    Sampler compare_;
    TileList tile_list_;         ///< Mask::Tiles only
    TileGrid tiles_;             ///< likewise, sorted by the processor
    std::vector<float> depths_;  ///< likewise: of the view
};

}  // namespace penumbra
