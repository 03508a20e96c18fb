#include "passes/frame.h"

#include "passes/asked_pixels.h"

namespace penumbra {

void Frame::bind_view() const {
    in_.view_pass.receiver(in_.view, in_.control).bind(0);
}

void Frame::resolve_with(const Program& program) {
    bind_view();
    write_visibility_with(program);
}

void Frame::write_visibility_with(const Program& program) {
    glDisable(GL_BLEND);
    AskedPixels{in_.summary}.draw(*this, in_.visibility_target, program);
}

std::vector<float>& Frame::visibility_on_cpu() {
    cpu_visibility_.resize(in_.view.size(), 1.0F);
    return cpu_visibility_;
}

}  // namespace penumbra
