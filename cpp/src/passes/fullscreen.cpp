#include "passes/fullscreen.h"

namespace penumbra {

void FullscreenPass::draw(RenderTarget& target, const Program& program) {
    if (!empty_) {
        empty_ = VertexArray::create();
    }
    target.bind();
    program.use();
    glDisable(GL_DEPTH_TEST);
    glDepthMask(GL_FALSE);
    glBindVertexArray(empty_.name());
    glDrawArrays(GL_TRIANGLES, 0, 3);
    glBindVertexArray(0);
}

}  // namespace penumbra
