#pragma once

#include <cstdint>
#include <vector>

#include "gl/framebuffer.h"
#include "gl/handles.h"

namespace penumbra {

class CentreMap;
class Frame;

/// Which casters lie in the shadow of others altogether, as the depth map has it [Chan2004, proposed there]: their
/// volumes lie within the others' and need not be drawn. Of each caster's box the rectangle that the light sees is
/// drawn against the map inside an occlusion query, a texel larger and at the depth of the box's nearest corner, pulled
/// towards the light; if no sample passes, nothing of the caster can be lit, but through gaps that the map does not
/// see.
class CasterCulling {
public:
    /// After the map's update(). Asks; nothing waits.
    void test(Frame& frame, CentreMap& map);
    /// Per caster of the summary: a query for conditional rendering, 0: draw it anyway.
    [[nodiscard]] const std::vector<GLuint>& conditions() const noexcept { return conditions_; }
    /// Waits for the device.
    [[nodiscard]] std::uint32_t culled() const;

private:
    std::vector<Query> queries_;
    std::vector<GLuint> conditions_;
    std::vector<RenderTarget> targets_;
    GLuint map_texture_ = 0;  ///< that targets_ have
    VertexArray no_attributes_;
};

}  // namespace penumbra
