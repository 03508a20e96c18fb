#pragma once

#include <cstdint>
#include <glm/glm.hpp>
#include <span>
#include <vector>

#include "geometry/silhouettes.h"
#include "gl/buffer.h"
#include "gl/glsl_types.h"
#include "passes/gpu_adjacency.h"

namespace penumbra {

namespace gpu {
#include "shared/silhouette.h"
}  // namespace gpu

class Frame;
class GpuScene;

/// The silhouettes that one light point sees, as records in one buffer (shared/silhouette.h), for every technique that
/// grows edges from them. A compute shader finds them; the count stays on the device and feeds indirect draws, so that
/// nothing is read back. Edge-on faces do not vote (kEdgeOn), so doubled edges may appear near edge-on: techniques
/// combine by minimum, to which a double is nothing.
class SilhouettePass {
public:
    enum class Source { Gpu, Cpu };  ///< Cpu: FlatSilhouettes, then one upload; the same records in another order
    struct Options {
        Source source = Source::Gpu;
        EdgeChoice choice = EdgeChoice::Silhouettes;
    };
    explicit SilhouettePass(const Options& options) : options_{options} {}

    /// Tables and buffers for these instances. Capacity is what the worst case needs up to 64 MiB; beyond that what is
    /// found decides, and extract() reads the count once to make room.
    /// @param adjacency  frame.adjacency(), or the technique's own for meshes of its own (simplified casters)
    void prepare(Frame& frame, GpuScene& gpu_scene, GpuAdjacency& adjacency, std::span<const std::uint32_t> instances);
    /// @param light_ws   light point, w = 1; a sun: direction towards it, w = 0
    /// @param origin_ws  what positions are made relative to (the map's origin), float64
    void extract(Frame& frame, const glm::dvec4& light_ws, const glm::dvec3& origin_ws);

    /// Records as layout(std430, binding = `binding`) buffer.
    void bind(GLuint binding) const;
    /// Draws `vertices_per_edge` vertices for each record with the program in use and no attributes:
    /// record = gl_VertexID / vertices_per_edge (not instanced: a software rasteriser pays per instance).
    void draw(Frame& frame, GLenum mode, int vertices_per_edge);

    /// Edges that could be silhouettes: of all instances given to prepare().
    [[nodiscard]] std::uint64_t edge_count() const noexcept { return edge_count_; }
    /// Waits for the device: for tests, debug views and reports.
    [[nodiscard]] std::uint32_t read_count() const;
    [[nodiscard]] std::vector<gpu::SilhouetteRecord> read() const;
    [[nodiscard]] std::size_t bytes() const noexcept;

private:
    Options options_;
    std::uint64_t edge_count_ = 0;
};

}  // namespace penumbra
