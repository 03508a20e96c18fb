#include "techniques/linear_light_maps/skin_pass.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>

#include "passes/frame.h"

namespace penumbra {

namespace {

constexpr std::size_t kHeaderBytes = 4 * sizeof(std::uint32_t);
constexpr float kNever = 3e38F;

}  // namespace

void SkinPass::allocate(int size_px, int layers) {
    if (channels_ && size_px_ == size_px && channels_.layers() == layers) {
        return;
    }
    size_px_ = size_px;
    targets_.clear();
    channels_ = TextureImage::make_array(GL_RG16F, size_px, size_px, layers, "visibility channels");
    order_ = TextureImage::make_2d(GL_DEPTH_COMPONENT32F, size_px, size_px, "order of skins");
    for (int layer = 0; layer < layers; ++layer) {
        targets_.emplace_back("visibility channels");
        targets_.back().attach_colour(0, channels_, layer);
        targets_.back().attach_depth(order_);
    }
    search_ = RenderTarget{"depth discontinuities"};
    search_.set_size_without_attachment(size_px, size_px);
    // One jump in two texels is as dense as they get: the LoG changes sign between them.
    capacity_ = std::max(1, size_px * size_px / 2);
    for (StorageBuffer& buffer : spans_) {
        buffer = StorageBuffer{kHeaderBytes + sizeof(std::uint32_t) * static_cast<std::size_t>(capacity_), "skins"};
    }
    no_attributes_ = VertexArray::create();
}

double SkinPass::longest_skin_px(const LinearViews& views, std::size_t window) {
    double base = 0.0;
    for (std::size_t i = 1; i < views.along.size(); ++i) {
        base = std::max(base, views.along[i] - views.along[i - 1]);
    }
    const LinearWindow& w = views.windows[window];
    const double deepest = views.orthographic ? w.common().far_m - w.nearest_m : 1.0 / w.nearest_m;
    return base * deepest / w.step.x;
}

void SkinPass::clear(int first_layer, int count) {
    const float none = rules_.darkest ? 2.0F : 0.5F;
    for (int layer = first_layer; layer < first_layer + count; ++layer) {
        RenderTarget& target = targets_[static_cast<std::size_t>(layer)];
        target.bind();
        target.clear_colour(0, glm::vec4{none});
    }
}

void SkinPass::find(Frame& frame, const LinearViews& views, std::size_t window, int sample, int layer) {
    const std::array<std::uint32_t, 4> nothing{0, 1, 0, 0};  // vertices, instances, first, base
    for (std::size_t i = 0; i < 2; ++i) {
        spans_[i].upload(std::span<const std::uint32_t>{nothing});
        spans_[i].bind_storage(static_cast<GLuint>(6 + i));
    }
    const LinearWindow& w = views.windows[window];
    const auto least_jump = [&](int to) {
        if (to < 0 || to >= views.samples()) {
            return kNever;
        }
        const double base =
            std::abs(views.along[static_cast<std::size_t>(to)] - views.along[static_cast<std::size_t>(sample)]);
        const double least = rules_.least_skin_px * w.step.x / base * views.stored_per_d(window);
        return least < kNever ? static_cast<float>(least) : kNever;
    };
    const glm::vec2 jump{least_jump(sample + 1), least_jump(sample - 1)};
    const std::vector<double> weights = log_weights(rules_.kernel);
    const std::vector<float> weights32(weights.begin(), weights.end());
    const Program& program =
        frame.device().programs.get({"lib/fullscreen.vert", "techniques/linear_light_maps/find_spans.frag"},
                                    {{"LOG_RADIUS", std::to_string(radius_of(rules_.kernel))}});
    program.set("layer", layer);
    program.set("capacity", capacity_);
    program.set("least_jump", jump);
    program.set("least_log", jump * static_cast<float>(rules_.log_share * least_step_response(rules_.kernel)));
    program.set("dead_zone", static_cast<float>(rules_.dead_zone));
    program.set("log_kernel", std::span<const float>{weights32});
    glDisable(GL_BLEND);
    frame.fullscreen().draw(search_, program);
    StorageBuffer::barrier();
}

void SkinPass::draw_towards(Frame& frame, const LinearViews& views, std::size_t window, int from, int to,
                            int first_layer) {
    const bool next = to > from;
    const int window_layer = first_layer + static_cast<int>(window) * views.samples();
    const int layer = window_layer + to;
    RenderTarget& target = targets_[static_cast<std::size_t>(layer)];
    target.bind();
    if (rules_.darkest) {
        glDisable(GL_DEPTH_TEST);
        glEnable(GL_BLEND);
        glBlendEquation(GL_MIN);
        glBlendFunc(GL_ONE, GL_ONE);
    } else {
        glEnable(GL_DEPTH_TEST);
        glEnable(GL_DEPTH_CLAMP);
        glDepthMask(GL_TRUE);
        glDepthFunc(GL_GREATER);
        target.clear_depth(0.0F);
    }
    // The sample's other segment keeps what it has.
    glColorMask(next ? GL_TRUE : GL_FALSE, next ? GL_FALSE : GL_TRUE, GL_FALSE, GL_FALSE);
    const double per_d = views.stored_per_d(window);
    const glm::dvec2 shift = views.shift_between(window, from, to);
    const Program& program = frame.device().programs.get(
        {"techniques/linear_light_maps/skin.vert", "techniques/linear_light_maps/skin.frag"},
        {{"EXACT", rules_.exact ? "1" : "0"}, {"WALL_RULE", rules_.wall_rule ? "1" : "0"}});
    program.set("capacity", capacity_);
    program.set("from_layer", window_layer + from);
    program.set("to_layer", layer);
    program.set("caster_left", next);
    program.set("shift", glm::vec2{shift.x / per_d, shift.y});
    program.set("texels_per_depth", static_cast<float>(std::abs(shift.x) / per_d));
    const auto texel_depth = static_cast<float>(views.windows[window].step.x * per_d);
    program.set("slack", views.orthographic ? glm::vec2{0.0F, texel_depth}
                                            : glm::vec2{static_cast<float>(rules_.same_relative), 0.0F});
    program.use();
    const StorageBuffer& spans = spans_[next ? 0 : 1];
    spans.bind_storage(6);
    glBindVertexArray(no_attributes_.name());
    glBindBuffer(GL_DRAW_INDIRECT_BUFFER, spans.name());
    glDrawArraysIndirect(GL_TRIANGLES, buffer_offset(0));
    glBindVertexArray(0);
    glColorMask(GL_TRUE, GL_TRUE, GL_TRUE, GL_TRUE);
    glDisable(GL_BLEND);
    glBlendEquation(GL_FUNC_ADD);
    glDisable(GL_DEPTH_CLAMP);
}

void SkinPass::draw(Frame& frame, const LinearViews& views, const TextureImage& depths, int first_layer) {
    clear(first_layer, views.samples() * static_cast<int>(views.windows.size()));
    glDisable(GL_CULL_FACE);
    for (std::size_t window = 0; window < views.windows.size(); ++window) {
        for (int sample = 0; sample < views.samples(); ++sample) {
            depths.bind(2);
            find(frame, views, window, sample, first_layer + static_cast<int>(window) * views.samples() + sample);
            for (const int to : {sample + 1, sample - 1}) {
                if (to >= 0 && to < views.samples()) {
                    draw_towards(frame, views, window, sample, to, first_layer);
                }
            }
            if (counting_) {
                for (const StorageBuffer& spans : spans_) {
                    std::uint32_t vertices = 0;
                    glMemoryBarrier(GL_BUFFER_UPDATE_BARRIER_BIT);
                    glGetNamedBufferSubData(spans.name(), 0, sizeof(vertices), &vertices);
                    const std::size_t found = vertices / 6;
                    counts_.spans += std::min<std::size_t>(found, static_cast<std::size_t>(capacity_));
                    counts_.dropped += found - std::min<std::size_t>(found, static_cast<std::size_t>(capacity_));
                }
            }
        }
    }
}

std::size_t SkinPass::bytes() const noexcept {
    std::size_t bytes = spans_[0].bytes() + spans_[1].bytes();
    for (const TextureImage* texture : {&channels_, &order_}) {
        bytes += *texture ? texture->bytes() : 0;
    }
    return bytes;
}

}  // namespace penumbra
