#include "reference/shared_fit.h"

#include <algorithm>
#include <cmath>
#include <glm/glm.hpp>
#include <limits>

namespace penumbra {
namespace {

constexpr float kSameNormal = 0.99F;  // 8 degrees
constexpr float kOffPlane = 0.1F;     // of the distance between two pixels' points
constexpr float kFewest = 6.0F;       // pixels that a plane with three numbers is fitted to

bool same_surface(const View& view, std::size_t a, std::size_t b) noexcept {
    if (view.instance[a] != view.instance[b]) {
        return false;
    }
    if (view.triangle[a] == view.triangle[b]) {
        return true;
    }
    if (glm::dot(view.normal_ws[a], view.normal_ws[b]) < kSameNormal) {
        return false;
    }
    const glm::vec3 step = view.position_cr[b] - view.position_cr[a];
    const float off = glm::dot(step, view.normal_ws[a]);
    return off * off <= kOffPlane * kOffPlane * glm::dot(step, step);
}

}  // namespace

SharedFit fit_around(const View& view, std::span<const float> visibility, std::size_t pixel, int radius) noexcept {
    const auto width = static_cast<std::size_t>(view.width);
    const int x = static_cast<int>(pixel % width);
    const int y = static_cast<int>(pixel / width);
    float n = 0.0F;
    float sx = 0.0F;
    float sy = 0.0F;
    float sxx = 0.0F;
    float sxy = 0.0F;
    float syy = 0.0F;
    float sv = 0.0F;
    float sxv = 0.0F;
    float syv = 0.0F;
    float svv = 0.0F;
    for (int dy = std::max(-radius, -y); dy <= std::min(radius, view.height - 1 - y); ++dy) {
        for (int dx = std::max(-radius, -x); dx <= std::min(radius, view.width - 1 - x); ++dx) {
            const std::size_t i = static_cast<std::size_t>(y + dy) * width + static_cast<std::size_t>(x + dx);
            if (visibility[i] < 0.0F || !same_surface(view, pixel, i)) {
                continue;
            }
            const auto fx = static_cast<float>(dx);
            const auto fy = static_cast<float>(dy);
            n += 1.0F, sx += fx, sy += fy, sxx += fx * fx, sxy += fx * fy, syy += fy * fy;
            const float v = visibility[i];
            sv += v, sxv += fx * v, syv += fy * v, svv += v * v;
        }
    }
    // Cramer's rule on the normal equations.
    const float c0 = sxx * syy - sxy * sxy;
    const float c1 = sxy * sy - sx * syy;
    const float c2 = sx * sxy - sxx * sy;
    const float determinant = n * c0 + sx * c1 + sy * c2;
    if (n < kFewest || determinant < 1.0F) {  // sums of whole numbers: 0 if the pixels lie in a row
        return {visibility[pixel], 0.0F, std::numeric_limits<float>::infinity()};
    }
    const float at = (sv * c0 + sxv * c1 + syv * c2) / determinant;
    const float along_x = (sv * c1 + sxv * (n * syy - sy * sy) + syv * (sx * sy - n * sxy)) / determinant;
    const float along_y = (sv * c2 + sxv * (sx * sy - n * sxy) + syv * (n * sxx - sx * sx)) / determinant;
    const float squares = svv - at * sv - along_x * sxv - along_y * syv;
    return {std::clamp(at, 0.0F, 1.0F), std::hypot(along_x, along_y), std::sqrt(std::max(0.0F, squares) / (n - 3.0F))};
}

}  // namespace penumbra
