#include "reference/seen_triangles.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <numbers>

#include "base/assert.h"
#include "base/parallel.h"
#include "geometry/pixel_rays.h"

namespace penumbra {
namespace {

constexpr int kBlock = 4;  // pixels of a packet are a square: its rays stay close to each other
static_assert(kBlock * kBlock == kRayLanes);
constexpr int kRowsPerPiece = 2;  // of blocks

/// Camera rays in the space of a RayScene. They start where the scene may begin, so that a far camera costs no digits.
class CameraRays {
public:
    CameraRays(const Camera& camera, const AnchorFrame& frame)
        : rays_{camera},
          eye_an_{frame.point(glm::dvec3{camera.world_from_camera[3]})},
          per_unit_{1.0 / frame.unit_m},
          begin_an_{std::max(camera.near_m * per_unit_, nearest_an(camera))},
          length_{static_cast<float>(camera.far_m * per_unit_ - begin_an_)} {}
    void set(embree::RayPacket<kRayLanes>& packet, int lane, const glm::dvec3& row, int x) const noexcept {
        const PixelRays::Ray ray = rays_.at(row, x);
        const glm::vec3 from{eye_an_ + ray.origin * per_unit_ + begin_an_ * ray.along};
        const glm::vec3 along{ray.along};
        packet.org_x[lane] = from.x;
        packet.org_y[lane] = from.y;
        packet.org_z[lane] = from.z;
        packet.dir_x[lane] = along.x;
        packet.dir_y[lane] = along.y;
        packet.dir_z[lane] = along.z;
        packet.tfar[lane] = length_;
    }
    [[nodiscard]] glm::dvec3 row(int y) const noexcept { return rays_.row(y); }
    /// False: all that the rays could meet lies nearer than they begin or farther than they end.
    [[nodiscard]] bool any() const noexcept { return length_ > 0.0F; }

private:
    /// Depth before which nothing lies: coordinates of the geometry are within +-1.
    [[nodiscard]] double nearest_an(const Camera& camera) const noexcept {
        return glm::dot(eye_an_, glm::dvec3{camera.world_from_camera[2]}) - std::numbers::sqrt3;
    }

    PixelRays rays_;
    glm::dvec3 eye_an_;
    double per_unit_;
    double begin_an_;
    float length_;
};

}  // namespace

void find_seen(const RayScene& rays, const Camera& camera, std::span<glm::uvec2> seen, Control& control) {
    const int width = camera.width_px;
    const int height = camera.height_px;
    PENUMBRA_ASSERT(seen.size() == static_cast<std::size_t>(width) * static_cast<std::size_t>(height));
    const CameraRays through{camera, rays.frame()};
    if (rays.empty() || !through.any()) {
        std::ranges::fill(seen, glm::uvec2{0U});
        return;
    }
    const auto block_at = [&](int left, int bottom, const std::array<glm::dvec3, kBlock>& rows,
                              embree::RayHitPacket<kRayLanes>& packet) {
        alignas(64) std::array<int, kRayLanes> valid;
        for (int lane = 0; lane < kRayLanes; ++lane) {
            const int x = left + lane % kBlock;
            const int y = bottom + lane / kBlock;
            valid[lane] = x < width && y < height ? -1 : 0;
            through.set(packet.ray, lane, rows[lane / kBlock], x);
        }
        packet.hit.geometry.fill(embree::kNothing);
        packet.hit.instance.fill(embree::kNothing);
        rays.first_hit(valid.data(), packet);
        for (int lane = 0; lane < kRayLanes; ++lane) {
            if (valid[lane] != 0) {
                const std::uint32_t geometry = packet.hit.geometry[lane];
                const std::size_t pixel =
                    static_cast<std::size_t>(bottom + lane / kBlock) * width + left + lane % kBlock;
                seen[pixel] = geometry == embree::kNothing
                                  ? glm::uvec2{0U}
                                  : glm::uvec2{rays.instance_of(geometry, packet.hit.instance[lane]) + 1U,
                                               packet.hit.triangle[lane]};
            }
        }
    };
    parallel_for((height + kBlock - 1) / kBlock, kRowsPerPiece,
                 [&](std::int64_t begin, std::int64_t end) {
                     alignas(64) embree::RayHitPacket<kRayLanes> packet{};
                     packet.ray.mask.fill(~0U);
                     for (std::int64_t block = begin; block < end; ++block) {
                         control.check();
                         const int bottom = static_cast<int>(block) * kBlock;
                         std::array<glm::dvec3, kBlock> rows;
                         for (int y = 0; y < kBlock; ++y) {
                             rows[y] = through.row(bottom + y);
                         }
                         for (int left = 0; left < width; left += kBlock) {
                             block_at(left, bottom, rows, packet);
                         }
                     }
                 },
                 control);
}

}  // namespace penumbra
