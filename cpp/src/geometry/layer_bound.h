#pragma once

#include <algorithm>
#include <cstdint>
#include <glm/glm.hpp>
#include <span>
#include <vector>

#include "scene/bounds.h"

namespace penumbra {

/// How many triangles at most a ray from the light can cross: triangles are counted in the cells of a picture that the
/// light sees, each in every cell that it may touch, so that no ray crosses more than the fullest cell holds. One
/// window where the casters lie within a cone, else the six faces of a cube.
class LayerBound {
public:
    /// @param light_ws    the light point, w = 1; a sun: direction towards it, w = 0
    /// @param casters_ws  boxes of what will be added, or of those with many triangles: what lies outside of them is
    ///                    counted as if it all lay in one another
    LayerBound(const glm::dvec4& light_ws, std::span<const Bounds> casters_ws);

    /// @param convex  not 0: of all triangles added in a row with this number, no ray crosses more than one
    void add(const glm::dvec3& a_ws, const glm::dvec3& b_ws, const glm::dvec3& c_ws, std::uint32_t convex = 0);
    [[nodiscard]] std::uint32_t most() const noexcept { return std::max(most_, outside_) + everywhere_; }

    static constexpr int kCells = 512;  ///< of a window's side; a cube's faces have half

private:
    struct Face {
        glm::dmat3 axes{1.0};  ///< rows x, y, z
        glm::dvec2 low{-1.0}, cells_per_unit{1.0};
        std::size_t first = 0;
    };
    void add_to(const Face& face, std::span<const glm::dvec3> triangle_ls);
    void fill(const Face& face, std::span<const glm::dvec2> polygon);

    glm::dvec3 origin_ws_{0.0};
    bool parallel_ = false;
    bool cube_ = false;
    int cells_ = kCells;
    std::vector<Face> faces_;
    std::vector<std::uint32_t> counts_, last_;  ///< per cell; last_: the convex number that it was counted for
    std::uint32_t convex_ = 0;
    std::uint32_t most_ = 0;
    std::uint32_t outside_ = 0;     ///< reach beyond the window
    std::uint32_t everywhere_ = 0;  ///< reach behind the light, where no window is
};

}  // namespace penumbra
