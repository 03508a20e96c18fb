#pragma once

#include <array>
#include <glm/glm.hpp>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "geometry/linear_light.h"
#include "geometry/linear_rods.h"
#include "passes/gpu_blocks.h"
#include "passes/light_summary.h"
#include "passes/map_frustum.h"

namespace penumbra {

/// Four around a rod, each in three parts along it, as wide as the faces of a cube.
inline constexpr int kMostWindows = 12;

/// One rectified window: the same picture plane for all samples of a rod, parallel to it, so that a point moves between
/// their views along rows only, by base * d texel widths; d is 1 / z (sun: depth in front of the far plane).
struct LinearWindow {
    std::vector<MapFace> faces;           ///< one per sample; axes u, v, f, near and far are common
    std::vector<double> low_u;            ///< per sample, left edge in coordinates that the relation above holds for
    std::vector<glm::dvec2> receivers_u;  ///< per sample, in the same: what the receivers take, without room for skins
    glm::dvec2 step{0.0};                 ///< of a texel
    double nearest_m = 0.0;               ///< z_ls of the nearest caster or receiver
    std::vector<std::vector<std::uint32_t>> skin_casters;  ///< per sample: instances of the maps that skins come from
    [[nodiscard]] const MapFace& common() const noexcept { return faces.front(); }
};

/// All views of one rod. Light space "ls" of a window: origin at the rod's centre (sun: at the receivers'), x along the
/// rod.
struct LinearViews {
    glm::dvec3 origin_ws{0.0};
    glm::dvec3 u_ws{1.0, 0.0, 0.0};                       ///< unit, along the rod
    glm::dvec3 v_ws{0.0, 1.0, 0.0}, f_ws{0.0, 0.0, 1.0};  ///< of the first window
    bool orthographic = false;
    bool in_one_window = false;  ///< all receivers are inside of the first
    std::vector<double> along;   ///< per sample, ascending: metres from the centre along u; sun: minus the slope
    std::vector<LinearWindow> windows;
    std::vector<std::string> windows_without_receivers;
    /// Index of the window that looks along f, v, -f, -v; then of those further along u, then against u; -1: none.
    std::array<int, kMostWindows> window_towards = no_windows();
    std::vector<glm::vec3> outside_cr;  ///< receivers in no window: too close to the rod's own line

    [[nodiscard]] int samples() const noexcept { return static_cast<int>(along.size()); }
    [[nodiscard]] glm::dvec3 eye_ws(int sample) const {
        return orthographic ? origin_ws : origin_ws + along[static_cast<std::size_t>(sample)] * u_ws;
    }
    /// Windows that one block of a shader holds.
    struct Group {
        std::size_t first = 0, count = 0;
    };
    [[nodiscard]] std::vector<Group> groups() const;
    /// The windows as one sample sees them.
    [[nodiscard]] MapFrustum frustum_of(int sample, const Group& group) const;
    /// The windows from the middle of the rod: what lookups start from.
    [[nodiscard]] MapFrustum central(const Group& group) const;
    /// Texel of sample `i` minus texel of the central view: x * d + y.
    [[nodiscard]] glm::dvec2 shift_from_central(std::size_t window, int sample) const;
    /// Texel in `to` minus texel in `from`: x * d + y.
    [[nodiscard]] glm::dvec2 shift_between(std::size_t window, int from, int to) const;
    /// The window that a point belongs to (lib function find_window() of linear_windows.glsl).
    /// @param p_ws relative to origin_ws
    [[nodiscard]] std::optional<std::size_t> window_of(const glm::dvec3& p_ws) const;
    /// The point as a window's lookups see it.
    [[nodiscard]] LinearPoint point_in(std::size_t window, const glm::dvec3& p_ws, const glm::dvec3& n_ws) const;
    /// Factor from d to the stored depth.
    [[nodiscard]] double stored_per_d(std::size_t window) const;

private:
    [[nodiscard]] static constexpr std::array<int, kMostWindows> no_windows() noexcept {
        std::array<int, kMostWindows> none{};
        none.fill(-1);
        return none;
    }
};

/// Along the rod windows reach this far out, in depths: 75 degrees.
inline constexpr double kWidestAlong = 3.75;

/// The samples' maps of one window in float64. @param stored  all layers of the depth array
[[nodiscard]] std::vector<LinearMap> linear_maps(const LinearViews& views, std::size_t window,
                                                 std::span<const float> stored, int first_layer, int size_px);

/// `count` places from end to end of a rod, -1 .. 1; 0 alone for one.
[[nodiscard]] std::vector<double> even_places(int count);

/// Views that together contain every visible receiver, the casters between them and the rod, and room for the skins
/// that hang from those.
/// @param places  of the samples along the rod, ascending, -1 .. 1
/// @param aim_ws  the middle of the receivers, where the first window looks
[[nodiscard]] LinearViews fit_linear_views(const LightSummary& summary, const LinearRod& rod,
                                           const std::vector<double>& places, const glm::dvec3& aim_ws, int size_px);

}  // namespace penumbra
