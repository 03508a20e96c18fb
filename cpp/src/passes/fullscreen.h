#pragma once

#include "gl/framebuffer.h"
#include "gl/handles.h"
#include "gl/program.h"

namespace penumbra {

/// Draws one triangle over the whole of a target, with no depth test and no blending but what the caller set.
class FullscreenPass {
public:
    void draw(RenderTarget& target, const Program& program);

private:
    VertexArray empty_;
};

}  // namespace penumbra
