#pragma once

#include <cstdint>
#include <glm/glm.hpp>
#include <map>
#include <memory>
#include <span>
#include <vector>

#include "geometry/silhouettes.h"
#include "gl/buffer.h"
#include "gl/buffer_texture.h"
#include "gl/glsl_types.h"
#include "passes/gpu_adjacency.h"
#include "penumbra/settings.h"

namespace penumbra {

namespace gpu {
#include "shared/silhouette.h"
#include "shared/silhouette_instance.h"
}  // namespace gpu

class Frame;
class GpuScene;

/// The silhouettes that one light point sees, as records in one buffer (shared/silhouette.h), for every technique that
/// grows edges from them. A compute shader finds them; the count stays on the device and feeds indirect draws, so that
/// nothing is read back. Edge-on faces do not vote (kEdgeOn), so doubled edges may appear near edge-on: techniques
/// combine by minimum, to which a double is nothing.
class SilhouettePass {
public:
    enum class Source {
        Gpu,
        Cpu,   ///< FlatSilhouettes, then one upload; the same records in another order
        Auto,  ///< Cpu where the device renders on the CPU and compute shaders cost several times as much, else Gpu
    };
    struct Options {
        Source source = Source::Gpu;
        EdgeChoice choice = EdgeChoice::Silhouettes;
        std::size_t first_bytes = std::size_t{64} << 20U;  ///< of records, unless the worst case needs less
    };
    explicit SilhouettePass(const Options& options) : options_{options} {}

    /// Tables and buffers for these instances; again when they or the scene's meshes change, not when they move.
    /// Capacity is what the worst case needs, up to Options::first_bytes; beyond that what is found decides: extract()
    /// then reads the count, and makes room and starts again where there was too little.
    /// @param gpu_scene  with `adjacency` used by extract() as well, must live until then
    /// @param adjacency  frame.adjacency(), or the technique's own for meshes of its own (simplified casters)
    /// @throws OutOfMemory
    void prepare(Frame& frame, GpuScene& gpu_scene, GpuAdjacency& adjacency, std::span<const std::uint32_t> instances);
    /// Clobbers texture units 0 .. 7, storage bindings 6 and 7 and the program in use.
    /// @param light_ws   light point, w = 1; a sun: direction towards it, w = 0
    /// @param origin_ws  what positions are made relative to (the map's origin), float64
    void extract(Frame& frame, const glm::dvec4& light_ws, const glm::dvec3& origin_ws);

    /// Records as layout(std430, binding = `binding`) buffer.
    void bind(GLuint binding) const;
    /// Draws `vertices_per_edge` vertices for each record with the program in use and no attributes:
    /// record = gl_VertexID / vertices_per_edge (not instanced: a software rasteriser pays per instance). `mode` must
    /// be one of separate primitives (GL_TRIANGLES, GL_LINES, GL_POINTS). Touches no binding but the vertex array's and
    /// the indirect buffer's.
    /// @param vertices_per_edge  1 .. PENUMBRA_MAX_VERTICES_PER_EDGE
    void draw(Frame& frame, GLenum mode, int vertices_per_edge);

    /// Edges that could be silhouettes: of all instances given to prepare().
    [[nodiscard]] std::uint64_t edge_count() const noexcept { return edge_count_; }
    /// Records that the buffer holds at most; extract() may raise it.
    [[nodiscard]] std::uint64_t capacity() const noexcept { return capacity_; }
    /// Waits for the device: for tests, debug views and reports.
    [[nodiscard]] std::uint32_t read_count() const;
    [[nodiscard]] std::vector<gpu::SilhouetteRecord> read() const;
    [[nodiscard]] std::size_t bytes() const noexcept;

private:
    struct Slot {
        std::uint32_t instance = 0, mesh = 0;
    };
    void make_room(std::uint64_t records);
    void send_instances(const glm::dvec4& light_ws, const glm::dvec3& origin_ws);
    void find_on_device(Frame& frame);
    void find_on_cpu(const glm::dvec4& light_ws, const glm::dvec3& origin_ws);
    void write_commands(Frame& frame);

    Options options_;
    const GpuScene* gpu_scene_ = nullptr;
    const GpuAdjacency* adjacency_ = nullptr;
    std::vector<Slot> slots_;
    std::vector<gpu::SilhouetteInstance> instance_data_;  ///< what does not change between frames is kept here
    bool on_cpu_ = false;
    std::map<std::uint32_t, std::unique_ptr<FlatSilhouettes>> flat_;  ///< by mesh; on the CPU only
    std::vector<SilhouetteEdge> found_edges_;
    std::vector<gpu::SilhouetteRecord> found_records_;
    std::uint64_t edge_count_ = 0, worst_case_ = 0, capacity_ = 0;
    std::uint32_t job_count_ = 0;
    StorageBuffer instances_, jobs_, candidates_, records_, commands_;
    BufferTexture instance_texels_, job_texels_;
    VertexArray no_attributes_;
};

/// The setting "silhouettes" of every technique that has a SilhouettePass, and what it chooses.
[[nodiscard]] SettingInfo silhouette_setting();
[[nodiscard]] SilhouettePass::Source silhouette_source(const Settings& settings);

}  // namespace penumbra
