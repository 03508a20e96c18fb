#pragma once

#include <cstdint>
#include <glm/glm.hpp>
#include <string>
#include <vector>

#include "passes/light_summary.h"

namespace penumbra {

/// One depth map's view. Light space "ls": origin at the light point (sun: at the receivers' centre), axes of the
/// map with z pointing away from the light; depth z_ls is linear, in metres.
struct MapFace {
    std::string name;               ///< "front", "+x", ... for the plan
    glm::dmat3 ls_from_world{1.0};  ///< rotation
    bool orthographic = false;
    glm::dvec2 low{-1.0}, high{1.0};     ///< extent: x_ls / z_ls and y_ls / z_ls, orthographic: metres
    double near_m = 0.0;                 ///< z_ls of the window depth 1 (reversed depth)
    double far_m = 0.0;                  ///< orthographic: z_ls of the window depth 0; perspective: infinite
    double farthest_m = 0.0;             ///< z_ls of the deepest receiver
    std::vector<std::uint32_t> casters;  ///< positions in LightSummary::casters that may fall into this face
    std::vector<std::uint32_t> beside;   ///< instances of LightSummary::near_hull that lookups may find
    bool for_nothing = false;            ///< no visible receiver lies in it; kept where everything is
};

/// All faces needed from one light point, and what was left out.
struct MapFrustum {
    glm::dvec3 origin_ws{0.0};
    std::vector<MapFace> faces;
    std::vector<std::string> faces_without_receivers;
};

struct MapFrustumOptions {
    int size_px = 1024;
    /// Kept free around the receivers: filter radius and bias offsets. So far beside them casters are drawn.
    double margin_texels = 2.0;
    /// Area lights: z along the light's normal and x along its first half axis, so that the light lies in the plane
    /// z_ls = 0 and its outline keeps its shape in the map. The fitted frustum is then off-centre.
    bool along_light_normal = false;
    /// Casters that are visible receivers stay, even if they lie behind all visible points (a floor can by rounding).
    bool keep_receivers = false;
};

/// Frusta that together contain every receiver of the summary, seen from `origin_ws` (a point of the light; for a
/// sun the direction counts instead). One fitted perspective frustum when the receivers lie within 55 degrees of an
/// axis, else the cube faces that contain receivers, each fitted to them; one orthographic one for a sun.
/// Near plane as far as casters and receivers allow: what is nearer is clamped to it and still casts.
///
/// @param direction_ws  sun: unit direction of travel; else the axis to prefer for the faces (Light::direction_ws)
[[nodiscard]] MapFrustum fit_map_frustum(const LightSummary& summary, const glm::dvec3& origin_ws,
                                         const glm::dvec3& direction_ws, const MapFrustumOptions& options);

/// Casters, near plane and far plane of a face whose axes and extent are set (MapFace::low, high, orthographic).
/// @param nearest_m, farthest_m  z_ls of the nearest and the deepest visible receiver in the face
/// @param keep_receivers  as in MapFrustumOptions
void fit_depth_and_casters(const LightSummary& summary, const glm::dvec3& origin_ws, double nearest_m,
                           double farthest_m, bool keep_receivers, MapFace& face);

/// Instances that may fall into the face, those beside the hull last.
[[nodiscard]] std::vector<std::uint32_t> casters_in(const LightSummary& summary, const MapFace& face);

}  // namespace penumbra
