// One plane's texture: the umbra, and the slopes around it.
#include <algorithm>
#include <cstddef>

#include "passes/frame.h"
#include "techniques/plateaus/plateaus.h"

namespace penumbra {

namespace {

constexpr double kNothingDarkest = 4095.0 * 4096.0 + 4095.0;  ///< lit, from the height 0 (slopes.frag)

}  // namespace

void Plateaus::draw_plane(Frame& frame, std::size_t plane, bool whole) {
    draw_umbra(frame, plane, whole);
    if (sifts_) {
        find_covered(frame, plane, whole);
    }
    sift(frame, plane, !sifts_, cuts_to_tiles_);
    draw_slopes(frame, plane);
}

void Plateaus::draw_umbra(Frame& frame, std::size_t plane, bool whole) {
    RenderTarget& target = umbra_targets_[plane];
    target.bind();
    const glm::ivec4 size = layout_.blocks[plane].size;
    glViewport(0, 0, size.x, size.y);
    glEnable(GL_SCISSOR_TEST);
    glScissor(0, 0, size.x, size.y);
    glDisable(GL_BLEND);
    glClipControl(GL_LOWER_LEFT, GL_ZERO_TO_ONE);
    glDisable(GL_DEPTH_TEST);
    glDepthMask(GL_FALSE);
    if (store_ == Store::Depth || skip_depth_) {
        glEnable(GL_DEPTH_TEST);
        glDepthMask(GL_TRUE);
        glDepthFunc(store_ == Store::Depth ? GL_LESS : GL_ALWAYS);
        if (wanted_ && !whole) {  // depth 0 already where no pixel looks, so that no slope is computed there
            glCopyImageSubData(wanted_.name(), GL_TEXTURE_2D_ARRAY, 0, 0, 0, static_cast<GLint>(plane),
                               skip_depth_.name(), GL_TEXTURE_2D, 0, 0, 0, 0, size.x, size.y, 1);
        } else {
            target.clear_depth(1.0F);
        }
    }
    if (store_ != Store::Depth) {
        target.clear_colour(0, glm::vec4{1.0F});
        if (both_sides_) {
            target.clear_colour(1, glm::vec4{1.0F});
        }
        glDepthMask(skips_umbra() ? GL_TRUE : GL_FALSE);  // else slopes are wanted under the umbra
    }
    const Program& program =
        frame.device().programs.get({"techniques/plateaus/umbra.vert", "techniques/plateaus/umbra.frag"},
                                    {{"GAUGE", "0"},
                                     {"FRAME", "0"},
                                     {"UMBRA_COPY", both_sides_ ? "1" : "0"},
                                     {"STORE_DEPTH", store_ == Store::Depth ? "1" : "0"}});
    program.set("plane_index", static_cast<int>(plane));
    if (store_ == Store::Depth) {
        program.set("hither_yon", hither_yon_);
    }
    instances_.bind_storage(0);
    bind_block();
    program.use();
    glEnable(GL_CLIP_DISTANCE0);
    glEnable(GL_CLIP_DISTANCE1);
    frame.gpu_scene().draw(casters_onto(frame.summary(), layout_, plane), Cull::None);
    glDisable(GL_CLIP_DISTANCE0);
    glDisable(GL_CLIP_DISTANCE1);
    glDisable(GL_SCISSOR_TEST);
}

void Plateaus::send_mail(Frame& frame) {
    const std::vector<std::uint32_t> nobody(mailboxes_.bytes() / sizeof(std::uint32_t), 0xffffffffU);
    mailboxes_.upload(std::span<const std::uint32_t>{nobody});
    const Program& program =
        frame.device().programs.get({"techniques/plateaus/mailbox.vert", "techniques/plateaus/umbra.frag"},
                                    {{"UMBRA_COPY", "0"}, {"STORE_DEPTH", "0"}});
    silhouettes_.bind(0);
    mailboxes_.bind_storage(3);
    first_box_.bind_storage(4);
    program.use();
    glEnable(GL_RASTERIZER_DISCARD);
    silhouettes_.draw(frame, GL_POINTS, 1);
    glDisable(GL_RASTERIZER_DISCARD);
    StorageBuffer::barrier();
}

bool Plateaus::draws_tight() const noexcept {
    // Around an outline a penumbra lies in the sheets of its edges and the sectors of its corners. Without corners, and
    // on the inner side, it takes all that the light's image sweeps.
    return sheets_ != Sheets::Envelope || (edges_ == EdgeChoice::Silhouettes && !both_sides_);
}

std::vector<Plateaus::Draw> Plateaus::draws() const {
    const int count = cells_ > 0 ? cells_ : 32;
    const auto part = [&](int number, int sheet, int first, int per_edge, int rows = 0) {
        return Draw{{{"PART", std::to_string(number)},
                     {"SHEET", std::to_string(sheet)},
                     {"FIRST_VERTEX", std::to_string(first)},
                     {"CELLS", std::to_string(count)},
                     {"CELLS_BY_RULE", cells_ > 0 ? "0" : "1"},
                     {"SEGMENTS", std::to_string(segments_)},
                     {"MAILBOX", number == 3 ? "1" : "0"},
                     {"PER_EDGE", std::to_string(per_edge)}},
                    per_edge,
                    rows};
    };
    if (sheets_ == Sheets::Envelope) {
        return {draws_tight() ? part(0, 0, 0, 15) : part(1, 0, 0, 6)};
    }
    const bool fans = fans_ || edges_ != EdgeChoice::Silhouettes;
    std::vector<Draw> all;
    if (sheets_ == Sheets::Bilinear) {
        all.push_back(part(0, 1, 0, fans ? 6 : 15));
    } else {
        all.push_back(part(2, 1, 0, 6 * count, count));
        if (!fans) {
            all.push_back(part(0, 1, 6, 9));
        }
    }
    if (fans) {
        all.push_back(part(3, 1, 0, 3 * segments_));
    }
    return all;
}

void Plateaus::draw_primitives(Frame& frame, std::size_t plane) {
    const std::vector<Draw> all = draws();
    silhouettes_.bind(0);
    bind_block();
    listed_.bind_storage(5);
    mailboxes_.bind_storage(3);
    first_box_.bind_storage(4);
    for (std::size_t i = 0; i < 2 * all.size(); ++i) {
        const Draw& draw = all[i % all.size()];
        const bool pieces = i >= all.size();
        if (pieces && (!cuts_to_tiles_ || wireframe_)) {
            break;
        }
        Defines compiled = defines(plane);
        compiled.insert(compiled.end(), draw.defines.begin(), draw.defines.end());
        compiled.push_back({"TILED", pieces ? "1" : "0"});
        if (wireframe_) {
            compiled.push_back({"HIDDEN", show_hidden_ ? "1" : "0"});
        }
        const Program& program = frame.device().programs.get(
            {"techniques/plateaus/slopes.vert",
             wireframe_ ? "techniques/plateaus/wireframe.frag" : "techniques/plateaus/slopes.frag"},
            compiled);
        program.set("plane_index", static_cast<int>(plane));
        program.set("first_entry", static_cast<unsigned>(pieces ? first_piece() : 0));
        if (store_ == Store::Depth && !wireframe_) {
            program.set("hither_yon", hither_yon_);
        }
        glBindVertexArray(no_attributes_.name());
        glBindBuffer(GL_DRAW_INDIRECT_BUFFER, draws_.name());
        const std::size_t command = plane * sizeof(gpu::PlaneDraws) + offsetof(gpu::PlaneDraws, draws) +
                                    ((pieces ? 3 : 0) + i % all.size()) * sizeof(gpu::PlateauDraw);
        for (GLenum k = 0; pieces && k < 4; ++k) {
            glEnable(GL_CLIP_DISTANCE0 + k);
        }
        for (int row = 0; row < std::max(1, draw.rows); ++row) {
            if (draw.rows > 0) {
                program.set("row", row);
            }
            program.use();
            glDrawArraysIndirect(GL_TRIANGLES, buffer_offset(command));
        }
        glBindVertexArray(0);
        for (GLenum k = 0; pieces && k < 4; ++k) {
            glDisable(GL_CLIP_DISTANCE0 + k);
        }
    }
}

void Plateaus::draw_slopes(Frame& frame, std::size_t plane) {
    RenderTarget& target = slope_targets_[plane];
    target.bind();
    const glm::ivec4 size = layout_.blocks[plane].size;
    glViewport(0, 0, size.x, size.y);
    if (store_ == Store::Depth) {
        glEnable(GL_DEPTH_TEST);
        glDepthMask(GL_TRUE);
        glDepthFunc(GL_LESS);
    } else {
        if (skip_depth_) {
            glEnable(GL_DEPTH_TEST);
            glDepthFunc(GL_LESS);
        } else {
            glDisable(GL_DEPTH_TEST);
        }
        glDepthMask(GL_FALSE);
        glEnable(GL_BLEND);
        glBlendEquation(GL_MIN);
        glBlendFunc(GL_ONE, GL_ONE);
    }
    if (darkest_) {
        glEnable(GL_SCISSOR_TEST);
        glScissor(0, 0, size.x, size.y);
        target.clear_colour(1, glm::vec4{static_cast<float>(kNothingDarkest)});
        glDisable(GL_SCISSOR_TEST);
    }
    if (both_sides_) {
        umbra_.bind(2);
    }
    glDisable(GL_CULL_FACE);
    draw_primitives(frame, plane);
    glDisable(GL_BLEND);
    glBlendEquation(GL_FUNC_ADD);
    glDisable(GL_DEPTH_TEST);
    glDepthMask(GL_FALSE);
}

}  // namespace penumbra
