#include "passes/receiver_texel.h"

#include <algorithm>
#include <cmath>
#include <cstdint>

#include "base/assert.h"
#include "base/parallel.h"
#include "gl/glsl_types.h"

namespace penumbra {
namespace {

constexpr std::int64_t kPixelsPerPiece = 16384;

/// Octahedral, 16 bits an axis; 0 is kept for "nothing is seen".
std::uint32_t pack_normal(const glm::vec3& n) noexcept {
    glm::vec2 o = glm::vec2{n} / (std::abs(n.x) + std::abs(n.y) + std::abs(n.z));
    if (n.z < 0.0F) {
        o = (1.0F - glm::abs(glm::vec2{o.y, o.x})) * glm::vec2{o.x >= 0.0F ? 1.0F : -1.0F, o.y >= 0.0F ? 1.0F : -1.0F};
    }
    const glm::uvec2 bits{65535.0F * glm::clamp(0.5F * o + 0.5F, 0.0F, 1.0F) + 0.5F};
    return std::max(bits.x | bits.y << 16U, 1U);
}

}  // namespace

glm::uvec4 receiver_texel(const glm::vec3& position_cr, const glm::vec3& normal_ws) noexcept {
    return {glm::floatBitsToUint(position_cr), pack_normal(normal_ws)};
}

void receiver_texels(const View& view, std::span<glm::uvec4> texels, Control& control) {
    PENUMBRA_ASSERT(texels.size() == view.size());
    parallel_for(
        static_cast<std::int64_t>(view.size()), kPixelsPerPiece,
        [&](std::int64_t begin, std::int64_t end) {
            glm::vec3 last{0.0F};  // neighbours mostly share the normal
            std::uint32_t packed = 0;
            for (auto i = static_cast<std::size_t>(begin); i < static_cast<std::size_t>(end); ++i) {
                if (!view.hit(i)) {
                    texels[i] = glm::uvec4{0U};
                    continue;
                }
                if (packed == 0 || view.normal_ws[i] != last) {
                    last = view.normal_ws[i];
                    packed = pack_normal(last);
                }
                texels[i] = {glm::floatBitsToUint(view.position_cr[i]), packed};
            }
        },
        control);
}

}  // namespace penumbra
