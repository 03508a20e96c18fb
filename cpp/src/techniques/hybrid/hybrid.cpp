#include "techniques/hybrid/hybrid.h"

#include <algorithm>
#include <array>

#include "passes/debug_picture.h"
#include "passes/frame.h"
#include "passes/volume_debug.h"
#include "scene/setting_forms.h"
#include "techniques/all_lights.h"

namespace penumbra {

namespace {

// As in classes.glsl.
constexpr std::uint8_t kTagged = 2;
constexpr std::size_t kClasses = 6;

constexpr const char* kFullscreen = "lib/fullscreen.vert";

MapBias no_bias() {
    MapBias bias;
    bias.mode = MapBias::Mode::None;  // classify.frag has its own
    return bias;
}

Hybrid::Mask mask_from(const std::string& name) {
    return name == "stencil"        ? Hybrid::Mask::Stencil
           : name == "tiles"        ? Hybrid::Mask::Tiles
           : name == "depth_bounds" ? Hybrid::Mask::DepthBounds
           : name == "discard"      ? Hybrid::Mask::Discard
                                    : Hybrid::Mask::Auto;
}

VolumePass::Options options_from(const Settings& settings) {
    VolumePass::Options options = volume_options(settings);
    const Hybrid::Mask mask = mask_from(get_choice(settings, "mask"));
    options.stencil_bits = mask == Hybrid::Mask::Discard ? 8 : 7;
    return options;
}

/// Reversed depth of what is seen at every pixel; 0 where nothing is.
std::vector<float> seen_depths(const Frame& frame) {
    const View& view = frame.view();
    const glm::dmat4 clip = clip_from_rel(frame.scene().camera);
    std::vector<float> depths(view.position_cr.size(), 0.0F);
    for (std::size_t i = 0; i < depths.size(); ++i) {
        if (view.hit(i)) {
            const glm::dvec4 p = clip * glm::dvec4{glm::dvec3{view.position_cr[i]}, 1.0};
            depths[i] = static_cast<float>(p.z / p.w);
        }
    }
    return depths;
}

std::vector<SettingInfo> hybrid_settings() {
    std::vector<SettingInfo> all{
        number_setting("map_size", "Map size", "px", "Width and height of each depth map; may be low.", 512, 16, 16384,
                       {256, 512, 1024}),
        toggle_setting("receiver_plane", "Receiver plane",
                       "Compares each of the four texels with the receiver's plane at its own centre; off: with one "
                       "depth, as published.",
                       true),
        number_setting(
            "bias", "Bias", "texel",
            "Taken from the receiver's depth, in widths of a map texel at the receiver. Low values tag more; "
            "high ones miss contacts.",
            0.02, 0.0, 1000.0),
        choice_setting("test", "Agreement test",
                       "gather: all four comparisons; pcf: one filtered fetch, as published, with one depth for all.",
                       {"gather", "pcf"}),
        toggle_setting("facing_test", "Facing test",
                       "Surfaces turned away from the light point are dark and never tagged.", true),
        choice_setting("ratio_culling", "Ratio culling",
                       "Untags pixels where a texel of the map is smaller than a pixel. conservative: by its longer "
                       "extent; scalar: by the published estimate, which drops pixels that do alias.",
                       {"off", "conservative", "scalar"}),
        toggle_setting(
            "caster_culling", "Caster culling",
            "Leaves out volumes of casters that the map shows to lie in shadow altogether. Gaps that the map "
            "does not see are closed by it.",
            false),
        choice_setting("mask", "Computation mask",
                       "stencil: one bit of it; tiles: draws only triangles that touch tiles with tagged pixels as "
                       "well; depth_bounds: a copy of the depth, where the device has the test; discard: by the "
                       "fragment shader; auto: tiles. The same image.",
                       {"auto", "stencil", "tiles", "depth_bounds", "discard"}),
        choice_setting("tile_sorting", "Tiles of the mask",
                       "gpu: a compute shader lists them and leaves out triangles that touch none, without a "
                       "read-back; cpu: the processor sorts triangles into rectangles of them, under scissors; auto: "
                       "gpu, but cpu where the device is a software rasteriser. The same image.",
                       {"auto", "gpu", "cpu"}),
    };
    const std::vector<SettingInfo> more = volume_settings();
    all.insert(all.end(), more.begin(), more.end());
    return all;
}

}  // namespace

const TechniqueInfo& Hybrid::description() {
    static const TechniqueInfo info{
        .id = "hybrid",
        .title = "Hybrid of map and volumes",
        .paper = "Chan2004",
        .summary =
            "A low shadow map, and shadow volumes at the pixels only where its texels disagree: exact hard edges at a "
            "part of the fill.",
        .randomised = false,
        .on_cpu = false,
        .lights = all_light_kinds(),
        .settings = hybrid_settings(),
        .knob = "map_size",
    };
    return info;
}

Hybrid::Hybrid(const Settings& settings)
    : map_{{.size_px = get_int(settings, "map_size"),
            .bias = no_bias(),
            .facing_test = get_bool(settings, "facing_test")}},
      volumes_{options_from(settings)},
      mask_{mask_from(get_choice(settings, "mask"))},
      tile_form_{get_choice(settings, "tile_sorting") == "gpu"   ? TileForm::Gpu
                 : get_choice(settings, "tile_sorting") == "cpu" ? TileForm::Cpu
                                                                 : TileForm::Auto},
      ratio_{get_choice(settings, "ratio_culling") == "off"      ? Ratio::Off
             : get_choice(settings, "ratio_culling") == "scalar" ? Ratio::Scalar
                                                                 : Ratio::Conservative},
      cull_casters_{get_bool(settings, "caster_culling")},
      pcf_form_{get_choice(settings, "test") == "pcf"},
      receiver_plane_{get_bool(settings, "receiver_plane") && !pcf_form_},
      bias_texels_{static_cast<float>(get_double(settings, "bias"))} {}

Verdict Hybrid::supports(const Light& /*light*/) const {
    return {};
}

FieldOfUse Hybrid::field_of_use() const {
    return {.needs_point_light = true, .needs_clear_light = true, .needs_light_above_horizon = map_.facing_test()};
}

Plan Hybrid::plan(const LightSummary& summary) const {
    Plan plan;
    if (map_.plan(summary, "classify", plan)) {
        if (cull_casters_) {
            plan.run("casters in shadow");
        }
        plan.run("mask");
        // Plans are made on the render thread; the image is the same.
        const Context* context = Context::current();
        if (mask_ == Mask::DepthBounds && context != nullptr && !context->extensions().depth_bounds_test) {
            plan.leave_out("depth bounds", "device-without-depth-bounds",
                           context->info().name + " has no GL_EXT_depth_bounds_test, so the stencil bit is the mask");
        }
    }
    volumes_.plan(summary, "lookup", plan);
    return plan;
}

Hybrid::Mask Hybrid::mask_for(const Frame& frame) const {
    if (mask_ == Mask::Auto) {
        return Mask::Tiles;
    }
    if (mask_ == Mask::DepthBounds && !frame.device().context.extensions().depth_bounds_test) {
        return Mask::Stencil;
    }
    return mask_;
}

bool Hybrid::tiles_on_device(const Frame& frame) const {
    return tile_form_ == TileForm::Gpu || (tile_form_ == TileForm::Auto && !frame.device().context.info().software);
}

void Hybrid::prepare(Frame& frame) {
    if (!frame.plan().runs("lookup")) {
        return;
    }
    map_.allocate(frame);
    volumes_.prepare(frame);
    const View& view = frame.view();
    classes_ = TextureImage::make_2d(GL_R8UI, view.width, view.height, "hybrid classes");
    any_tagged_ = Query::create(GL_ANY_SAMPLES_PASSED);
    class_target_ = RenderTarget{"hybrid classes"};
    class_target_.attach_colour(0, classes_);
    if (mask_for(frame) == Mask::DepthBounds) {
        masked_depth_ = TextureImage::make_2d(GL_DEPTH32F_STENCIL8, view.width, view.height, "hybrid mask");
        masked_target_ = RenderTarget{"hybrid mask"};
        masked_target_.attach_depth(masked_depth_);
        no_attributes_ = VertexArray::create();
    }
    if (mask_for(frame) == Mask::Tiles && !tiles_on_device(frame)) {
        tiles_ = TileGrid{view.width, view.height};
        depths_ = seen_depths(frame);
    }
    if (pcf_form_) {
        compare_ = Sampler::create();
        glSamplerParameteri(compare_.name(), GL_TEXTURE_MIN_FILTER, GL_LINEAR);
        glSamplerParameteri(compare_.name(), GL_TEXTURE_MAG_FILTER, GL_LINEAR);
        glSamplerParameteri(compare_.name(), GL_TEXTURE_WRAP_S, GL_CLAMP_TO_EDGE);
        glSamplerParameteri(compare_.name(), GL_TEXTURE_WRAP_T, GL_CLAMP_TO_EDGE);
        glSamplerParameteri(compare_.name(), GL_TEXTURE_COMPARE_MODE, GL_COMPARE_REF_TO_TEXTURE);
        glSamplerParameteri(compare_.name(), GL_TEXTURE_COMPARE_FUNC, GL_GEQUAL);
    }
}

void Hybrid::update(Frame& frame) {
    if (frame.plan().runs("lookup")) {
        map_.update(frame);
        frame.step("casters in shadow", [&] { culling_.test(frame, map_); });
        frame.step("volumes", [&] { volumes_.extract(frame); });
    }
}

void Hybrid::classify(Frame& frame) {
    Defines defines;
    if (pcf_form_) {
        defines.push_back({"PCF_FORM"});
    }
    if (receiver_plane_) {
        defines.push_back({"RECEIVER_PLANE"});
    }
    defines.push_back({"RATIO_CULLING", std::to_string(static_cast<int>(ratio_))});
    const Program& program = map_.lookup(frame, "techniques/hybrid/classify.frag", defines);
    map_.bind(program);
    program.set("bias_texels", bias_texels_);
    if (ratio_ != Ratio::Off) {
        const Camera& camera = frame.scene().camera;
        const double half_width = camera.orthographic ? camera.half_width_m : camera.tan_half_width;
        const double step = 2.0 * half_width / camera.width_px;
        program.set("pixel_right", glm::vec3{step * glm::dvec3{camera.world_from_camera[0]}});
        program.set("pixel_up", glm::vec3{step * camera.pixel_aspect * glm::dvec3{camera.world_from_camera[1]}});
        program.set("forward", glm::vec3{-glm::dvec3{camera.world_from_camera[2]}});
        program.set("orthographic", camera.orthographic);
    }
    if (pcf_form_) {
        glBindSampler(2, compare_.name());
    }
    frame.bind_view();
    glDisable(GL_BLEND);
    frame.fullscreen().draw(class_target_, program);
    glBindSampler(2, 0);
}

void Hybrid::install_mask(Frame& frame) {
    const Mask mask = mask_for(frame);
    if (mask == Mask::Discard) {
        return;
    }
    const TextureImage& depth = frame.view_depth();
    classes_.bind(1);
    if (mask == Mask::DepthBounds) {
        // Depth 0, which nothing that is seen has, where no pixel is tagged; in a copy, for the view's own is shared.
        glCopyImageSubData(depth.name(), GL_TEXTURE_2D, 0, 0, 0, 0, masked_depth_.name(), GL_TEXTURE_2D, 0, 0, 0, 0,
                           depth.width(), depth.height(), 1);
        const Program& program =
            frame.device().programs.get({kFullscreen, "techniques/hybrid/mask.frag"}, {{"CLEAR_DEPTH"}});
        masked_target_.bind();
        program.use();
        glEnable(GL_DEPTH_TEST);  // which FullscreenPass would switch off, and with it the writing
        glDepthMask(GL_TRUE);
        glDepthFunc(GL_ALWAYS);
        glBindVertexArray(no_attributes_.name());
        glDrawArrays(GL_TRIANGLES, 0, 3);
        glBindVertexArray(0);
        glDisable(GL_DEPTH_TEST);
        glDepthFunc(GL_GREATER);
        return;
    }
    if (stencil_texture_ != depth.name()) {
        stencil_target_ = RenderTarget{"hybrid mask"};
        stencil_target_.attach_depth(depth);
        stencil_texture_ = depth.name();
    }
    const GLint zero = 0;
    glClearNamedFramebufferiv(stencil_target_.name(), GL_STENCIL, 0, &zero);
    glEnable(GL_STENCIL_TEST);
    glStencilFunc(GL_ALWAYS, VolumeMask::kBit, 0xFF);
    glStencilOp(GL_KEEP, GL_KEEP, GL_REPLACE);
    if (mask == Mask::Tiles) {
        find_tagged_tiles(frame);
        classes_.bind(1);
        tile_list_.draw(stencil_target_,
                        frame.device().programs.get({"passes/tile_rectangles.vert", "techniques/hybrid/mask.frag"},
                                                    TileList::defines()));
    } else {
        glBeginQuery(GL_ANY_SAMPLES_PASSED, any_tagged_.name());
        frame.fullscreen().draw(stencil_target_,
                                frame.device().programs.get({kFullscreen, "techniques/hybrid/mask.frag"}));
        glEndQuery(GL_ANY_SAMPLES_PASSED);
    }
    glStencilOp(GL_KEEP, GL_KEEP, GL_KEEP);
    glStencilFunc(GL_ALWAYS, 0, 0xFF);
    glDisable(GL_STENCIL_TEST);
}

void Hybrid::find_tagged_tiles(Frame& frame) {
    if (tiles_on_device(frame)) {
        tile_list_.find(frame, classes_, kTagged);
        return;
    }
    const auto classes = classes_.read<std::uint8_t>();
    const View& view = frame.view();
    std::ranges::fill(tiles_.wanted, std::uint8_t{0});
    std::ranges::fill(tiles_.nearest, 0.0F);
    std::ranges::fill(tiles_.farthest, 1.0F);
    for (int y = 0; y < view.height; ++y) {
        const std::uint8_t* row = classes.data() + static_cast<std::ptrdiff_t>(y) * view.width;
        for (int x = 0; x < view.width; ++x) {
            if (row[x] == kTagged) {
                const std::size_t tile = tiles_.tile_of(x, y);
                const float depth = depths_[static_cast<std::size_t>(y) * static_cast<std::size_t>(view.width) +
                                            static_cast<std::size_t>(x)];
                tiles_.wanted[tile] = 1;
                tiles_.nearest[tile] = std::max(tiles_.nearest[tile], depth);
                tiles_.farthest[tile] = std::min(tiles_.farthest[tile], depth);
            }
        }
    }
    tile_list_.send(tiles_);
}

void Hybrid::count(Frame& frame) {
    VolumeMask mask;
    if (mask_for(frame) == Mask::Tiles) {
        if (tiles_on_device(frame)) {
            mask.tile_list = &tile_list_;
        } else {
            mask.tiles = &tiles_;
        }
    }
    switch (mask_for(frame)) {
        case Mask::Discard:
            mask.kind = VolumeMask::Kind::Class;
            mask.classes = &classes_;
            mask.wanted = kTagged;
            break;
        case Mask::DepthBounds:
            mask.kind = VolumeMask::Kind::DepthBounds;
            mask.depth_stencil = &masked_depth_;
            break;
        default:
            mask.kind = VolumeMask::Kind::Stencil;
            break;
    }
    if (cull_casters_) {
        mask.conditions = culling_.conditions();
    }
    // Nothing tagged, nothing drawn. Conditions do not nest, and tiles know it already.
    const bool conditional = mask_for(frame) == Mask::Stencil && !cull_casters_;
    if (conditional) {
        glBeginConditionalRender(any_tagged_.name(), GL_QUERY_NO_WAIT);
    }
    volumes_.count(frame, mask);
    if (conditional) {
        glEndConditionalRender();
    }
}

void Hybrid::resolve(Frame& frame) {
    frame.step("classify", [&] { classify(frame); });
    frame.step("mask", [&] { install_mask(frame); });
    frame.step("count", [&] { count(frame); });
    frame.step("lookup", [&] {
        const bool seven_bits = mask_for(frame) == Mask::Stencil || mask_for(frame) == Mask::Tiles;
        Defines defines{{"COUNT_BITS", volumes_.in_image() ? "-1" : seven_bits ? "0x7f" : "0xff"}};
        if (volumes_.in_image()) {
            defines.push_back({"COUNT_IN_IMAGE"});
        }
        classes_.bind(1);
        volumes_.bind_counts(2);
        frame.write_visibility_with(
            frame.device().programs.get({kFullscreen, "techniques/hybrid/resolve.frag"}, defines));
    });
}

std::size_t Hybrid::memory_bytes() const noexcept {
    return map_.bytes() + volumes_.bytes() + (classes_ ? classes_.bytes() : 0) +
           (masked_depth_ ? masked_depth_.bytes() : 0) + tile_list_.bytes();
}

std::vector<DebugView> Hybrid::debug_views(const Plan& plan) const {
    if (!plan.runs("lookup")) {
        return {};
    }
    std::vector<DebugView> views{{"classes", "Who decided, and what"}, {"tagged", "Tagged pixels"}, depth_map_view()};
    if (mask_ == Mask::Auto || mask_ == Mask::Tiles) {
        views.push_back({"tiles", "Tiles with tagged pixels"});
    }
    const std::vector<DebugView> more = volume_views();
    views.insert(views.end(), more.begin(), more.end());
    return views;
}

DebugImage Hybrid::debug_image(Frame& frame, std::string_view id) {
    if (id == "classes") {
        return class_picture(frame);
    }
    if (id == "tagged") {
        return tagged_picture(frame);
    }
    if (id == "tiles") {
        return tile_picture(frame);
    }
    return id == depth_map_view().id ? depth_map_picture(frame, map_) : volume_picture(frame, volumes_, id);
}

DebugImage Hybrid::class_picture(Frame& frame) {
    DebugImage image = view_picture(frame,
                                    "map says shadow: red, lit: blue; volumes say shadow: black, lit: green; "
                                    "turned away: dark red; outside the map: grey",
                                    [](RenderTarget&) {});
    const std::array<glm::vec3, kClasses> colours{{{0.15F, 0.3F, 0.9F},
                                                   {0.9F, 0.15F, 0.1F},
                                                   {0.0F, 0.0F, 0.0F},
                                                   {0.35F, 0.05F, 0.05F},
                                                   {0.5F, 0.5F, 0.5F},
                                                   {0.05F, 0.05F, 0.05F}}};
    const auto classes = classes_.read<std::uint8_t>();
    const std::vector<std::int32_t> counts = volumes_.read_counts();
    const std::int32_t bits = volumes_.in_image() ? -1 : 0x7F;
    for (std::size_t i = 0; i < classes.size(); ++i) {
        const bool lit_tag = classes[i] == kTagged && (counts[i] & bits) == 0;
        const float shade = 0.4F + image.rgb[i].x;
        image.rgb[i] =
            glm::min(shade * (lit_tag ? glm::vec3{0.1F, 0.85F, 0.1F} : colours[classes[i]]), glm::vec3{1.0F});
    }
    return image;
}

DebugImage Hybrid::tagged_picture(Frame& frame) {
    DebugImage image = view_picture(frame, "", [](RenderTarget&) {});
    const auto classes = classes_.read<std::uint8_t>();
    std::size_t tagged = 0;
    for (std::size_t i = 0; i < classes.size(); ++i) {
        if (classes[i] == kTagged) {
            image.rgb[i] = {0.1F, 0.9F, 0.1F};
            ++tagged;
        }
    }
    image.caption =
        "pixels that the volumes decide, green: " + std::to_string(tagged) + " of " + std::to_string(classes.size());
    return image;
}

DebugImage Hybrid::tile_picture(Frame& frame) {
    DebugImage image = tagged_picture(frame);
    const View& view = frame.view();
    const std::vector<TileList::Tile> tiles = tile_list_.read();
    for (const TileList::Tile& tile : tiles) {
        const glm::ivec2 low = TileGrid::kTile_px * glm::ivec2{tile.column, tile.row};
        const glm::ivec2 high = glm::min(low + TileGrid::kTile_px, glm::ivec2{view.width, view.height});
        for (int y = low.y; y < high.y; ++y) {
            for (int x = low.x; x < high.x; ++x) {
                glm::vec3& rgb = image.rgb[static_cast<std::size_t>(y) * static_cast<std::size_t>(view.width) +
                                           static_cast<std::size_t>(x)];
                rgb = 0.6F * rgb + glm::vec3{0.4F, 0.3F, 0.0F};
            }
        }
    }
    image.caption =
        "tiles in which volumes are drawn, yellow: " + std::to_string(tiles.size()) + "; their tagged pixels, green";
    return image;
}

std::vector<Statistic> Hybrid::statistics(Frame& frame) {
    if (!frame.plan().runs("lookup")) {
        return {};
    }
    std::vector<Statistic> all = volume_statistics(frame, volumes_);
    const auto classes = classes_.read<std::uint8_t>();
    const std::vector<float> fragments = volumes_.read_overdraw(frame);
    double tagged = 0.0;
    double updates = 0.0;
    for (std::size_t i = 0; i < classes.size(); ++i) {
        if (classes[i] == kTagged) {
            tagged += 1.0;
            updates += fragments[i];
        }
    }
    const double pixels = std::max(1.0, static_cast<double>(classes.size()));
    all.push_back({"tagged", "Tagged pixels", "pixels", tagged});
    all.push_back({"tagged_share", "Tagged pixels", "share of the picture", tagged / pixels});
    if (cull_casters_) {
        all.push_back({"culled_casters", "Casters that lie in shadow altogether", "casters",
                       static_cast<double>(culling_.culled())});
    }
    if (mask_for(frame) == Mask::Tiles) {
        all.push_back({"tagged_tiles", "Tiles of 16 x 16 pixels that hold tagged pixels", "tiles",
                       static_cast<double>(tile_list_.read().size())});
        const bool on_device = tiles_on_device(frame);
        all.push_back({"drawn_in_tiles",
                       on_device ? "Triangles drawn: those that touch such tiles"
                                 : "Triangles drawn, once for each rectangle of such tiles",
                       "triangles",
                       static_cast<double>(on_device ? volumes_.drawn_of_list() : volumes_.drawn_in_tiles())});
    }
    all.push_back({"masked_fragments", "Fragments of the volumes under the mask", "fragments", updates});
    all.push_back(
        {"masked_overdraw", "Fragments under the mask per pixel of the picture", "fragments", updates / pixels});
    return all;
}

}  // namespace penumbra
