#include "renderer/kept_frames.h"

#include <algorithm>
#include <set>

namespace penumbra {

namespace {

template <class T>
void add_bytes(Digest& digest, const std::vector<T>& values) {
    digest.add(static_cast<std::uint64_t>(values.size()));
    digest.add_bytes(values.data(), values.size() * sizeof(T));
}

std::size_t bytes_of(const VisibilityResult& made) noexcept {
    return made.visibility.size() * sizeof(float);
}

}  // namespace

void FrameDigests::forget_meshes(const Scene& scene) {
    std::set<const Mesh*> there;
    for (const Instance& instance : scene.instances) {
        there.insert(instance.mesh.get());
    }
    std::erase_if(meshes_, [&](const auto& known) { return !there.contains(known.first); });
}

void FrameDigests::add_instance(Digest& digest, const Instance& instance) {
    KnownMesh& known = meshes_[instance.mesh.get()];
    if (!known.mesh) {
        known = {instance.mesh, mesh_digest(*instance.mesh)};
    }
    digest.add(known.digest);
    digest.add(instance.world_from_local);
    digest.add(instance.casts);
    digest.add(instance.receives);
    digest.add(instance.visible);
}

const std::string& FrameDigests::of_view(const View& view) {
    if (of_view_.empty()) {
        Digest digest;
        digest.add(view.width);
        digest.add(view.height);
        digest.add(view.eye_ws);
        add_bytes(digest, view.position_cr);
        add_bytes(digest, view.normal_ws);
        add_bytes(digest, view.instance);
        add_bytes(digest, view.triangle);
        of_view_ = digest.hex();
    }
    return of_view_;
}

std::string FrameDigests::of_summary(const LightSummary& summary, std::size_t light) {
    std::string& known = of_summaries_[{light, summary.keep}];
    if (known.empty()) {
        const Scene& scene = *summary.scene;
        Digest digest;
        digest.add(of_view(*summary.view));
        digest.add(camera_digest(scene.camera));
        digest.add(light_digest(*summary.light));
        add_bytes(digest, summary.mask);
        digest.add(static_cast<std::uint64_t>(summary.receivers.size()));
        for (const std::uint32_t i : summary.receivers) {
            digest.add(i);
            add_instance(digest, scene.instances[i]);
        }
        for (std::size_t i = 0; i < summary.casters.size(); ++i) {
            digest.add(summary.caster_needed[i]);
            add_instance(digest, scene.instances[summary.casters[i]]);
        }
        digest.add(static_cast<std::uint64_t>(summary.near_hull.size()));
        for (const std::uint32_t i : summary.near_hull) {
            add_instance(digest, scene.instances[i]);
        }
        known = digest.hex();
    }
    return known;
}

std::string FrameDigests::of_all_casters(const Scene& scene) {
    Digest digest;
    for (const Instance& instance : scene.instances) {
        if (instance.casts) {
            add_instance(digest, instance);
        }
    }
    return digest.hex();
}

const VisibilityResult* KeptFrames::find(const std::string& frame, const std::string& rays, bool statistics) {
    const auto found = entries_.find(frame);
    if (found == entries_.end()) {
        return nullptr;
    }
    Entry& entry = found->second;
    if ((!entry.rays.empty() && entry.rays != rays) || (statistics && !entry.statistics)) {
        return nullptr;
    }
    entry.last_use = ++uses_;
    return &entry.made;
}

void KeptFrames::store(const std::string& frame, const std::string& rays, bool statistics,
                       const VisibilityResult& made) {
    const auto forget = [&](auto entry) {
        bytes_ -= bytes_of(entry->second.made);
        entries_.erase(entry);
    };
    if (const auto old = entries_.find(frame); old != entries_.end()) {
        forget(old);
    }
    const std::size_t bytes = bytes_of(made);
    while (!entries_.empty() && bytes_ + bytes > most_bytes_) {
        forget(std::ranges::min_element(entries_, {}, [](const auto& entry) { return entry.second.last_use; }));
    }
    if (bytes > most_bytes_) {
        return;
    }
    entries_.emplace(frame, Entry{rays, statistics, made, ++uses_});
    bytes_ += bytes;
}

Plan unchanged_plan(const Plan& made) {
    Plan plan;
    for (const Step& step : made.steps) {
        if (step.run) {
            plan.leave_out(step.name, "frame-unchanged",
                           "view, light, casters and settings are those of a frame whose visibility is kept");
        } else {
            plan.steps.push_back(step);
        }
    }
    return plan;
}

}  // namespace penumbra
