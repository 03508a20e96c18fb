#pragma once

#include <cstdint>
#include <glm/glm.hpp>
#include <string_view>
#include <vector>

#include "penumbra/light.h"

namespace penumbra {

/// One point of a light that stands for an equal share of it.
struct LightSamplePoint {
    glm::dvec3 position_ws{0.0};   ///< sun: unused
    glm::dvec3 direction_ws{0.0};  ///< sun: direction of travel of this sample's rays, unit; else as the light
    glm::dvec3 normal_ws{0.0};     ///< sphere only: outward unit normal, for the solid-angle weight
};

/// Part of a sphere that some receiver may see: the cap around `axis_ws` down to the given cosine.
struct SphereCap {
    glm::dvec3 axis_ws{0.0, 0.0, 1.0};
    double least_cosine = -1.0;  ///< -1: the whole sphere
};

/// `count` points: area lights uniform by area, lines by length, suns over the disc of directions, spheres over
/// `cap`. Pattern "jittered" (stratified; the Hammersley set, scrambled, where count is no square), "grid"
/// (cell centres) or "r2" (additive recurrence). A light without extent has one point whatever the count.
/// Source: [HeckbertHerf1997]; error rates: baselines.md section 4.
[[nodiscard]] std::vector<LightSamplePoint> sample_points(const Light& light, int count, std::string_view pattern,
                                                          std::uint32_t seed, const SphereCap& cap = {});

/// Area-preserving map of the unit square onto the unit disc that keeps strata compact. [ShirleyChiu1997]
[[nodiscard]] glm::dvec2 concentric_disc(const glm::dvec2& u) noexcept;

}  // namespace penumbra
