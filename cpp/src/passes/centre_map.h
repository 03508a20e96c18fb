#pragma once

#include "passes/depth_map.h"
#include "passes/map_bias.h"
#include "penumbra/plan.h"

namespace penumbra {

class Frame;

/// Depth maps from the light's centre: what every single-map technique shares. One fitted frustum, or the cube faces
/// that hold receivers, or one orthographic map for a sun.
///
/// A technique that draws into the map's own space (cones, smoothie quads) asks for the nearest *receiver* of each
/// texel as well. Where every visible receiver casts, that is the map of casters itself; else a second map holds
/// casters and receivers together.
class CentreMap {
public:
    struct Options {
        int size_px = 1024;
        MapBias bias;
        bool facing_test = true;
        double margin_texels = 2.0;
        bool with_receivers = false;            ///< receiver_texture() is needed
        bool receivers_without_extent = false;  ///< for a light without extent as well (widths that ignore the light)
        bool shared_layers = false;             ///< layers of arrays that lights share (MapLayers)
        bool along_light_normal = false;        ///< see MapFrustumOptions
    };
    explicit CentreMap(const Options& options)
        : options_{options},
          frustum_options_{.size_px = options.size_px,
                           .margin_texels = options.margin_texels,
                           .along_light_normal = options.along_light_normal} {}

    /// Adds one step per face (and per peeled face, and per receiver face), run or left out.
    /// @return false if the light needs no map at all; the reason is in the plan, under all steps and `lookup`
    bool plan(const LightSummary& summary, std::string_view lookup, Plan& plan) const;

    /// The frusta that plan() and update() use.
    [[nodiscard]] MapFrustum fit(const LightSummary& summary) const;

    /// Draws from another set of meshes with the same instances (simplified casters). Receivers that cast are then the
    /// simplified ones too, as the silhouettes are.
    void use_casters(GpuScene& gpu_scene) noexcept { caster_scene_ = &gpu_scene; }
    /// How far those may stand in front of what is seen; added to the bias.
    void set_bias_metres(double metres) noexcept { options_.bias.metres = static_cast<float>(metres); }

    void allocate(Frame& frame);
    void update(Frame& frame);
    /// The lookup program for the frustum at hand; `fragment` includes lib/map_lookup.glsl and lib/bias.glsl.
    [[nodiscard]] const Program& lookup(Frame& frame, std::string_view fragment, const Defines& more = {}) const;
    /// Any program that includes lib/map_lookup.glsl (MAP_FACES, MAP_ORTHOGRAPHIC and the bias compiled in).
    [[nodiscard]] Defines defines() const { return options_.bias.defines(frustum_, options_.facing_test); }
    [[nodiscard]] bool facing_test() const noexcept { return options_.facing_test; }
    /// Map at texture unit 2, peeled map at 3, block at uniform 1, bias uniforms.
    void bind(const Program& program);
    /// The block alone at uniform 1, for passes that draw into the map's space (lib/map_space.glsl).
    void bind_space() { setup_.bind_for_lookup(block_); }

    /// After allocate().
    [[nodiscard]] const MapFrustum& frustum() const noexcept { return frustum_; }
    [[nodiscard]] int size_px() const noexcept { return options_.size_px; }
    /// Reversed depth of the nearest caster, one layer per face; 0 where there is none.
    [[nodiscard]] TextureImage& texture() noexcept { return map_.texture(); }
    /// The same of the nearest caster or receiver. After update(), with_receivers only.
    [[nodiscard]] TextureImage& receiver_texture() noexcept {
        return receiver_map_.texture() ? receiver_map_.texture() : map_.texture();
    }
    [[nodiscard]] std::size_t bytes() const noexcept {
        return map_.bytes() + second_map_.bytes() + receiver_map_.bytes();
    }

private:
    [[nodiscard]] bool midpoint() const noexcept { return options_.bias.mode == MapBias::Mode::Midpoint; }
    /// Nothing grows from silhouettes where the light has no extent: then the map is the hard shadow map's own.
    [[nodiscard]] bool wants_receivers(const LightSummary& summary) const noexcept {
        return options_.with_receivers && (summary.has_extent || options_.receivers_without_extent);
    }
    [[nodiscard]] bool needs_receiver_map(const LightSummary& summary) const noexcept;

    Options options_;
    MapFrustumOptions frustum_options_;
    GpuScene* caster_scene_ = nullptr;
    MapFrustum frustum_;
    gpu::MapBlock block_{};
    DepthMap map_, second_map_, receiver_map_;
    MapSetup setup_;
};

}  // namespace penumbra
