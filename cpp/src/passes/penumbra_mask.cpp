#include "passes/penumbra_mask.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <limits>
#include <numeric>
#include <utility>

#include "base/parallel.h"
#include "geometry/region_silhouettes.h"
#include "passes/asked_pixels.h"
#include "passes/debug_picture.h"
#include "passes/frame.h"

namespace penumbra {

namespace {

constexpr std::string_view kStep = "penumbra mask";
constexpr double kWidestTangent = 6.0;  // of an area light's one face: 80 degrees
constexpr double kWidestGuard = 0.35;   // kept free around the receivers at most, of the map's width
constexpr double kNearShare = 1e-6;     // of the deepest receiver: nearer to the light is touching it
constexpr double kClearOfSphere = 3.0;  // radii: a caster nearer than that may be seen past the map's faces
constexpr float kLitTexels = 0.02F;
constexpr float kUmbraTexels = 1.5F;
constexpr int kVerticesPerEdge = 6;

bool is_sphere(const Light& light) {
    return light.kind == LightKind::Point || light.kind == LightKind::Spot;
}

/// Rows are the map's axes: z where the light shines (a line: across it, towards the receivers), x along it.
glm::dmat3 axes_along(const LightRegion& region, const glm::dvec3& direction_ws, const glm::dvec3& towards_ws,
                      LightKind kind) {
    glm::dvec3 x = region.half[0];
    if (!(glm::length(x) > 0.0)) {
        x = region.half[1];
    }
    x = glm::normalize(x);
    glm::dvec3 z = direction_ws;
    if (kind == LightKind::Line) {
        z = towards_ws - glm::dot(towards_ws, x) * x;
        if (!(glm::length(z) > 1e-6 * glm::length(towards_ws))) {
            z = glm::cross(x, std::abs(x.z) < 0.9 ? glm::dvec3{0, 0, 1} : glm::dvec3{0, 1, 0});
        }
        z = glm::normalize(z);
    } else {
        x = glm::normalize(x - glm::dot(x, z) * z);
    }
    return glm::transpose(glm::dmat3{x, glm::cross(z, x), z});
}

/// One wide face, so that a flat light lies in its plane z_ls = 0. Receivers at its rim are outside, and Maybe.
MapFrustum fit_flat(const LightSummary& summary, const LightRegion& region) {
    MapFrustum frustum;
    frustum.origin_ws = glm::dvec3{region.centre};
    MapFace face;
    face.name = "front";
    const Light& light = *summary.light;
    const glm::dvec3 towards = summary.receivers_ws.centre() - frustum.origin_ws;
    face.ls_from_world = axes_along(region, light.direction_ws, towards, light.kind);
    const glm::dvec3 eye_from_origin = summary.eye_ws - frustum.origin_ws;
    glm::dvec2 low{kWidestTangent};
    glm::dvec2 high{-kWidestTangent};
    double farthest = 0.0;
    for (const ReceiverTile& tile : summary.tiles) {
        for (unsigned i = 0; i < 8; ++i) {
            const glm::dvec3 corner_cr{(i & 1U) != 0 ? tile.high_cr.x : tile.low_cr.x,
                                       (i & 2U) != 0 ? tile.high_cr.y : tile.low_cr.y,
                                       (i & 4U) != 0 ? tile.high_cr.z : tile.low_cr.z};
            const glm::dvec3 p = face.ls_from_world * (corner_cr + eye_from_origin);
            if (p.z > 0.0) {
                const glm::dvec2 at =
                    glm::clamp(glm::dvec2{p} / p.z, glm::dvec2{-kWidestTangent}, glm::dvec2{kWidestTangent});
                low = glm::min(low, at);
                high = glm::max(high, at);
                farthest = std::max(farthest, p.z);
            }
        }
    }
    if (!(farthest > 0.0)) {
        return frustum;
    }
    face.low = low;
    face.high = high;
    face.farthest_m = farthest;
    for (std::uint32_t i = 0; i < summary.casters.size(); ++i) {
        face.casters.push_back(i);
    }
    frustum.faces.push_back(std::move(face));
    return frustum;
}

/// Room around the receivers for the windows of those at the rim, as far as that is not too dear.
void widen(MapFace& face, const LightSummary& summary, const LightRegion& region, int size_px,
           const glm::dvec3& origin_ws) {
    double nearest = face.farthest_m;
    for (const Bounds& bounds : summary.caster_bounds_ws) {
        for (unsigned i = 0; i < 8; ++i) {
            const glm::dvec3 corner_ws{(i & 1U) != 0 ? bounds.high.x : bounds.low.x,
                                       (i & 2U) != 0 ? bounds.high.y : bounds.low.y,
                                       (i & 4U) != 0 ? bounds.high.z : bounds.low.z};
            nearest = std::min(nearest, (face.ls_from_world * (corner_ws - origin_ws)).z);
        }
    }
    const glm::dmat3 world_axes = glm::transpose(face.ls_from_world);
    const glm::dvec2 reach{region.reach(world_axes[0]), region.reach(world_axes[1])};
    const glm::dvec2 widest = kWidestGuard * (face.high - face.low);
    glm::dvec2 guard = widest;
    if (face.orthographic) {
        guard = glm::min(guard, reach * (face.farthest_m - nearest));
    } else if (nearest > 0.0) {
        guard = glm::min(guard, reach * (1.0 / nearest - 1.0 / face.farthest_m));
    }
    guard = glm::max(guard, glm::dvec2{0.0});
    const glm::dvec2 texels = 2.0 * (face.high - face.low + 2.0 * guard) / static_cast<double>(size_px);
    const glm::dvec2 least{1e-4 * std::max({glm::length(face.low), glm::length(face.high), 1e-12})};
    guard = glm::max(guard + texels, least);
    face.low -= guard;
    face.high += guard;
    if (!face.orthographic) {
        face.near_m = kNearShare * face.farthest_m;
    } else {
        const double span = std::max({face.farthest_m - nearest, face.high.x - face.low.x, face.high.y - face.low.y});
        face.near_m = std::min(face.near_m, nearest - 1e-3 * span);
        face.far_m = face.farthest_m + 1e-3 * span;
    }
}

/// Whether a triangle comes into the box or ball around the light; may say yes too often, never no too often.
bool meets(const LightRegion& light, const glm::dvec3& a, const glm::dvec3& b, const glm::dvec3& c, double slack) {
    const glm::dvec3 centre{light.centre};
    const auto apart_along = [&](const glm::dvec3& axis) {
        const double length = glm::length(axis);
        if (!(length > 0.0)) {
            return false;
        }
        const double reach = light.reach(axis) + slack * length;
        const glm::dvec3 at{glm::dot(axis, a - centre), glm::dot(axis, b - centre), glm::dot(axis, c - centre)};
        return std::min({at.x, at.y, at.z}) > reach || std::max({at.x, at.y, at.z}) < -reach;
    };
    if (apart_along(glm::cross(b - a, c - a)) || apart_along(glm::cross(light.half[0], light.half[1]))) {
        return false;
    }
    for (int i = 0; i < 3; ++i) {
        glm::dvec3 axis{0.0};
        axis[i] = 1.0;
        if (apart_along(axis) || apart_along(light.half[static_cast<std::size_t>(i)])) {
            return false;
        }
    }
    for (const glm::dvec3& edge : {b - a, c - b, a - c}) {
        for (const glm::dvec3& half : light.half) {
            if (apart_along(glm::cross(edge, half))) {
                return false;
            }
        }
        // Spheres: from the middle towards the edge.
        const glm::dvec3 from = glm::cross(glm::cross(edge, centre - a), edge);
        if (apart_along(from)) {
            return false;
        }
    }
    return true;
}

/// Values above 0 from dark to bright.
DebugImage faces_picture(const TextureImage& texture, std::string caption) {
    if (!texture) {
        return {1, 1, {glm::vec3{0.0F}}, "nothing is drawn: every pixel is undecided"};
    }
    float least = std::numeric_limits<float>::infinity();
    float most = 0.0F;
    for (const float value : texture.read<float>()) {
        if (value > 0.0F) {
            least = std::min(least, value);
            most = std::max(most, value);
        }
    }
    least = std::min(least, most);
    return texture_picture(texture, 0, least - 0.25F * (most - least) - 1e-9F * most - 1e-30F, most,
                           std::move(caption));
}

bool overlap(const Bounds& bounds, const glm::dvec3& centre, const glm::dvec3& reach) {
    return glm::all(glm::lessThanEqual(bounds.low, centre + reach)) &&
           glm::all(glm::greaterThanEqual(bounds.high, centre - reach));
}

}  // namespace

PenumbraMask::PenumbraMask(const Options& options) : options_{options} {
    options_.size_px = static_cast<int>(std::bit_ceil(static_cast<unsigned>(options.size_px)));
}

std::vector<SettingInfo> PenumbraMask::settings() {
    return {{.id = "mask_size",
             .label = "Mask's map size",
             .unit = "px",
             .help = "Width of the maps that the penumbra mask is made from; rounded up to a power of two.",
             .default_value = 512,
             .minimum = 16,
             .maximum = 8192,
             .choices = {},
             .sweep = {}},
            {.id = "mask_margin",
             .label = "Mask's margin",
             .unit = "texel",
             .help = "Half the width of an edge in the mask's map: more makes fewer pixels sure.",
             .default_value = 1.0,
             .minimum = 0.0,
             .maximum = 16.0,
             .choices = {},
             .sweep = {}},
            {.id = "mask_test",
             .label = "Mask's test",
             .unit = "",
             .help = "Sure where no possible silhouette lies in the window of the light; or by its depths alone, which "
                     "misses gaps.",
             .default_value = std::string{"edges"},
             .minimum = 0,
             .maximum = 0,
             .choices = {"edges", "depth"},
             .sweep = {}}};
}

PenumbraMask::Options PenumbraMask::options_from(const Settings& settings) {
    return {.size_px = get_int(settings, "mask_size"),
            .margin_texels = get_double(settings, "mask_margin"),
            .test = get_choice(settings, "mask_test") == "depth" ? Test::Depth : Test::Edges};
}

bool PenumbraMask::plan(const LightSummary& summary, Plan& plan, std::string_view step) {
    const LightSummary::Trivial trivial = summary.trivial();
    if (!trivial.reason.empty()) {
        plan.leave_out(std::string{step}, trivial.rule, trivial.reason);
        return false;
    }
    if (!summary.has_extent && !summary.keeps("mask-without-penumbra")) {
        plan.leave_out(std::string{step}, "mask-without-penumbra",
                       "the light has no extent, so no pixel lies in a penumbra");
        return false;
    }
    plan.run(std::string{step});
    return true;
}

void PenumbraMask::fit(const LightSummary& summary) {
    const Light& light = *summary.light;
    region_ = light_region(light);
    if (is_sphere(light) || light.kind == LightKind::Sun) {
        frustum_ = fit_map_frustum(summary, light.position_ws, light.direction_ws,
                                   {.size_px = options_.size_px, .margin_texels = 0.0});
    } else {
        frustum_ = fit_flat(summary, region_);
    }
    faces_.clear();
    for (MapFace& face : frustum_.faces) {
        MaskFace mask_face;
        mask_face.low = face.low;
        mask_face.high = face.high;
        const glm::dmat3 axes_ws = glm::transpose(face.ls_from_world);
        mask_face.per_w = {region_.reach(axes_ws[0]), region_.reach(axes_ws[1])};
        if (!face.orthographic) {
            // Pixels nearer than twice the light's own depth are not classified, so 1 - d_z w_r is at least 1/2.
            const double depth = region_.reach(axes_ws[2]);
            mask_face.per_w += depth * glm::max(glm::abs(face.low), glm::abs(face.high));
            mask_face.per_w *= depth > 0.0 ? 2.0 : 1.0;
            mask_face.nearest_m = is_sphere(light) ? 0.5 * light.radius_m : kNearShare * face.farthest_m;
        }
        widen(face, summary, region_, options_.size_px, frustum_.origin_ws);
        // The face is wider than it was when its casters were chosen.
        face.casters.resize(summary.casters.size());
        std::iota(face.casters.begin(), face.casters.end(), 0U);
        mask_face.face = face;
        faces_.push_back(std::move(mask_face));
    }
}

void PenumbraMask::prepare(Frame& frame) {
    if (!frame.plan().runs(kStep)) {
        return;
    }
    static_cast<void>(frame.adjacency());
    if (!no_attributes_) {
        no_attributes_ = VertexArray::create();
    }
    const View& view = frame.view();
    if (!classes_ || classes_.width() != view.width || classes_.height() != view.height) {
        classes_target_ = RenderTarget{"penumbra mask"};
        classes_ = TextureImage::make_2d(GL_R8, view.width, view.height, "penumbra mask");
        classes_target_.attach_colour(0, classes_);
    }
}

Defines PenumbraMask::defines() const {
    return {{"MAP_FACES", std::to_string(frustum_.faces.size())},
            {"MAP_ORTHOGRAPHIC", frustum_.faces.front().orthographic ? "1" : "0"}};
}

void PenumbraMask::update(Frame& frame) {
    frame.step(kStep, [&] {
        const LightSummary& summary = frame.summary();
        fit(summary);
        undecided_ = frustum_.faces.empty() ? "no receiver lies in front of the light" : std::string_view{};
        if (frustum_.faces.empty()) {
            return;
        }
        const int layers = static_cast<int>(frustum_.faces.size());
        map_.allocate(options_.size_px, layers, "penumbra mask's depth map");
        block_ = make_map_block(frustum_, frame.light(), frame.light().direction_ws, summary.eye_ws, options_.size_px);
        find_edges(frame);
        if (!undecided_.empty()) {
            return;
        }
        setup_.bind_for_depth(frame.gpu_scene(), frustum_, block_);
        for (int layer = 0; layer < layers; ++layer) {
            const auto face = static_cast<std::size_t>(layer);
            map_.render(frame, frame.gpu_scene(), casters_in(summary, frustum_.faces[face]), face, layer, Cull::None);
        }
        if (options_.test == Test::Depth) {
            pyramid_.update(frame, map_.texture());
            return;
        }
        draw_edges(frame);
        make_pyramid(frame);
    });
}

void PenumbraMask::find_edges(Frame& frame) {
    const LightSummary& summary = frame.summary();
    const GpuScene& gpu_scene = frame.gpu_scene();
    const GpuAdjacency& adjacency = frame.adjacency();
    const bool sphere = is_sphere(frame.light());
    const bool sun = frame.light().kind == LightKind::Sun;
    const double radius = region_.radius();
    const glm::dvec3 centre{region_.centre};
    const glm::dvec3 reach{region_.reach({1, 0, 0}), region_.reach({0, 1, 0}), region_.reach({0, 0, 1})};
    const double slack = 1e-3 * radius;
    edges_.assign(frustum_.faces.size(), {});
    std::vector<std::uint32_t> found;
    for (std::size_t k = 0; k < summary.casters.size(); ++k) {
        const std::uint32_t i = summary.casters[k];
        frame.control().check();
        const Instance& instance = frame.scene().instances[i];
        const Mesh& mesh = *instance.mesh;
        const Adjacency& edges = adjacency.of_mesh(gpu_scene.mesh_of_instance(i));
        const glm::dmat4& world_from_local = instance.world_from_local;
        const glm::dmat3 turn{world_from_local};
        const glm::dvec3 shift = glm::dvec3{world_from_local[3]};
        const glm::dvec3 from_origin = shift - frustum_.origin_ws;

        const Bounds& bounds = summary.caster_bounds_ws[k];
        if (!sun && overlap(bounds, centre, reach + slack)) {
            for (const glm::uvec3& t : mesh.triangles) {
                const auto corner = [&](std::uint32_t v) { return turn * glm::dvec3{mesh.positions_local[v]} + shift; };
                if (meets(region_, corner(t.x), corner(t.y), corner(t.z), slack)) {
                    undecided_ = "a caster meets the light";
                    return;
                }
            }
        }

        // Relative to the instance first: the inverse's own translation would lose digits far from the origin.
        const glm::dmat3 local_from_turned = glm::inverse(turn);
        LightRegion local = region_;
        const glm::dvec3 relative = centre - region_.centre.w * shift;
        local.centre = glm::dvec4{local_from_turned * relative, region_.centre.w};
        for (glm::dvec3& half : local.half) {
            half = local_from_turned * half;
        }
        found.clear();
        find_region_silhouettes(mesh, edges, local, found);
        for (std::size_t f = 0; f < frustum_.faces.size(); ++f) {
            const MapFace& face = frustum_.faces[f];
            const glm::dmat3 ls_from_local = face.ls_from_world * turn;
            const glm::dvec3 shift_ls = face.ls_from_world * from_origin;
            for (const std::uint32_t e : found) {
                const glm::dvec3 a = ls_from_local * glm::dvec3{mesh.positions_local[edges.edges[e].v0]} + shift_ls;
                const glm::dvec3 b = ls_from_local * glm::dvec3{mesh.positions_local[edges.edges[e].v1]} + shift_ls;
                const bool whole = add_mask_edge(faces_[f], options_.size_px, a, b, edges_[f]);
                if (!whole && !sphere && passes_close(faces_[f], a, b)) {
                    undecided_ = "a caster lies closer to the light than its maps reach";
                    return;
                }
                if (!whole && sphere) {
                    // Beside or behind the sphere's centre: harmless unless it is close to it.
                    const glm::dvec3 along = b - a;
                    const double length2 = glm::dot(along, along);
                    const double t = length2 > 0.0 ? std::clamp(-glm::dot(a, along) / length2, 0.0, 1.0) : 0.0;
                    if (glm::length(a + t * along) < kClearOfSphere * radius) {
                        undecided_ = "a caster stands close beside the light";
                        return;
                    }
                }
            }
        }
    }
}

void PenumbraMask::draw_edges(Frame& frame) {
    const int layers = static_cast<int>(frustum_.faces.size());
    const int size = options_.size_px;
    if (!nearest_edge_ || nearest_edge_.width() != size || nearest_edge_.layers() != layers) {
        const int level_count = 1 + static_cast<int>(std::floor(std::log2(size)));
        levels_.clear();
        nearest_edge_ = TextureImage::make_array(GL_R32F, size, size, layers, "penumbra mask's edges", level_count);
        levels_.resize(frustum_.faces.size());
        for (int layer = 0; layer < layers; ++layer) {
            for (int level = 0; level < level_count; ++level) {
                RenderTarget& target = levels_[static_cast<std::size_t>(layer)].emplace_back("penumbra mask's edges");
                target.attach_colour(0, nearest_edge_, layer, level);
            }
        }
    }
    const Program& program =
        frame.device().programs.get({"passes/mask_edges.vert", "passes/mask_edges.frag"}, defines());
    setup_.bind_for_lookup(block_);
    map_.texture().bind(2);
    program.set("size_px", static_cast<float>(size));
    program.set("half_width", static_cast<float>(options_.margin_texels));
    glDisable(GL_DEPTH_TEST);
    glDisable(GL_CULL_FACE);
    glEnable(GL_BLEND);
    glBlendEquation(GL_MAX);
    glBlendFunc(GL_ONE, GL_ONE);
    for (std::size_t f = 0; f < edges_.size(); ++f) {
        RenderTarget& target = levels_[f].front();
        target.bind();
        target.clear_colour(0, glm::vec4{0.0F});
        if (edges_[f].empty()) {
            continue;
        }
        edge_buffer_.replace(std::span<const gpu::MaskEdge>{edges_[f]});
        edge_buffer_.bind_storage(2);
        program.set("face_index", static_cast<int>(f));
        program.use();
        glBindVertexArray(no_attributes_.name());
        glDrawArrays(GL_TRIANGLES, 0, static_cast<GLsizei>(kVerticesPerEdge * edges_[f].size()));
        glBindVertexArray(0);
    }
    glBlendEquation(GL_FUNC_ADD);
    glDisable(GL_BLEND);
}

void PenumbraMask::make_pyramid(Frame& frame) {
    const Program& program = frame.device().programs.get({"lib/fullscreen.vert", "passes/mask_pyramid.frag"});
    const GLuint texture = nearest_edge_.name();
    nearest_edge_.bind(2);
    for (int level = 1; level < nearest_edge_.levels(); ++level) {
        // Only the level below is open to reading while this one is written.
        glTextureParameteri(texture, GL_TEXTURE_BASE_LEVEL, level - 1);
        glTextureParameteri(texture, GL_TEXTURE_MAX_LEVEL, level - 1);
        for (std::size_t f = 0; f < levels_.size(); ++f) {
            program.set("layer", static_cast<int>(f));
            frame.fullscreen().draw(levels_[f][static_cast<std::size_t>(level)], program);
        }
    }
    glTextureParameteri(texture, GL_TEXTURE_BASE_LEVEL, 0);
    glTextureParameteri(texture, GL_TEXTURE_MAX_LEVEL, nearest_edge_.levels() - 1);
}

void PenumbraMask::classify(Frame& frame) {
    frame.step(kStep, [&] {
        if (!undecided_.empty()) {
            classes_target_.bind();
            classes_target_.clear_colour(0, glm::vec4{0.0F});
            return;
        }
        Defines all = defines();
        const bool by_depth = options_.test == Test::Depth;
        all.push_back({"ROUND", region_.round ? "1" : "0"});
        all.push_back({"TEST_DEPTH", by_depth ? "1" : "0"});
        const Program& program = frame.device().programs.get({"lib/fullscreen.vert", "passes/mask_classify.frag"}, all);
        setup_.bind_for_lookup(block_);
        map_.texture().bind(2);
        (by_depth ? pyramid_.texture() : nearest_edge_).bind(3);
        std::array<glm::vec3, 3> half{};
        std::ranges::transform(region_.half, half.begin(), [](const glm::dvec3& h) { return glm::vec3{h}; });
        program.set("half_ws", std::span<const glm::vec3>{half});
        if (!by_depth) {
            program.set("top_level", nearest_edge_.levels() - 1);
        }
        program.set("lit_texels", kLitTexels);
        program.set("umbra_texels", kUmbraTexels);
        frame.bind_view();
        glDisable(GL_BLEND);
        classes_target_.bind();
        classes_target_.clear_colour(0, glm::vec4{static_cast<float>(Class::Lit) / 255.0F});
        AskedPixels{frame.summary()}.draw(frame, classes_target_, program);
    });
}

void PenumbraMask::write_stencil(Frame& frame, RenderTarget& target) const {
    const Program& program = frame.device().programs.get({"lib/fullscreen.vert", "passes/mask_stencil.frag"});
    target.bind();
    glStencilMask(0xFFU);
    target.clear_depth_stencil(0.0F, 0);
    glEnable(GL_STENCIL_TEST);
    glStencilFunc(GL_ALWAYS, 1, 0xFFU);
    glStencilOp(GL_KEEP, GL_KEEP, GL_REPLACE);
    glColorMask(GL_FALSE, GL_FALSE, GL_FALSE, GL_FALSE);
    classes_.bind(0);
    frame.fullscreen().draw(target, program);
    glColorMask(GL_TRUE, GL_TRUE, GL_TRUE, GL_TRUE);
    glStencilOp(GL_KEEP, GL_KEEP, GL_KEEP);
    glDisable(GL_STENCIL_TEST);
}

std::size_t PenumbraMask::bytes() const noexcept {
    return map_.bytes() + pyramid_.bytes() + (nearest_edge_ ? nearest_edge_.bytes() : 0) +
           (classes_ ? classes_.bytes() : 0) + edge_buffer_.bytes();
}

std::vector<Statistic> PenumbraMask::statistics(const LightSummary& summary, std::span<const std::uint8_t> classes) {
    std::array<std::uint64_t, 3> count{};
    for (std::size_t i = 0; i < classes.size(); ++i) {
        if (summary.mask[i] != 0 && classes[i] < count.size()) {
            ++count[classes[i]];
        }
    }
    const double all = std::max<double>(1.0, static_cast<double>(summary.lit_pixels));
    const auto share = [&](Class c) { return static_cast<double>(count[static_cast<std::size_t>(c)]) / all; };
    return {{"mask_lit", "Surely lit", "share of the mask", share(Class::Lit)},
            {"mask_umbra", "Surely in umbra", "share of the mask", share(Class::Umbra)},
            {"mask_maybe", "Maybe in a penumbra", "share of the mask", share(Class::Maybe)}};
}

std::vector<DebugView> PenumbraMask::debug_views() {
    return {{"mask", "Classes of the penumbra mask"},
            {"mask_map", "Nearest casters, as the mask's map holds them"},
            {"mask_edges", "Nearest edges that may be silhouettes"}};
}

DebugImage PenumbraMask::debug_image(Frame& frame, std::string_view id) {
    if (id == "mask_map") {
        return faces_picture(map_.texture(), "nearest casters, nearest brightest, one square per face");
    }
    if (id == "mask_edges") {
        return faces_picture(nearest_edge_,
                             "nearest edges that may be silhouettes from a point of the light, nearest "
                             "brightest, one square per face");
    }
    std::vector<std::uint8_t> classes(frame.view().size());
    read_classes(classes);
    DebugImage image;
    image.width_px = frame.view().width;
    image.height_px = frame.view().height;
    image.caption = "white: surely lit, black: surely in umbra, orange: maybe in a penumbra; grey: not asked";
    image.rgb.reserve(classes.size());
    for (std::size_t i = 0; i < classes.size(); ++i) {
        const auto found = static_cast<Class>(classes[i]);
        image.rgb.push_back(frame.summary().mask[i] == 0 ? glm::vec3{0.35F}
                            : found == Class::Lit        ? glm::vec3{1.0F}
                            : found == Class::Umbra      ? glm::vec3{0.0F}
                                                         : glm::vec3{0.95F, 0.55F, 0.1F});
    }
    return image;
}

}  // namespace penumbra
