#include "techniques/smoothies/smoothie_buffer.h"

#include <algorithm>
#include <array>

#include "passes/frame.h"
#include "techniques/smoothies/thesis_corners.h"

namespace penumbra {

namespace {

// TARGET of smoothie.frag
constexpr int kAlpha = 0, kAlphaAndDepth = 1, kDepth = 2;

bool orthographic(const MapFrustum& frustum) {
    return !frustum.faces.empty() && frustum.faces.front().orthographic;
}

/// Reversed depth of the farthest visible receiver in the face: no ramp is ever wider than there.
double farthest_receiver(const MapFace& face) {
    return face.orthographic ? 0.0 : (1.0 - 1e-5) * face.near_m / std::max(face.farthest_m, face.near_m);
}

/// Bound for every direction of view, metres (a sun: tangent).
double largest_half_width(const Light& light) {
    double largest = LightExtent::disc_of(light).largest();
    if (light.kind != LightKind::Point && light.kind != LightKind::Spot && light.kind != LightKind::Sun) {
        largest = std::max(largest, glm::length(light.half_u_ws) + glm::length(light.half_v_ws));
    }
    for (const glm::dvec3& corner : light.corners_ws) {
        largest = std::max(largest, glm::length(corner - light.position_ws));
    }
    return largest;
}

}  // namespace

double plain_width_ip(const MapFrustum& frustum, double t) noexcept {
    double widest = 0.0;
    for (const MapFace& face : frustum.faces) {
        if (!face.for_nothing) {  // or the width would tell whether anything was left out
            widest = std::max({widest, face.high.x - face.low.x, face.high.y - face.low.y});
        }
    }
    return 0.5 * t * widest;
}

void SmoothieBuffer::allocate(int size_px, int layers, bool with_depth) {
    const GLenum format = with_depth && options_.passes == SmoothieOptions::Passes::Merged ? GL_RG32F : GL_R32F;
    const bool own_depth = with_depth && options_.passes == SmoothieOptions::Passes::Separate;
    if (alpha_ && alpha_.width() == size_px && alpha_.layers() == layers && alpha_.format() == format &&
        static_cast<bool>(depth_) == own_depth) {
        return;
    }
    targets_.clear();
    depth_targets_.clear();
    depth_ = TextureImage{};
    alpha_ = TextureImage{};
    attached_ = 0;
    alpha_ = TextureImage::make_array(format, size_px, size_px, layers, "smoothie buffer");
    if (own_depth) {
        depth_ = TextureImage::make_array(GL_DEPTH_COMPONENT32F, size_px, size_px, layers, "smoothie depth");
    }
    for (int layer = 0; layer < layers; ++layer) {
        targets_.emplace_back("smoothie buffer");
        targets_.back().attach_colour(0, alpha_, layer);
        if (own_depth) {
            depth_targets_.emplace_back("smoothie depth");
            depth_targets_.back().attach_depth(depth_, layer);
        }
    }
}

Defines SmoothieBuffer::ramp_defines(Frame& frame, const CentreMap& map) const {
    const bool fixed = options_.width == SmoothieOptions::Width::Fixed;
    int shape = 0;
    if (options_.width == SmoothieOptions::Width::Light) {
        shape = static_cast<int>(LightExtent::of(frame.light(), glm::dmat3{1.0}).shape());
    }
    // A sun's map has no distance from the light: there Eq. 1 becomes a width per metre, for the plain t as well.
    const bool plain = fixed && !(orthographic(map.frustum()) && options_.remap);
    return {{"WIDTH_SHAPE", std::to_string(shape)},
            {"FIXED_WIDTH", plain ? "1" : "0"},
            {"REMAP", options_.remap ? "1" : "0"}};
}

Defines SmoothieBuffer::defines(Frame& frame, const CentreMap& map) const {
    Defines all = map.defines();
    const Defines ramp = ramp_defines(frame, map);
    all.insert(all.end(), ramp.begin(), ramp.end());
    const char* corners = options_.corners == SmoothieOptions::Corners::None ? "0" : thesis() ? "2" : "1";
    all.insert(all.end(), {{"RESIZE_PER_VERTEX", options_.resize_per_vertex ? "1" : "0"}, {"CORNERS", corners}});
    return all;
}

InnerEdges::Reach SmoothieBuffer::inner_reach(Frame& frame, const CentreMap& map) const {
    if (options_.width == SmoothieOptions::Width::Fixed) {
        return orthographic(map.frustum()) && options_.remap
                   ? InnerEdges::Reach{.fixed = 0.0, .per_w = options_.t, .ip_from_unit = glm::dmat2{1.0}}
                   : InnerEdges::Reach{.fixed = plain_width_ip(map.frustum(), options_.t),
                                       .per_w = 0.0,
                                       .ip_from_unit = glm::dmat2{1.0}};
    }
    const double half_m = options_.width == SmoothieOptions::Width::Light
                              ? largest_half_width(frame.light())
                              : LightExtent::disc_of(frame.light()).largest();
    return {.fixed = 0.0, .per_w = half_m, .ip_from_unit = glm::dmat2{1.0}};
}

void SmoothieBuffer::set_light(const Program& program, Frame& frame, const CentreMap& map) const {
    const Light& light = frame.light();
    glm::dvec3 u_ws = light.half_u_ws;
    if (options_.width == SmoothieOptions::Width::Fixed) {
        const InnerEdges::Reach reach = inner_reach(frame, map);
        u_ws = glm::dvec3{reach.fixed + reach.per_w};
    } else if (options_.width == SmoothieOptions::Width::Disc ||
               LightExtent::of(light, glm::dmat3{1.0}).shape() == LightExtent::Shape::Disc) {
        u_ws = glm::dvec3{LightExtent::disc_of(light).largest()};
    }
    program.set("light_u_ws", glm::vec4{glm::vec3{u_ws}, 0.0F});
    if (program.has("light_v_ws")) {
        program.set("light_v_ws", glm::vec4{glm::vec3{light.half_v_ws}, 0.0F});
    }
    if (program.has("light_corners_ws")) {
        std::vector<glm::vec4> corners;
        corners.reserve(light.corners_ws.size());
        for (const glm::dvec3& corner : light.corners_ws) {
            corners.emplace_back(glm::vec3{corner - light.position_ws}, 0.0F);
        }
        program.set("corner_count", static_cast<int>(corners.size()));
        program.set("light_corners_ws", std::span<const glm::vec4>{corners});
    }
}

const Program& SmoothieBuffer::program(Frame& frame, CentreMap& map, int target) const {
    Defines all = defines(frame, map);
    all.push_back({"TARGET", std::to_string(target)});
    return frame.device().programs.get({"techniques/smoothies/smoothie.vert", "techniques/smoothies/smoothie.geom",
                                        "techniques/smoothies/smoothie.frag"},
                                       all);
}

void SmoothieBuffer::set_uniforms(const Program& program, Frame& frame, CentreMap& map, int index) const {
    const MapFrustum& frustum = map.frustum();
    const MapFace& face = frustum.faces[static_cast<std::size_t>(index)];
    // From metres of light to the image plane, per unit of reversed depth.
    const double per_u = face.orthographic ? face.far_m - face.near_m : 1.0 / face.near_m;
    glm::vec4 axes{0.0F};
    double largest = 0.0;
    if (options_.width == SmoothieOptions::Width::Fixed) {
        largest = face.orthographic && options_.remap ? options_.t * per_u : plain_width_ip(frustum, options_.t);
        axes.x = static_cast<float>(largest);
    } else {
        const LightExtent extent = options_.width == SmoothieOptions::Width::Light
                                       ? LightExtent::of(frame.light(), face.ls_from_world)
                                       : LightExtent::disc_of(frame.light());
        largest = per_u * extent.largest();
        axes = glm::vec4{per_u * glm::dvec4{extent.u(), extent.v()}};
        if (extent.shape() == LightExtent::Shape::Polygon) {
            std::vector<glm::vec4> corners;
            for (const glm::dvec2& corner : extent.corners()) {
                corners.emplace_back(glm::vec2{per_u * corner}, 0.0F, 0.0F);
            }
            program.set("corner_count", static_cast<int>(corners.size()));
            program.set("corners", std::span<const glm::vec4>{corners});
        }
    }
    program.set("axes", axes);
    program.set("largest_axis", static_cast<float>(largest));
    program.set("face_index", index);
    program.set("u_far", options_.depth_from_casters ? 0.0F : static_cast<float>(farthest_receiver(face)));
}

void SmoothieBuffer::draw(Frame& frame, SilhouettePass& silhouettes, CentreMap& map) {
    map.bind_space();
    silhouettes.bind(2);
    const TextureImage& receivers = options_.depth_from_casters ? map.texture() : map.receiver_texture();
    receivers.bind(4);
    for (std::size_t i = 0; i < targets_.size() && receivers.name() != attached_; ++i) {
        targets_[i].attach_depth(receivers, static_cast<int>(i));
    }
    attached_ = receivers.name();
    if (thesis()) {
        const auto tips = thesis_tips(frame, silhouettes.read());
        tips_.replace(std::span<const glm::vec4>{tips});
        tips_.bind_storage(3);
    }
    const bool merged = alpha_.format() == GL_RG32F;
    glClipControl(GL_LOWER_LEFT, GL_ZERO_TO_ONE);
    for (std::size_t i = 0; i < depth_targets_.size(); ++i) {
        const Program& nearest = program(frame, map, kDepth);
        set_uniforms(nearest, frame, map, static_cast<int>(i));
        depth_targets_[i].bind();
        glEnable(GL_DEPTH_TEST);
        glDepthMask(GL_TRUE);
        glDepthFunc(GL_GREATER);
        glEnable(GL_DEPTH_CLAMP);
        depth_targets_[i].clear_depth(0.0F);
        nearest.use();
        silhouettes.draw(frame, GL_POINTS, 1);
        glDisable(GL_DEPTH_CLAMP);
    }
    // Drops what lies behind the receivers, or too far out for them. Nothing is written, so reading them is no
    // feedback.
    glEnable(GL_DEPTH_TEST);
    glDepthMask(GL_FALSE);
    glDepthFunc(GL_GREATER);
    glEnable(GL_DEPTH_CLAMP);
    const Program& smallest = program(frame, map, merged ? kAlphaAndDepth : kAlpha);
    for (std::size_t i = 0; i < targets_.size(); ++i) {
        set_uniforms(smallest, frame, map, static_cast<int>(i));
        targets_[i].bind();
        targets_[i].clear_colour(0, glm::vec4{1.0F, 0.0F, 0.0F, 0.0F});
        glEnable(GL_BLEND);
        glBlendEquation(GL_MIN);
        smallest.use();
        silhouettes.draw(frame, GL_POINTS, 1);
        glBlendEquation(GL_FUNC_ADD);
        glDisable(GL_BLEND);
    }
    glDisable(GL_DEPTH_CLAMP);
    glDisable(GL_DEPTH_TEST);
}

void SmoothieBuffer::draw_outlines(Frame& frame, RenderTarget& target, SilhouettePass& silhouettes, CentreMap& map,
                                   int face) {
    const Defines all = defines(frame, map);
    const Program& flat = frame.device().programs.get(
        {"techniques/smoothies/smoothie.vert", "techniques/smoothies/smoothie.geom", "passes/debug_flat.frag"}, all);
    set_uniforms(flat, frame, map, face);
    flat.set("colour", glm::vec3{1.0F, 0.8F, 0.1F});
    silhouettes.bind(2);
    (options_.depth_from_casters ? map.texture() : map.receiver_texture()).bind(4);
    if (thesis()) {
        tips_.bind_storage(3);
    }
    target.bind();
    flat.use();
    glPolygonMode(GL_FRONT_AND_BACK, GL_LINE);
    silhouettes.draw(frame, GL_POINTS, 1);
    glPolygonMode(GL_FRONT_AND_BACK, GL_FILL);
}

std::size_t SmoothieBuffer::bytes() const noexcept {
    return (alpha_ ? alpha_.bytes() : 0) + (depth_ ? depth_.bytes() : 0) + tips_.bytes();
}

}  // namespace penumbra
