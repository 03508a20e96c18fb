#pragma once

#include <glm/glm.hpp>
#include <span>
#include <vector>

namespace penumbra {

/// Soft shadow maps for linear lights [Heidrich2000] in float64: the oracle of the OpenGL version, and its software
/// engine. All depths are "d", which is affine over the picture of a plane: 1 / z, for a sun the depth in front of a
/// far plane; greater is nearer, 0 nothing. A point that `along` = 0 sees at u is seen at u - along d from elsewhere on
/// the light: points move along rows only. [D: linear-light-soft-shadow-maps 2.1]

enum class LogKernel {
    Three,  ///< 3 x 3, sigma 0.6
    Five,   ///< 5 x 5, sigma 0.8
};
[[nodiscard]] int radius_of(LogKernel kernel) noexcept;
/// The filter's weights, row by row; their sum is 0.
[[nodiscard]] std::vector<double> log_weights(LogKernel kernel);
/// G: the smallest difference of its values on either side of a jump of one, over edges of all directions.
[[nodiscard]] double least_step_response(LogKernel kernel) noexcept;

/// What one sample of the light sees: rows are planes through the light.
struct LinearMap {
    int width_px = 0, height_px = 0;
    double along = 0.0;  ///< place of the sample on the light
    glm::dvec2 low{-1.0}, step{1.0};
    std::vector<double> d;  ///< width x height, row 0 at the bottom

    [[nodiscard]] double u_of(int x) const noexcept { return low.x + (x + 0.5) * step.x; }
    [[nodiscard]] std::size_t index(int x, int y) const noexcept {
        return static_cast<std::size_t>(y) * static_cast<std::size_t>(width_px) + static_cast<std::size_t>(x);
    }
    /// The nearest texel's index, or nothing outside of the map.
    [[nodiscard]] bool find(const glm::dvec2& uv, std::size_t& found) const noexcept;
};

struct SkinRules {
    LogKernel kernel = LogKernel::Three;
    double log_share = 0.5;      ///< threshold on the LoG difference, of what a jump of the least size makes
    double dead_zone = 0.25;     ///< least size of the smaller LoG value, of the threshold
    double least_skin_px = 1.0;  ///< T_disp: shorter skins are no penumbra
    bool exact = false;          ///< rational transition, exact for receivers of any shape; else linear along the skin
    bool darkest = false;        ///< of overlapping skins the darkest, not the nearest to the sample
    bool wall_rule = true;       ///< linear: a skin that lies on a surface, as on a wall of few texels, leaves it lit
    double same_relative = 1e-3, same_absolute = 0.0;  ///< depths that differ by less are the same surface
};

/// Joins a caster's edge in one view to what lies behind it, in one row, as the neighbour sees it.
struct Skin {
    int row = 0;
    double caster_u = 0.0, receiver_u = 0.0, caster_d = 0.0, receiver_d = 0.0;
};

[[nodiscard]] std::vector<double> filter_log(const LinearMap& map, LogKernel kernel);
/// Spans of `from` as `to` sees them; those that fold shut there are left out. [2.4, 2.5]
[[nodiscard]] std::vector<Skin> find_skins(const LinearMap& from, const LinearMap& to, const SkinRules& rules);
/// The entries of `to` for the segment between the two: 1/2 where there is no skin. [2.6]
[[nodiscard]] std::vector<double> draw_skins(const std::vector<Skin>& skins, const LinearMap& from, const LinearMap& to,
                                             const SkinRules& rules);

/// A surface point as lookups see it.
struct LinearPoint {
    glm::dvec2 uv{0.0};  ///< as `along` = 0 sees it
    double d = 0.0;
    bool has_plane = false;     ///< the next two are known
    glm::dvec2 normal_uv{0.0};  ///< components of the geometric normal along u and v
    double towards = 0.0;       ///< distance of the point `along` = 0 from the surface's plane, on its outer side > 0
};

struct LinearLookup {
    double bias = 2e-3;  ///< of z; with has_plane: in texels at the receiver, on top of the plane's own slope
    double bias_px = 0.1;
    double slope_cap_px = 64.0;
    bool rim_rule = true;
    double rim = 3e-2;         ///< of z; parallel: in depth
    bool clamp = true;         ///< a segment counts 1 at most
    bool facing_test = false;  ///< the point's own plane hides what lies behind it; needs has_plane
    bool parallel = false;
};

/// The maps of all samples with both channels of each, and V from them. [2.7 .. 2.9]
class LinearVisibility {
public:
    /// @param maps  in the order of `along`, equal sizes and steps; one map alone is a plain shadow map
    LinearVisibility(std::vector<LinearMap> maps, const SkinRules& rules);

    /// V; outside of a sample's map that sample sees the point whole.
    /// @param local  how strongly each sample lights the point, any unit; empty: alike, and V is the share of the light
    ///               that is seen. Else it is the share of the light that arrives.
    [[nodiscard]] double at(const LinearPoint& point, const LinearLookup& lookup,
                            std::span<const double> local = {}) const;
    struct Total {
        double seen = 0.0, whole = 0.0;
    };
    /// V as what arrives and what would without casters.
    [[nodiscard]] Total total_at(const LinearPoint& point, const LinearLookup& lookup,
                                 std::span<const double> local = {}) const;
    /// Each segment's own, weights not yet applied.
    [[nodiscard]] double segment_at(std::size_t segment, const LinearPoint& point, const LinearLookup& lookup) const;

    [[nodiscard]] const std::vector<LinearMap>& maps() const noexcept { return maps_; }
    [[nodiscard]] const std::vector<double>& before(std::size_t map) const noexcept { return before_[map]; }
    [[nodiscard]] const std::vector<double>& after(std::size_t map) const noexcept { return after_[map]; }
    [[nodiscard]] std::size_t skin_count() const noexcept { return skins_; }

private:
    struct End {
        bool lit = false;
        double towards = 0.0, before = 0.5, after = 0.5;
    };
    struct Segment {
        double first = 0.0, second = 0.0;  ///< what either end says
        double facing = 1.0;               ///< share that does not lie behind the point's own plane
    };
    [[nodiscard]] Segment segment_ends(std::size_t segment, const LinearPoint& point, const LinearLookup& lookup) const;
    [[nodiscard]] End end_at(std::size_t map, const LinearPoint& point, const LinearLookup& lookup) const;

    std::vector<LinearMap> maps_;
    std::vector<std::vector<double>> before_, after_;
    std::size_t skins_ = 0;
};

}  // namespace penumbra
