#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "penumbra/control.h"
#include "penumbra/scene.h"
#include "penumbra/view.h"

namespace penumbra {

enum class ReferenceMethod {
    RayTraced,  ///< every light, to a standard error
    Exact,      ///< Rectangle and Polygon lights, float64 boundary intervals at every pixel; standard error 0
};

struct ReferenceOptions {
    ReferenceMethod method = ReferenceMethod::RayTraced;
    double standard_error = 0.002;  ///< per pixel, of V; > 0
    std::uint32_t seed = 1;
    int max_rays_per_pixel = 65536;
    bool keep_everything = false;  ///< true: every pixel of the image gets the full number of rays
};

/// The truth for one light. Arrays as in View. NaN never occurs; outside the mask V is 1 and the error 0.
struct Reference {
    std::string method;       ///< "ray traced" or "exact"
    std::vector<float> area;  ///< V: fraction of the light's area (sphere: solid angle, sun: disc)
    std::vector<float>
        irradiance;  ///< the same, weighted by cosine and distance; 1 where the unshadowed irradiance is 0
    std::vector<float> standard_error;  ///< of `area`, one standard deviation
    std::vector<float> irradiance_standard_error;
    std::vector<std::uint8_t> mask;  ///< 1 inside the comparison's mask
    std::uint64_t rays = 0;
    double mean_rays_per_pixel = 0.0;  ///< over the mask
    double time_ms = 0.0;
    bool reached = true;               ///< false: some pixel hit max_rays_per_pixel before the standard error
    std::uint64_t pixels_skipped = 0;  ///< outside the mask, not traced
};

/// Exact visibility and irradiance ratio of a polygonal light (Rectangle, Polygon) at points, in float64, by the
/// boundary-interval method. Shapes: positions and normals n; both results n.
/// @throws InvalidScene if the light is not polygonal.
struct ExactResult {
    std::vector<double> area;
    std::vector<double> irradiance;
};
[[nodiscard]] ExactResult exact_visibility(const Scene& scene, const Light& light,
                                           std::span<const glm::dvec3> positions_ws,
                                           std::span<const glm::dvec3> normals_ws, Control& control);

/// The exact reference of a polygonal light at every pixel of its mask. Points are put back onto their triangles in
/// float64 first: a float32 position lies off its surface by rounding, and its own triangle might block it.
/// @throws InvalidScene if the light is not polygonal
[[nodiscard]] Reference exact_reference(const Scene& scene, const View& view, const Light& light, Control& control);

}  // namespace penumbra
