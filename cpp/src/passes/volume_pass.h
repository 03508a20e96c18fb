#pragma once

#include <array>
#include <cstdint>
#include <glm/glm.hpp>
#include <map>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "geometry/shadow_volume.h"
#include "geometry/volume_tiles.h"
#include "gl/buffer.h"
#include "gl/framebuffer.h"
#include "gl/glsl_types.h"
#include "gl/handles.h"
#include "gl/texture.h"
#include "passes/light_summary.h"
#include "passes/silhouette_pass.h"
#include "penumbra/plan.h"
#include "penumbra/settings.h"

namespace penumbra {

namespace gpu {
#include "shared/volume_slot.h"
}  // namespace gpu

class Frame;
class GpuScene;
class Program;
class TileList;

/// Where volumes are counted: a computation mask [Chan2004]. Elsewhere counts are 0, or mean nothing.
struct VolumeMask {
    enum class Kind {
        None,
        Stencil,      ///< where the view's stencil is kBit: the caller has cleared and written it; 7 bits count
        Class,        ///< where `classes` is `wanted`, by the fragment shader
        DepthBounds,  ///< where `depth_stencil`, a copy of the view's, is not 0 (GL_EXT_depth_bounds_test)
    };
    static constexpr int kBit = 0x80;
    Kind kind = Kind::None;
    const TextureImage* classes = nullptr;
    unsigned wanted = 0;
    const TextureImage* depth_stencil = nullptr;
    /// Nothing need be drawn but in these tiles; nullptr: everywhere. A pre-filter: combine it with another kind. The
    /// processor draws each triangle in the rectangles of wanted tiles that it touches, under their scissors; the
    /// device draws once, without a read-back, what touches any. One of the two.
    const TileGrid* tiles = nullptr;
    const TileList* tile_list = nullptr;
    /// Per caster of the summary: a query without whose samples it is not drawn, 0 for none; empty: all are drawn.
    std::span<const GLuint> conditions;
};

/// Shadow volumes [Crow1977] of chosen casters, counted against the camera's depth: at every pixel how many of their
/// triangles the segment from the light to the visible point crosses. Exact per pixel, without bias: near caps fall on
/// the surfaces themselves bit by bit, and there the depth test fails.
///
/// Volumes run to infinity (w = 0) under depth clamp; z-fail counts what lies behind [EverittKilgard2002], and z-pass
/// what lies in front of casters that surely leave the eye outside. See docs/techniques/shadow_volume.md.
class VolumePass {
public:
    enum class Faces { Auto, LightFacing, All };
    enum class Counting {
        Auto,     ///< Stencil unless more volumes may lie in each other than it can count
        Stencil,  ///< modulo 256, under a mask bit 128
        Image,    ///< 32 bits
    };
    struct Options {
        SilhouettePass::Source source = SilhouettePass::Source::Auto;
        Faces faces = Faces::Auto;
        Counting counting = Counting::Auto;
        bool leave_out_caps = true;  ///< z-pass where eye_is_outside()
        int stencil_bits = 8;        ///< for counting; 7 leave bit 128 to a mask
    };
    explicit VolumePass(const Options& options) : options_{options} {}

    /// Adds the steps `volumes`, `caps`, `count` and `lookup`, run or left out.
    /// @return false if the light needs no volumes at all
    bool plan(const LightSummary& summary, std::string_view lookup, Plan& plan) const;

    /// Tables of the summary's casters.
    void prepare(Frame& frame);
    /// Facings, edges and index lists for the light's centre.
    void extract(Frame& frame);

    /// Counts at every pixel of the light's mask, or at those that `mask` lets through. Leaves textures, buffers and
    /// all state but program and bindings as they were. Counts in the stencil of the view's depth, which it clears
    /// unless that holds a mask.
    void count(Frame& frame, const VolumeMask& mask = {});
    /// After count(): the counts at texture unit `unit`, as usampler2D (stencil) or isampler2D (COUNTS_IN_IMAGE).
    void bind_counts(GLuint unit) const;
    [[nodiscard]] bool in_image() const noexcept { return in_image_; }

    /// The same in main memory, after count(); waits for the device.
    [[nodiscard]] std::vector<std::int32_t> read_counts() const;

    /// All volumes' triangles with a program that has volume.vert, the state being the caller's: debug pictures.
    void draw(Frame& frame, const Program& program);
    /// Volume fragments per pixel, with no depth test; waits for the device.
    [[nodiscard]] std::vector<float> read_overdraw(Frame& frame);

    /// The largest count that any pixel can have; exact or too large.
    [[nodiscard]] std::uint64_t most_layers() const noexcept { return most_layers_; }
    /// Triangles times rectangles of the last count() with tiles.
    [[nodiscard]] std::uint64_t drawn_in_tiles() const noexcept { return drawn_in_tiles_; }
    /// Triangles of the last count() with a tile list; waits for the device.
    [[nodiscard]] std::uint64_t drawn_of_list() const;
    /// Waits for the device where it found them.
    [[nodiscard]] std::uint64_t triangle_count();
    [[nodiscard]] std::size_t bytes() const noexcept;

private:
    struct Slot {
        std::uint32_t instance = 0, mesh = 0;
        bool without_caps = false;
    };
    struct DrawCommand {
        std::uint32_t count, instance_count, first_index;
        std::int32_t base_vertex;
        std::uint32_t base_instance;
    };
    /// A run of draw commands that share their state.
    struct Group {
        bool clockwise = false, z_pass = false;
        std::size_t first = 0, count = 0;
    };
    [[nodiscard]] bool needs_no_caps(const LightSummary& summary, std::size_t caster) const;
    void send_vertices(const GpuScene& gpu_scene);
    void find_on_cpu(Frame& frame, const glm::dvec4& light_ws);
    void find_on_device(Frame& frame, const glm::dvec4& light_ws);
    void read_back();
    [[nodiscard]] VolumeFaces faces_of(const Slot& slot, const glm::dvec4& light_local) const;
    void sort_commands(std::vector<std::pair<Group, DrawCommand>>& all, std::uint64_t end);
    void bound_layers(const Frame& frame, const glm::dvec4& light_ws);
    void aim_at(const TextureImage& depth_stencil);
    [[nodiscard]] std::uint64_t stencil_limit() const noexcept {
        return std::uint64_t{1} << static_cast<unsigned>(options_.stencil_bits);
    }
    void set_uniforms(Frame& frame, const Program& program);
    [[nodiscard]] VertexArray make_vertex_array(const StorageBuffer& indices) const;
    void set_state(const Group& group, const Program& program) const;
    void sort_into_tiles(Frame& frame, const VolumeMask& mask);
    void draw_under_conditions(const Program& program, std::span<const GLuint> conditions) const;
    void draw_in_tiles(const Program& program) const;
    void sift_by_tiles(Frame& frame, const TileList& tiles);
    static void issue(const Group& group);

    Options options_;
    std::vector<Slot> slots_;
    std::vector<std::shared_ptr<const Mesh>> meshes_;  ///< kept, so that a pointer names the same mesh as before
    std::map<std::uint32_t, std::unique_ptr<VolumeMaker>> makers_;
    VolumeIndices found_;
    std::vector<VolumeFaces> faces_;  ///< per slot
    std::vector<std::uint32_t> found_indices_;
    std::vector<Group> groups_;
    std::vector<DrawCommand> drawn_;  ///< as in commands_
    std::map<std::uint32_t, std::uint32_t> slot_of_instance_;
    /// Of sort_into_tiles(): what each rectangle draws.
    struct Cell {
        glm::ivec4 scissor{0};
        std::vector<Group> groups;
    };
    std::vector<Cell> cells_;
    StorageBuffer cell_indices_, cell_commands_;
    VertexArray cell_vertex_array_;
    StorageBuffer sift_jobs_, kept_indices_, kept_commands_;  ///< of sift_by_tiles()
    VertexArray kept_vertex_array_;
    std::vector<std::uint32_t> most_in_command_;  ///< indices that each of drawn_ has room for
    std::uint64_t drawn_in_tiles_ = 0;
    glm::ivec4 scissor_{0};  ///< x, y, width, height of the light's mask
    std::uint64_t most_layers_ = 0;
    bool on_cpu_ = false;
    bool read_back_ = false;  ///< found_indices_ and drawn_ are what the device holds
    bool in_image_ = false;
    StorageBuffer vertices_, instance_numbers_, indices_, commands_, instances_, device_slots_, jobs_;
    VertexArray vertex_array_;
    TextureImage counts_;
    RenderTarget target_;
    GLuint target_depth_ = 0;                ///< the texture that target_ has
    const TextureImage* counted_ = nullptr;  ///< whose stencil holds the counts
};

/// The settings of every technique that has a VolumePass: silhouettes, faces, counting.
[[nodiscard]] std::vector<SettingInfo> volume_settings();
[[nodiscard]] VolumePass::Options volume_options(const Settings& settings);

}  // namespace penumbra
