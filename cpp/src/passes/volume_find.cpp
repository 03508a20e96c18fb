// Of VolumePass: which triangles the volumes of a light have, found on the processor or on the device.

#include <algorithm>

#include "geometry/layer_bound.h"
#include "passes/frame.h"
#include "passes/volume_jobs.h"
#include "passes/volume_light.h"
#include "passes/volume_pass.h"
#include "penumbra/error.h"

namespace penumbra {

void VolumePass::extract(Frame& frame) {
    const glm::dvec4 light_ws = homogeneous_centre(frame.light());
    const GpuScene& gpu_scene = frame.gpu_scene();
    faces_.clear();
    most_layers_ = 0;
    for (const Slot& slot : slots_) {
        faces_.push_back(faces_of(slot, local_light(gpu_scene.world_from_recentred(slot.instance),
                                                    gpu_scene.mesh_ranges()[slot.mesh].centre_local, light_ws)));
        most_layers_ += meshes_[slot.mesh]->triangles.size();
    }
    if (on_cpu_) {
        find_on_cpu(frame, light_ws);
    } else {
        find_on_device(frame, light_ws);
    }
    if (most_layers_ >= stencil_limit() && options_.counting == Counting::Auto) {
        bound_layers(frame, light_ws);
    }
    vertex_array_ = make_vertex_array(indices_);
    in_image_ = options_.counting == Counting::Image ||
                (options_.counting == Counting::Auto && most_layers_ >= stencil_limit());
    const View& view = frame.view();
    if (in_image_ && (!counts_ || counts_.width() != view.width || counts_.height() != view.height)) {
        counts_ = TextureImage::make_2d(GL_R32I, view.width, view.height, "volume counts");
    }
}

VolumeFaces VolumePass::faces_of(const Slot& slot, const glm::dvec4& light_local) const {
    const VolumeMaker& maker = *makers_.at(slot.mesh);
    return options_.faces == Faces::All ? VolumeFaces::All
           : options_.faces == Faces::LightFacing
               ? VolumeFaces::Towards
               : volume_faces(maker.closure(), *meshes_[slot.mesh], maker.bounds_local(), light_local);
}

/// Draws with one state side by side. @param all  in the order of their indices, @param end  of the last one's
void VolumePass::sort_commands(std::vector<std::pair<Group, DrawCommand>>& all, std::uint64_t end) {
    std::map<std::uint32_t, std::uint32_t> room;  // by first index; commands without any share theirs with the next
    for (std::size_t i = 0; i < all.size(); ++i) {
        const std::uint64_t next = i + 1 < all.size() ? all[i + 1].second.first_index : end;
        room[all[i].second.first_index] = static_cast<std::uint32_t>(next - all[i].second.first_index);
    }
    std::ranges::stable_sort(
        all, {}, [](const auto& found) { return (found.first.z_pass ? 2 : 0) + (found.first.clockwise ? 1 : 0); });
    groups_.clear();
    drawn_.clear();
    most_in_command_.clear();
    for (const auto& [group, command] : all) {
        if (groups_.empty() || groups_.back().clockwise != group.clockwise || groups_.back().z_pass != group.z_pass) {
            groups_.push_back(group);
            groups_.back().first = drawn_.size();
        }
        ++groups_.back().count;
        drawn_.push_back(command);
        most_in_command_.push_back(room.at(command.first_index));
    }
}

void VolumePass::find_on_cpu(Frame& frame, const glm::dvec4& light_ws) {
    const GpuScene& gpu_scene = frame.gpu_scene();
    const bool ends_meet = light_ws.w == 0.0 && !frame.scene().camera.orthographic;
    std::vector<std::pair<Group, DrawCommand>> all;
    found_indices_.clear();
    for (std::size_t i = 0; i < slots_.size(); ++i) {
        const Slot& slot = slots_[i];
        const GpuScene::MeshRange& placed = gpu_scene.mesh_ranges()[slot.mesh];
        found_.clear();
        makers_.at(slot.mesh)->append(
            local_light(gpu_scene.world_from_recentred(slot.instance), placed.centre_local, light_ws), faces_[i],
            {.near_caps = !slot.without_caps, .far_caps = !slot.without_caps && !ends_meet, .far_edges = !ends_meet},
            placed.first_vertex, found_);
        const bool mirrored = gpu_scene.mirrored(slot.instance);
        for (const bool flipped : {false, true}) {
            const auto& list = flipped ? found_.flipped : found_.wound;
            if (!list.empty()) {
                all.push_back({{.clockwise = flipped != mirrored, .z_pass = slot.without_caps},
                               {static_cast<std::uint32_t>(list.size()), 1,
                                static_cast<std::uint32_t>(found_indices_.size()), 0, slot.instance}});
                found_indices_.insert(found_indices_.end(), list.begin(), list.end());
            }
        }
    }
    sort_commands(all, found_indices_.size());
    indices_.replace(std::span<const std::uint32_t>{found_indices_});
    commands_.replace(std::span<const DrawCommand>{drawn_});
    read_back_ = true;
}

void VolumePass::find_on_device(Frame& frame, const glm::dvec4& light_ws) {
    const GpuScene& gpu_scene = frame.gpu_scene();
    const GpuAdjacency& adjacency = frame.adjacency();
    const bool ends_meet = light_ws.w == 0.0 && !frame.scene().camera.orthographic;
    std::vector<std::pair<Group, DrawCommand>> all;
    std::vector<gpu::VolumeSlot> slots(slots_.size());
    std::vector<gpu::VolumeJob> jobs;
    std::uint64_t capacity = 0;
    for (std::uint32_t i = 0; i < slots_.size(); ++i) {
        const Slot& slot = slots_[i];
        const GpuScene::MeshRange& placed = gpu_scene.mesh_ranges()[slot.mesh];
        const GpuAdjacency::MeshRange& range = adjacency.range(slot.mesh);
        const Adjacency& edges = adjacency.of_mesh(slot.mesh);
        const glm::dvec4 light =
            local_light(gpu_scene.world_from_recentred(slot.instance), placed.centre_local, light_ws);
        gpu::VolumeSlot& data = slots[i];
        data.light = glm::vec4{range.frame.light(light - light.w * glm::dvec4{placed.centre_local, 0.0})};
        data.first_vertex = placed.first_vertex;
        data.first_triangle = placed.first_index / 3;
        data.first_plane = range.first_plane;
        data.first_edge = range.first_edge;
        data.first_more = range.first_more;
        data.faces = static_cast<std::uint32_t>(faces_[i]);
        data.near_caps = slot.without_caps ? 0 : 1;
        data.far_caps = slot.without_caps || ends_meet ? 0 : 1;
        data.far_edges = ends_meet ? 0 : 1;
        const auto triangles = static_cast<std::uint32_t>(meshes_[slot.mesh]->triangles.size());
        const auto edge_count = static_cast<std::uint32_t>(edges.edges.size());
        const std::uint64_t wound = 3ULL * triangles * (data.near_caps + data.far_caps) +
                                    3ULL * (1 + data.far_edges) * most_sides(edges, faces_[i]);
        const std::uint64_t flipped = 3ULL * triangles * data.near_caps;
        const bool mirrored = gpu_scene.mirrored(slot.instance);
        all.push_back({{.clockwise = mirrored, .z_pass = slot.without_caps},
                       {0, 1, static_cast<std::uint32_t>(capacity), 0, slot.instance}});
        all.push_back({{.clockwise = !mirrored, .z_pass = slot.without_caps},
                       {0, 1, static_cast<std::uint32_t>(capacity + wound), 0, slot.instance}});
        capacity += wound + flipped;
        constexpr std::uint32_t kElements = 4 * kVolumeGroupSize;
        for (std::uint32_t first = 0; first < triangles && data.near_caps + data.far_caps > 0; first += kElements) {
            jobs.push_back({i, first, std::min(kElements, triangles - first), 0});
        }
        for (std::uint32_t first = 0; first < edge_count; first += kElements) {
            jobs.push_back({i, first, std::min(kElements, edge_count - first), 1});
        }
    }
    if (capacity > 0xffffffffULL) {
        throw OutOfMemory("the shadow volumes of " + std::to_string(slots_.size()) + " casters may have " +
                          std::to_string(capacity / 3) +
                          " triangles, more than 32-bit indices can count; simplify or hide some");
    }
    // Which commands are a slot's: two before they are sorted, found again by where their indices begin.
    sort_commands(all, capacity);
    for (const Group& group : groups_) {
        for (std::size_t c = group.first; c < group.first + group.count; ++c) {
            const std::uint32_t instance = drawn_[c].base_instance;
            gpu::VolumeSlot& data = slots[slot_of_instance_.at(instance)];
            (group.clockwise == gpu_scene.mirrored(instance) ? data.wound_command : data.flipped_command) =
                static_cast<std::uint32_t>(c);
        }
    }
    commands_.replace(std::span<const DrawCommand>{drawn_});
    if (indices_.bytes() < capacity * sizeof(std::uint32_t)) {
        indices_ = StorageBuffer();
        indices_ = StorageBuffer(capacity * sizeof(std::uint32_t), "volume indices");
    }
    read_back_ = false;
    if (jobs.empty()) {
        return;
    }
    device_slots_ = StorageBuffer::from(slots, "volume slots");
    jobs_ = StorageBuffer::from(jobs, "volume jobs");
    adjacency.bind();
    device_slots_.bind_storage(0);
    jobs_.bind_storage(1);
    commands_.bind_storage(2);
    indices_.bind_storage(3);
    const Program& program = frame.device().programs.get({"passes/volume_indices.comp"},
                                                         {{"GROUP_SIZE", std::to_string(kVolumeGroupSize) + "u"}});
    program.set("job_count", static_cast<unsigned>(jobs.size()));
    program.use();
    dispatch_groups(jobs.size());
    StorageBuffer::barrier();
}

void VolumePass::read_back() {
    if (!read_back_) {
        drawn_ = commands_.read<DrawCommand>();
        found_indices_ = indices_.read<std::uint32_t>();
        read_back_ = true;
    }
}

std::uint64_t VolumePass::triangle_count() {
    read_back();
    std::uint64_t count = 0;
    for (const DrawCommand& command : drawn_) {
        count += command.count / 3;
    }
    return count;
}

void VolumePass::bound_layers(const Frame& frame, const glm::dvec4& light_ws) {
    const GpuScene& gpu_scene = frame.gpu_scene();
    // A large ground of two triangles must not take the resolution from what may nest.
    constexpr std::size_t kMany = 64;
    std::vector<Bounds> boxes;
    for (std::size_t i = 0; i < slots_.size(); ++i) {
        if (meshes_[slots_[i].mesh]->triangles.size() >= kMany) {
            boxes.push_back(frame.summary().caster_bounds_ws[i]);
        }
    }
    LayerBound bound{light_ws, boxes.empty() ? frame.summary().caster_bounds_ws : boxes};
    std::vector<glm::dvec3> placed;
    std::uint32_t first_shell = 0;
    for (std::size_t i = 0; i < slots_.size(); ++i) {
        const Mesh& mesh = *meshes_[slots_[i].mesh];
        const glm::dmat4& m = gpu_scene.world_from_recentred(slots_[i].instance);
        const glm::dvec3 centre = gpu_scene.mesh_ranges()[slots_[i].mesh].centre_local;
        placed.clear();
        for (const glm::vec3& p : mesh.positions_local) {
            placed.emplace_back(m * glm::dvec4{glm::dvec3{p} - centre, 1.0});
        }
        VolumeMaker& maker = *makers_.at(slots_[i].mesh);
        maker.face(local_light(m, centre, light_ws));
        // With all triangles a ray enters and leaves a convex shell: two of them.
        const std::vector<std::uint32_t>& shell = maker.closure().convex_shell;
        const bool single = !shell.empty() && faces_[i] != VolumeFaces::All;
        maker.for_triangles(faces_[i], [&](std::uint32_t t) {
            const glm::uvec3& v = mesh.triangles[t];
            bound.add(placed[v.x], placed[v.y], placed[v.z], single && shell[t] != 0 ? first_shell + shell[t] : 0);
        });
        first_shell += static_cast<std::uint32_t>(mesh.triangles.size());
    }
    most_layers_ = std::min<std::uint64_t>(most_layers_, bound.most());
}

}  // namespace penumbra
