#pragma once

#include <cstdint>
#include <glm/glm.hpp>
#include <memory>
#include <string>
#include <vector>

#include "penumbra/control.h"
#include "penumbra/scene.h"
#include "reference/anchor_frame.h"
#include "reference/embree_table.h"

namespace penumbra {

/// Rays of one occlusion query: 16 side by side, as Embree takes them.
inline constexpr int kRayLanes = 16;
using RayPacket = embree::RayPacket<kRayLanes>;

/// Which instances of a scene rays can meet.
enum class RayTargets { Casting, Visible };
[[nodiscard]] constexpr bool is_target(const Instance& instance, RayTargets targets) noexcept {
    return targets == RayTargets::Casting ? instance.casts : instance.visible;
}

/// The casting instances of a scene, ready for occlusion rays, or those that the camera sees, ready for its own.
/// Immutable, so any number of threads may trace.
///
/// A mesh that is met once is flattened into the anchor frame in float64; one that stands in several places is built
/// once and instanced, unless its transform shears so strongly that float32 rays would lose digits in its local space.
class RayScene {
public:
    /// Builds on thread_count() threads. @throws Cancelled, OutOfMemory, DeviceError (no Embree)
    RayScene(const Scene& scene, Control& control, RayTargets targets = RayTargets::Casting);

    [[nodiscard]] const AnchorFrame& frame() const noexcept { return frame_; }
    /// True if there is nothing to meet: everything is lit, nothing is seen.
    [[nodiscard]] bool empty() const noexcept { return empty_; }
    /// How far the vertices of one instance reach from the anchor, per coordinate and in anchor units: the measure of
    /// their float32 rounding.
    struct Reach {
        float all = 0.0F;
        std::vector<float> per_triangle;  ///< empty for meshes with several instances: `all` serves every triangle
    };
    [[nodiscard]] const Reach& reach(std::int32_t instance) const noexcept {
        return reach_[static_cast<std::size_t>(instance)];
    }
    /// Triangles and instances in the acceleration structure.
    [[nodiscard]] std::size_t triangle_count() const noexcept { return triangle_count_; }
    [[nodiscard]] std::size_t instanced_count() const noexcept { return instanced_count_; }

    /// Any-hit query for the lanes with valid -1 (0: left alone): tfar becomes -infinity where a ray is blocked.
    /// `valid` is aligned to 64 bytes.
    void occluded(const int* valid, RayPacket& rays) const noexcept {
        if (!empty_) {
            table_->occluded16(valid, top_.get(), &rays);
        }
    }
    /// Whether this Embree takes streams of single rays.
    [[nodiscard]] bool has_streams() const noexcept { return table_->occluded_stream != nullptr; }
    /// The same query for a stream; only if has_streams().
    void occluded_stream(embree::Ray* rays, unsigned count) const noexcept {
        if (!empty_) {
            table_->occluded_stream(top_.get(), rays, count);
        }
    }
    /// The first hits of the lanes with valid -1; initialise `geometry` to embree::kNothing.
    void first_hit(const int* valid, embree::RayHitPacket<kRayLanes>& rays) const noexcept {
        if (!empty_) {
            table_->first_hit16(valid, top_.get(), &rays, instanced_count_ == 0);
        }
    }
    /// Index into Scene::instances of what a lane of first_hit() met.
    [[nodiscard]] std::uint32_t instance_of(std::uint32_t geometry, std::uint32_t embree_instance) const noexcept {
        return instance_of_[embree_instance != embree::kNothing ? embree_instance : geometry];
    }
    /// The Embree scene itself, for benchmarks.
    [[nodiscard]] embree::Scene* handle() const noexcept { return top_.get(); }

private:
    struct Release {
        void operator()(embree::Scene* scene) const noexcept;
    };
    using ScenePtr = std::unique_ptr<embree::Scene, Release>;

    [[nodiscard]] ScenePtr new_scene() const;
    void commit(embree::Scene* scene, Control& control) const;

    const embree::Table* table_ = nullptr;
    embree::Device* device_ = nullptr;
    AnchorFrame frame_;
    std::vector<ScenePtr> shared_;  ///< one per instanced mesh; outlives top_
    ScenePtr top_;
    std::vector<Reach> reach_;
    std::vector<std::uint32_t> instance_of_;  ///< by the number that Embree gave it in top_
    std::size_t triangle_count_ = 0;
    std::size_t instanced_count_ = 0;
    bool empty_ = true;
};

}  // namespace penumbra
