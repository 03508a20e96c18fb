#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <memory>
#include <string>

#include "passes/light_summary.h"
#include "penumbra/renderer.h"
#include "scene/digest.h"

namespace penumbra {

/// Digests of all that V depends on, so that a frame is made again only if one of them has changed. Whether a mesh
/// changed is told by its address, which it keeps while it is in the scene; its content is read once.
class FrameDigests {
public:
    /// Another scene: meshes that are no longer in it are forgotten.
    void forget_meshes(const Scene& scene);
    /// All that a technique without rays may read of scene, view and light: the view's surfaces and the mask, the
    /// camera, the light, the casters of the summary and the visible receivers.
    [[nodiscard]] std::string of_summary(const LightSummary& summary, std::size_t light);
    /// Another view or other lights.
    void forget_summaries() { of_summaries_.clear(); }
    void forget_view() { of_view_.clear(); }
    /// All casting instances: rays are traced in a frame that is fitted to all of them.
    [[nodiscard]] std::string of_all_casters(const Scene& scene);

private:
    struct KnownMesh {
        std::shared_ptr<const Mesh> mesh;  ///< kept, so that the address names no other
        std::string digest;
    };
    void add_instance(Digest& digest, const Instance& instance);
    [[nodiscard]] const std::string& of_view(const View& view);

    std::map<const Mesh*, KnownMesh> meshes_;
    std::map<std::pair<std::size_t, Keep>, std::string> of_summaries_;
    std::string of_view_;
};

/// V of frames already made, by the digest of what they were made from; the least recently asked for goes first.
class KeptFrames {
public:
    explicit KeptFrames(std::size_t most_bytes) : most_bytes_{most_bytes} {}

    /// @param rays digest of all casters, compared only for a frame that asked for rays
    /// @return null if there is none; valid until the next call
    [[nodiscard]] const VisibilityResult* find(const std::string& frame, const std::string& rays, bool statistics);
    /// @param rays empty for a frame that asked for no rays
    void store(const std::string& frame, const std::string& rays, bool statistics, const VisibilityResult& made);
    [[nodiscard]] std::size_t bytes() const noexcept { return bytes_; }

private:
    struct Entry {
        std::string rays;
        bool statistics = false;
        VisibilityResult made;
        std::uint64_t last_use = 0;
    };
    std::size_t most_bytes_;
    std::size_t bytes_ = 0;
    std::uint64_t uses_ = 0;
    std::map<std::string, Entry> entries_;
};

/// The plan of a frame that is handed over: what ran then is left out now.
[[nodiscard]] Plan unchanged_plan(const Plan& made);

}  // namespace penumbra
