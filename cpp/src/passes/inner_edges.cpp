#include "passes/inner_edges.h"

#include "passes/edge_space.h"
#include "passes/frame.h"

namespace penumbra {

namespace {

constexpr int kVerticesPerEdge = 15;  // inner_edges.vert

}  // namespace

void InnerEdges::allocate(int size_px, int layers) {
    if (texture_ && texture_.width() == size_px && texture_.layers() == layers) {
        return;
    }
    targets_.clear();
    texture_ = TextureImage::make_array(GL_RGBA32F, size_px, size_px, layers, "inner edges");
    depth_ = TextureImage::make_2d(GL_DEPTH_COMPONENT32F, size_px, size_px, "inner edges' distance");
    for (int layer = 0; layer < layers; ++layer) {
        targets_.emplace_back("inner edges");
        targets_.back().attach_colour(0, texture_, layer);
        targets_.back().attach_depth(depth_);
    }
}

void InnerEdges::draw(Frame& frame, SilhouettePass& silhouettes, CentreMap& map, const Reach& reach) {
    reach_ = reach;
    allocate(map.size_px(), static_cast<int>(map.frustum().faces.size()));
    const Program& program =
        frame.device().programs.get({"passes/inner_edges.vert", "passes/inner_edges.frag"}, map.defines());
    map.bind_space();
    map.texture().bind(2);
    silhouettes.bind(2);
    program.set("reach", glm::vec2{glm::dvec2{reach.fixed, reach.per_w}});
    glClipControl(GL_LOWER_LEFT, GL_ZERO_TO_ONE);
    glEnable(GL_DEPTH_TEST);
    glDepthMask(GL_TRUE);
    glDepthFunc(GL_LESS);
    glDisable(GL_BLEND);
    for (std::size_t i = 0; i < targets_.size(); ++i) {
        targets_[i].bind();
        targets_[i].clear_depth(1.0F);
        targets_[i].clear_colour(0, glm::vec4{0.0F, 0.0F, -1.0F, 0.0F});
        set_edge_space(program, static_cast<int>(i), edge_range(map.frustum().faces[i], reach.per_w),
                       reach.ip_from_unit);
        program.use();
        silhouettes.draw(frame, GL_TRIANGLES, kVerticesPerEdge);
    }
    glDisable(GL_DEPTH_TEST);
}

void InnerEdges::set_uniforms(const Program& program) const {
    const glm::dmat2 unit_from_ip = glm::inverse(reach_.ip_from_unit);
    const auto columns = [](const glm::dmat2& m) { return glm::vec4{m[0].x, m[0].y, m[1].x, m[1].y}; };
    program.set("unit_from_ip", columns(unit_from_ip));
    program.set("ip_from_unit", columns(reach_.ip_from_unit));
}

std::size_t InnerEdges::bytes() const noexcept {
    return (texture_ ? texture_.bytes() : 0) + (depth_ ? depth_.bytes() : 0);
}

}  // namespace penumbra
