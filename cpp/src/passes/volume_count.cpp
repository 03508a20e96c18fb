// Of VolumePass: draws the volumes and counts them, in the stencil or in an image.

#include <limits>

#include "passes/frame.h"
#include "passes/volume_light.h"
#include "passes/volume_pass.h"

namespace penumbra {

void VolumePass::aim_at(const TextureImage& depth_stencil) {
    if (!target_ || target_depth_ != depth_stencil.name()) {
        target_ = RenderTarget{"volume counts"};
        target_.attach_depth(depth_stencil);
        target_depth_ = depth_stencil.name();
        glTextureParameteri(depth_stencil.name(), GL_DEPTH_STENCIL_TEXTURE_MODE, GL_STENCIL_INDEX);
    }
    counted_ = &depth_stencil;
}

void VolumePass::set_uniforms(Frame& frame, const Program& program) {
    const glm::dvec3 eye_ws = frame.summary().eye_ws;
    const glm::dvec4 light_ws = homogeneous_centre(frame.light());
    const auto relative = frame.gpu_scene().relative_to(eye_ws);
    instances_.replace(std::span<const gpu::InstanceBlock>{relative});
    instances_.bind_storage(0);
    program.set("far_share", static_cast<float>(far_share(frame.summary(), light_ws)));
    program.set("clip_from_rel", glm::mat4{clip_from_rel(frame.scene().camera)});
    program.set("light_cr", glm::vec4{glm::vec3{glm::dvec3{light_ws} - light_ws.w * eye_ws}, light_ws.w});
}

void VolumePass::issue(const Group& group) {
    glFrontFace(group.clockwise ? GL_CW : GL_CCW);
    glMultiDrawElementsIndirect(GL_TRIANGLES, GL_UNSIGNED_INT, buffer_offset(group.first * sizeof(DrawCommand)),
                                static_cast<GLsizei>(group.count), 0);
}

void VolumePass::draw_under_conditions(const Program& program, std::span<const GLuint> conditions) const {
    for (const Group& group : groups_) {
        set_state(group, program);
        for (std::size_t c = group.first; c < group.first + group.count; ++c) {
            const GLuint query = conditions[slot_of_instance_.at(drawn_[c].base_instance)];
            Group one = group;
            one.first = c;
            one.count = 1;
            if (query != 0) {
                glBeginConditionalRender(query, GL_QUERY_NO_WAIT);
            }
            issue(one);
            if (query != 0) {
                glEndConditionalRender();
            }
        }
    }
}

void VolumePass::set_state(const Group& group, const Program& program) const {
    if (in_image_) {
        // Fragments that fail the z-fail test's comparison, or pass z-pass's.
        glDepthFunc(group.z_pass ? GL_GREATER : GL_LEQUAL);
        program.set("front_adds", group.z_pass ? 1 : -1);
        return;
    }
    glDepthFunc(GL_GREATER);
    glStencilOpSeparate(GL_FRONT, GL_KEEP, group.z_pass ? GL_KEEP : GL_DECR_WRAP,
                        group.z_pass ? GL_INCR_WRAP : GL_KEEP);
    glStencilOpSeparate(GL_BACK, GL_KEEP, group.z_pass ? GL_KEEP : GL_INCR_WRAP, group.z_pass ? GL_DECR_WRAP : GL_KEEP);
}

void VolumePass::count(Frame& frame, const VolumeMask& mask) {
    using Kind = VolumeMask::Kind;
    Defines defines;
    if (in_image_) {
        defines.push_back({"COUNT_IN_IMAGE"});
        counts_.clear(glm::ivec4{0});
        counts_.bind_image(0, GL_READ_WRITE);
    }
    if (mask.kind == Kind::Class) {
        defines.push_back({"MASK_BY_CLASS"});
        mask.classes->bind(1);
    }
    if (mask.tiles != nullptr) {
        sort_into_tiles(frame, mask);
    } else if (mask.tile_list != nullptr) {
        sift_by_tiles(frame, *mask.tile_list);
    }
    const Program& program = frame.device().programs.get({"passes/volume.vert", "passes/volume.frag"}, defines);
    set_uniforms(frame, program);
    if (mask.kind == Kind::Class) {
        program.set("wanted_class", mask.wanted);
    }
    aim_at(mask.kind == Kind::DepthBounds ? *mask.depth_stencil : frame.view_depth());
    target_.bind();
    program.use();
    const bool by_bit = mask.kind == Kind::Stencil;
    if (!by_bit && !in_image_) {
        const GLint zero = 0;
        glClearNamedFramebufferiv(target_.name(), GL_STENCIL, 0, &zero);
    }
    glClipControl(GL_LOWER_LEFT, GL_ZERO_TO_ONE);
    glEnable(GL_DEPTH_TEST);
    glDepthMask(GL_FALSE);
    glEnable(GL_DEPTH_CLAMP);
    glDisable(GL_CULL_FACE);
    glEnable(GL_SCISSOR_TEST);
    glScissor(scissor_.x, scissor_.y, scissor_.z, scissor_.w);
    const bool sifted = mask.tile_list != nullptr;
    glBindVertexArray((sifted ? kept_vertex_array_ : vertex_array_).name());
    glBindBuffer(GL_DRAW_INDIRECT_BUFFER, (sifted ? kept_commands_ : commands_).name());
    if (!in_image_ || by_bit) {
        glEnable(GL_STENCIL_TEST);
        glStencilFunc(by_bit ? GL_EQUAL : GL_ALWAYS, VolumeMask::kBit, VolumeMask::kBit);
        glStencilMask(in_image_ ? 0 : by_bit ? 0x7F : 0xFF);
    }
    if (mask.kind == Kind::DepthBounds) {
        glEnable(GL_DEPTH_BOUNDS_TEST_EXT);
        glDepthBoundsEXT(std::numeric_limits<float>::min(), 1.0);  // reversed depth: nothing seen is at 0
    }
    if (mask.tiles != nullptr) {
        draw_in_tiles(program);
    } else if (!mask.conditions.empty()) {
        draw_under_conditions(program, mask.conditions);
    } else {
        for (const Group& group : groups_) {
            set_state(group, program);
            issue(group);
        }
    }
    glBindVertexArray(0);
    if (mask.kind == Kind::DepthBounds) {
        glDisable(GL_DEPTH_BOUNDS_TEST_EXT);
    }
    glDisable(GL_STENCIL_TEST);
    glStencilMask(0xFF);
    glStencilOp(GL_KEEP, GL_KEEP, GL_KEEP);
    glStencilFunc(GL_ALWAYS, 0, 0xFF);
    glDisable(GL_SCISSOR_TEST);
    glDisable(GL_DEPTH_CLAMP);
    glDisable(GL_DEPTH_TEST);
    glDepthFunc(GL_GREATER);
    glDepthMask(GL_TRUE);
    glFrontFace(GL_CCW);
    if (in_image_) {
        glMemoryBarrier(GL_TEXTURE_FETCH_BARRIER_BIT);
    }
}

void VolumePass::bind_counts(GLuint unit) const {
    (in_image_ ? counts_ : *counted_).bind(unit);
}

std::vector<std::int32_t> VolumePass::read_counts() const {
    if (in_image_) {
        return counts_.read<std::int32_t>();
    }
    const auto width = static_cast<std::size_t>(counted_->width());
    std::vector<std::uint8_t> stencil(width * static_cast<std::size_t>(counted_->height()));
    glBindFramebuffer(GL_READ_FRAMEBUFFER, target_.name());
    glReadPixels(0, 0, counted_->width(), counted_->height(), GL_STENCIL_INDEX, GL_UNSIGNED_BYTE, stencil.data());
    return {stencil.begin(), stencil.end()};
}

void VolumePass::draw(Frame& frame, const Program& program) {
    set_uniforms(frame, program);
    program.use();
    glEnable(GL_DEPTH_CLAMP);
    glDisable(GL_CULL_FACE);
    glBindVertexArray(vertex_array_.name());
    glBindBuffer(GL_DRAW_INDIRECT_BUFFER, commands_.name());
    for (const Group& group : groups_) {
        issue(group);
    }
    glBindVertexArray(0);
    glDisable(GL_DEPTH_CLAMP);
    glFrontFace(GL_CCW);
}

std::vector<float> VolumePass::read_overdraw(Frame& frame) {
    const TextureImage fragments =
        TextureImage::make_2d(GL_R32F, frame.view().width, frame.view().height, "volume fragments");
    RenderTarget target{"volume fragments"};
    target.attach_colour(0, fragments);
    target.bind();
    target.clear_colour(0, glm::vec4{0.0F});
    glDisable(GL_DEPTH_TEST);
    glEnable(GL_BLEND);
    glBlendEquation(GL_FUNC_ADD);
    glBlendFunc(GL_ONE, GL_ONE);
    draw(frame, frame.device().programs.get({"passes/volume.vert", "passes/volume.frag"}, {{"COUNT_FRAGMENTS"}}));
    glDisable(GL_BLEND);
    return fragments.read<float>();
}

}  // namespace penumbra
