#include "techniques/plateaus/plateaus.h"

#include <algorithm>

#include "passes/frame.h"

namespace penumbra {

namespace {

constexpr const char* kLookup = "techniques/plateaus/lookup.frag";
constexpr const char* kNoPlane = "every visible receiver lies on a plane with a texture of its own";

}  // namespace

Verdict Plateaus::supports(const Light& /*light*/) const {
    return {};
}

bool Plateaus::slopes_off_planes(const Layout& layout) const noexcept {
    return layout.map && !layout.hard && soft_off_planes_ && store_ != Store::Depth && !layout.blocks.empty();
}

bool Plateaus::skips_umbra() const noexcept {
    return store_ != Store::Depth && !both_sides_ && !slopes_off_planes(layout_);
}

bool Plateaus::skips_unseen(const LightSummary& summary, const Layout& layout) const noexcept {
    // A texture of whole objects is for baking, and where depth is the store there is no second depth to skip by.
    return !summary.keeps("texel-without-pixel") && !slopes_off_planes(layout) && !finding_.whole &&
           store_ != Store::Depth;
}

FieldOfUse Plateaus::field_of_use() const {
    return {.needs_small_light = !both_sides_,
            .needs_round_light = true,
            .needs_clear_light = true,
            .needs_light_above_horizon = map_.facing_test()};
}

Plan Plateaus::plan(const LightSummary& summary) const {
    Plan plan;
    const LightSummary::Trivial trivial = summary.trivial();
    if (!trivial.reason.empty()) {
        plan.leave_out("plateaus", trivial.rule, trivial.reason);
        plan.leave_out("lookup", trivial.rule, trivial.reason);
        return plan;
    }
    const Layout layout = lay_out(summary);
    if (layout.map) {
        Plan map;
        map_.plan(summary, "lookup", map);
        map.steps.pop_back();  // the lookup itself, which comes last
        plan = map;
    } else {
        plan.leave_out("depth map", "every-receiver-on-a-plane", kNoPlane);
        if (summary.casters_outside > 0) {
            plan.leave_out("casters out of reach", "caster-outside-hull",
                           std::to_string(summary.casters_outside) +
                               " casters lie outside the space between the light and the visible receivers");
        }
    }
    const std::string rule = summary.has_extent ? "penumbra-under-half-a-texel" : "light-without-extent";
    if (layout.hard && !summary.keeps(rule)) {
        const std::string reason = summary.has_extent
                                       ? "no penumbra is wider than half a texel"
                                       : "all points of the light coincide, so every penumbra has the width 0";
        plan.leave_out("silhouettes", rule, reason);
        plan.leave_out("plateaus", rule, reason);
    } else if (!layout.blocks.empty()) {
        const std::size_t draws = summary.casters.size() * layout.blocks.size();
        std::size_t drawn = 0;
        for (std::size_t p = 0; p < layout.blocks.size(); ++p) {
            drawn += casters_onto(summary, layout, p).size();
        }
        if (drawn < draws) {
            plan.leave_out("casters beside the planes", "caster-outside-face",
                           std::to_string(draws - drawn) + " of " + std::to_string(draws) +
                               " draws of a caster onto a plane would touch no texel of its texture");
        }
        plan.run("silhouettes");
        for (std::size_t p = 0; p < layout.blocks.size(); ++p) {
            plan.run(step_of(layout, p));
        }
        if (sifts(summary, layout)) {
            plan.leave_out("hidden silhouettes", "silhouette-under-umbra",
                           "found on the device for each plane: all of an edge's sheet and cone lies under the umbra, "
                           "or where no pixel looks");
        }
        if (cuts_to_tiles(summary, layout)) {
            plan.leave_out("tiles of wide slopes", "slope-never-darkest",
                           "found on the device by bounds of each slope over each tile of " +
                               std::to_string(PENUMBRA_PLATEAU_TILE) + " texels");
        }
        if (skips_unseen(summary, layout)) {
            plan.leave_out("unseen texels", "texel-without-pixel", "no pixel of the view looks them up");
        }
    }
    plan.run("lookup");
    return plan;
}

Defines Plateaus::defines(std::size_t plane) const {
    return {{"GAUGE", std::to_string(static_cast<int>(light_.gauge))},
            {"FRAME", std::to_string(static_cast<int>(layout_.frames[plane]))},
            {"SIDES", both_sides_ ? "2" : "1"},
            {"HEIGHTS", slopes_off_planes(layout_) ? "1" : "0"},
            {"STORE_DEPTH", store_ == Store::Depth ? "1" : "0"}};
}

const Program& Plateaus::lookup(Frame& frame) const {
    Defines all = layout_.map ? map_.defines() : Defines{};
    all.insert(all.end(), {{"REST", layout_.map ? "1" : "0"},
                           {"HARD", layout_.hard ? "1" : "0"},
                           {"NARROW", narrow_ ? "1" : "0"},
                           {"FALLOFF", std::to_string(falloff_)},
                           {"GAUGE", "0"},
                           {"FRAME", "0"},
                           {"SIDES", both_sides_ ? "2" : "1"},
                           {"HEIGHTS", slopes_off_planes(layout_) ? "1" : "0"},
                           {"STORE_DEPTH", store_ == Store::Depth ? "1" : "0"}});
    return frame.device().programs.get({"lib/fullscreen.vert", kLookup}, all);
}

void Plateaus::prepare(Frame& frame) {
    if (!frame.plan().runs("lookup")) {
        return;
    }
    layout_ = lay_out(frame.summary());
    light_ = plateau_light(frame.light(), shape_);
    if (layout_.map) {
        map_.allocate(frame);
    }
    const View& view = frame.view();
    plane_of_pixel_ = TextureImage::make_2d(GL_R8UI, view.width, view.height, "plane of each pixel");
    plane_of_pixel_.upload(std::span<const std::uint8_t>{layout_.receivers.plane_of_pixel});
    gpu::PlateauBlock block{};
    block.origin_cr = glm::vec4{glm::vec3{layout_.origin_ws - frame.summary().eye_ws}, 0.0F};
    block.counts.x = static_cast<int>(layout_.blocks.size());
    std::ranges::copy(layout_.blocks, block.planes);
    block_.replace(std::span<const gpu::PlateauBlock>{&block, 1});
    static_cast<void>(lookup(frame));
    if (!frame.plan().runs("silhouettes")) {
        return;
    }

    const int layers = static_cast<int>(layout_.blocks.size());
    const int width = layout_.width_px;
    const int height = layout_.height_px;
    const GLenum format = store_ == Store::Depth ? GL_DEPTH_COMPONENT16 : (store_ == Store::Byte ? GL_R8 : GL_R32F);
    slopes_ = TextureImage::make_array(format, width, height, layers, "plateaus");
    umbra_ = both_sides_ ? TextureImage::make_array(GL_R8, width, height, layers, "umbrae") : TextureImage{};
    darkest_ = slopes_off_planes(layout_)
                   ? TextureImage::make_array(GL_R32F, width, height, layers, "heights of the darkest casters")
                   : TextureImage{};
    sifts_ = sifts(frame.summary(), layout_);
    cuts_to_tiles_ = cuts_to_tiles(frame.summary(), layout_);
    const bool skips = skips_unseen(frame.summary(), layout_);
    wanted_ = skips ? TextureImage::make_array(GL_DEPTH_COMPONENT16, width, height, layers, "texels looked up")
                    : TextureImage{};
    if (skips) {
        wanted_.upload(std::span<const std::uint16_t>{texels_looked_up(view)});
    }
    skip_depth_ = skips || skips_umbra()
                      ? TextureImage::make_2d(GL_DEPTH_COMPONENT16, width, height, "texels without slopes")
                      : TextureImage{};
    const glm::ivec2 blocks = (glm::ivec2{width, height} + 63) / 64;
    covered_ = sifts_ ? TextureImage::make_2d(GL_RGBA8, 16 * blocks.x, 16 * blocks.y, "covered cells", kLevels)
                      : TextureImage{};
    no_attributes_ = VertexArray::create();
    umbra_targets_.clear();
    slope_targets_.clear();
    for (int layer = 0; layer < layers; ++layer) {
        RenderTarget& umbra = umbra_targets_.emplace_back("plateau's umbra");
        RenderTarget& slopes = slope_targets_.emplace_back("plateau");
        for (RenderTarget* target : {&umbra, &slopes}) {
            if (store_ == Store::Depth) {
                target->attach_depth(slopes_, layer);
            } else {
                target->attach_colour(0, slopes_, layer);
            }
            if (skip_depth_) {
                target->attach_depth(skip_depth_);
            }
        }
        if (both_sides_) {
            umbra.attach_colour(1, umbra_, layer);
        }
        if (darkest_) {
            slopes.attach_colour(1, darkest_, layer);
        }
    }
    draws_ = StorageBuffer(static_cast<std::size_t>(layers) * sizeof(gpu::PlaneDraws), "draws of planes");
    silhouettes_.prepare(frame, frame.gpu_scene(), frame.adjacency(), frame.summary().casters);
    const GpuScene& scene = frame.gpu_scene();
    std::vector<std::uint32_t> first_box(std::max<std::size_t>(1, scene.instance_count()), 0);
    std::size_t boxes = 0;
    for (const std::uint32_t i : frame.summary().casters) {
        first_box[i] = static_cast<std::uint32_t>(boxes);
        boxes += scene.meshes()[scene.mesh_of_instance(i)]->positions_local.size();
    }
    const bool mail = edges_ != EdgeChoice::Silhouettes || fans_;
    mailboxes_ = StorageBuffer(mail && sheets_ != Sheets::Envelope ? boxes * sizeof(std::uint32_t) : 0, "mailboxes");
    first_box_ = StorageBuffer::from(first_box, "mailboxes of instances");
}

void Plateaus::bind_block() {
    block_.bind_uniform(2);
}

void Plateaus::update(Frame& frame) {
    if (!frame.plan().runs("lookup")) {
        return;
    }
    if (layout_.map) {
        map_.update(frame);
    }
    frame.step("silhouettes", [&] {
        const Light& light = frame.light();
        silhouettes_.extract(
            frame,
            light.kind == LightKind::Sun ? glm::dvec4{-light.direction_ws, 0.0} : glm::dvec4{light.position_ws, 1.0},
            layout_.origin_ws);
        if (mailboxes_.bytes() > sizeof(std::uint32_t)) {
            send_mail(frame);
        }
        // Whole records, pieces, and the wide records that pieces are cut from.
        const std::uint64_t all = first_piece();
        const std::size_t bytes = (cuts_to_tiles_ ? first_wide() + all : all) * sizeof(glm::uvec2);
        if (listed_.bytes() < bytes) {
            listed_ = StorageBuffer(bytes, "silhouettes of a plane");
        }
    });
    if (!frame.plan().runs("silhouettes")) {
        return;
    }
    const auto placed = frame.gpu_scene().relative_to(layout_.origin_ws);
    instances_.replace(std::span<const gpu::InstanceBlock>{placed});
    for (std::size_t p = 0; p < layout_.blocks.size(); ++p) {
        frame.step(step_of(layout_, p), [&] { draw_plane(frame, p, false); });
    }
    drawn_whole_ = !wanted_;
}

void Plateaus::resolve(Frame& frame) {
    frame.step("lookup", [&] {
        const Program& program = lookup(frame);
        if (layout_.map) {
            map_.bind(program);
        }
        program.set("dark", static_cast<float>(dark_));
        program.set("hither_yon", hither_yon_);
        bind_block();
        plane_of_pixel_.bind(4);
        if (slopes_) {
            slopes_.bind(5);
        }
        if (darkest_) {
            darkest_.bind(6);
        }
        frame.resolve_with(program);
    });
}

std::vector<Statistic> Plateaus::statistics(Frame& frame) {
    if (!frame.plan().runs("silhouettes")) {
        return {};
    }
    double all = 0.0;
    double hidden = 0.0;
    double pieces = 0.0;
    for (const gpu::PlaneDraws& plane : draws_.read<gpu::PlaneDraws>()) {
        all += plane.in_window;
        hidden += plane.hidden;
        pieces += std::min<double>(plane.tiles, static_cast<double>(kMostPieces));
    }
    return {{"silhouettes", "Silhouettes whose slopes meet a plane's window", "edges, plane by plane", all},
            {"hidden_silhouettes", "Of these left out, for they change nothing", "edges, plane by plane", hidden},
            {"slope_pieces", "Pieces that wide slopes were cut to", "tiles, edge by edge", pieces}};
}

std::size_t Plateaus::memory_bytes() const noexcept {
    std::size_t bytes = map_.bytes() + silhouettes_.bytes() + mailboxes_.bytes() + first_box_.bytes() +
                        listed_.bytes() + draws_.bytes() + darkness_.bytes();
    for (const TextureImage* texture :
         {&slopes_, &umbra_, &skip_depth_, &covered_, &wanted_, &darkest_, &plane_of_pixel_}) {
        bytes += *texture ? texture->bytes() : 0;
    }
    return bytes;
}

}  // namespace penumbra
