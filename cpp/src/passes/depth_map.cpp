#include "passes/depth_map.h"

#include "passes/frame.h"

namespace penumbra {

gpu::MapBlock make_map_block(const MapFrustum& frustum, const Light& light, const glm::dvec3& light_direction_ws,
                             const glm::dvec3& eye_ws, int size_px) {
    gpu::MapBlock block{};
    block.origin_cr = glm::vec4{glm::vec3{frustum.origin_ws - eye_ws}, 0.0F};
    block.light_cr = light.kind == LightKind::Sun ? glm::vec4{glm::vec3{-light_direction_ws}, 0.0F}
                                                  : glm::vec4{glm::vec3{frustum.origin_ws - eye_ws}, 1.0F};
    block.counts = glm::ivec4{static_cast<int>(frustum.faces.size()), size_px, 0, 0};
    for (std::size_t i = 0; i < frustum.faces.size(); ++i) {
        const MapFace& face = frustum.faces[i];
        const glm::dmat3 axes = glm::transpose(face.ls_from_world);
        gpu::MapFaceBlock& out = block.faces[i];
        out.x_ls_from_rel = glm::vec4{glm::vec3{axes[0]}, 0.0F};
        out.y_ls_from_rel = glm::vec4{glm::vec3{axes[1]}, 0.0F};
        out.z_ls_from_rel = glm::vec4{glm::vec3{axes[2]}, 0.0F};
        out.low_high = glm::vec4{glm::vec2{face.low}, glm::vec2{face.high}};
        const glm::dvec2 step = (face.high - face.low) / static_cast<double>(size_px);
        out.texel_from_ls = glm::vec4{glm::vec2{1.0 / step}, glm::vec2{-face.low / step}};
        out.step_ls = glm::vec4{glm::vec2{step}, static_cast<float>(std::max(step.x, step.y)), 0.0F};
        out.range_m = glm::vec4{static_cast<float>(face.near_m), static_cast<float>(face.far_m),
                                face.orthographic ? 1.0F : 0.0F, 0.0F};
    }
    return block;
}

void DepthMap::allocate(int size_px, int layers, std::string_view what, MapLayers* shared) {
    if (texture() && texture().width() == size_px && texture().layers() == layers) {
        return;
    }
    targets_.clear();
    texture_ = TextureImage{};
    lease_ = MapLayers::Lease{};
    if (shared != nullptr) {
        lease_ = shared->take(GL_DEPTH_COMPONENT32F, size_px, layers, what);
    } else {
        texture_ = TextureImage::make_array(GL_DEPTH_COMPONENT32F, size_px, size_px, layers, what);
    }
    attach();
}

void DepthMap::attach() {
    targets_.clear();
    for (int layer = 0; layer < texture().layers(); ++layer) {
        targets_.emplace_back(texture().what());
        targets_.back().attach_depth(texture(), layer);
    }
    attached_ = lease_ ? lease_.generation() : 0;
}

void DepthMap::render(Frame& frame, GpuScene& gpu_scene, std::span<const std::uint32_t> instances, std::size_t face,
                      int layer, Cull cull, const DepthMap* peel) {
    if (lease_ && lease_.generation() != attached_) {
        attach();
    }
    RenderTarget& target = targets_[static_cast<std::size_t>(layer)];
    target.bind();
    glClipControl(GL_LOWER_LEFT, GL_ZERO_TO_ONE);
    glEnable(GL_DEPTH_TEST);
    glDepthMask(GL_TRUE);
    glDepthFunc(GL_GREATER);
    glEnable(GL_DEPTH_CLAMP);
    target.clear_depth(0.0F);
    const Program& program =
        peel != nullptr ? frame.device().programs.get({"passes/depth_map.vert", "passes/depth_map.frag"}, {{"PEEL"}})
                        : frame.device().programs.get({"passes/depth_map.vert", "passes/depth_map.frag"});
    program.set("face_index", static_cast<int>(face));
    if (peel != nullptr) {
        program.set("layer", layer);
        peel->texture().bind(0);
    }
    program.use();
    gpu_scene.draw(instances, cull);
    glDisable(GL_DEPTH_CLAMP);
}

void MapSetup::bind_for_depth(const GpuScene& gpu_scene, const MapFrustum& frustum, const gpu::MapBlock& block) {
    const auto relative = gpu_scene.relative_to(frustum.origin_ws);
    instances_.replace(std::span<const gpu::InstanceBlock>{relative});
    instances_.bind_storage(0);
    bind_for_lookup(block);
}

void MapSetup::bind_for_lookup(const gpu::MapBlock& block) {
    block_.replace(std::span<const gpu::MapBlock>{&block, 1});
    block_.bind_uniform(1);
}

}  // namespace penumbra
