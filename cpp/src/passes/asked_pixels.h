#pragma once

#include <cstdint>
#include <glm/glm.hpp>
#include <vector>

#include "gl/framebuffer.h"
#include "gl/program.h"
#include "penumbra/plan.h"

namespace penumbra {

class Frame;
struct LightSummary;

/// Where V is asked: rectangles of tiles of 16 x 16 pixels that hold a pixel of the mask (rule pixel-outside-mask).
class AskedPixels {
public:
    explicit AskedPixels(const LightSummary& summary);

    /// A full-screen pass that leaves all other tiles of the target as they are.
    void draw(const Frame& frame, RenderTarget& target, const Program& program) const;

    /// Tells of the tiles that are left out, if there are any.
    void tell(Plan& plan) const;

private:
    std::vector<glm::ivec4> rectangles_;  ///< low corner and size, in pixels; disjoint
    std::uint64_t pixels_outside_ = 0;
    bool whole_ = false;
};

}  // namespace penumbra
