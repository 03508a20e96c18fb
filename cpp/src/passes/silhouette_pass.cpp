#include "passes/silhouette_pass.h"

#include <algorithm>
#include <array>

#include "base/assert.h"
#include "passes/frame.h"
#include "scene/setting_forms.h"

namespace penumbra {

namespace {

constexpr std::uint32_t kGroupSize = 64;
constexpr std::uint32_t kElementsPerJob = 4 * kGroupSize;
constexpr std::uint32_t kMostGroups = 32768;  // in a row; OpenGL promises 65535
constexpr std::size_t kCandidateHeaderBytes = 16;
constexpr GLintptr kGroupsOffset = 4;   // of the second step's indirect dispatch among the candidates
constexpr GLintptr kHeaderBytes = 256;  // the count, then as much as any driver wants storage blocks aligned to

struct DrawCommand {
    std::uint32_t count, instance_count, first, base_instance;
};

static_assert(sizeof(gpu::SilhouetteRecord) == 64);
static_assert(sizeof(gpu::SilhouetteInstance) == sizeof(glm::vec4) * PENUMBRA_INSTANCE_TEXELS);
static_assert(sizeof(gpu::SilhouetteJob) == 16);

/// The light in an instance's recentred space.
glm::dvec4 recentred_light(const glm::dmat4& world_from_recentred, const glm::dvec4& light_ws) {
    // Relative to the instance first: the inverse's own translation would lose digits far from the origin.
    const glm::dvec3 towards = glm::dvec3{light_ws} - light_ws.w * glm::dvec3{world_from_recentred[3]};
    const glm::dvec3 local = glm::inverse(glm::dmat3{world_from_recentred}) * towards;
    return {light_ws.w == 0.0 ? glm::normalize(local) : local, light_ws.w};
}

}  // namespace

void SilhouettePass::prepare(Frame& frame, GpuScene& gpu_scene, GpuAdjacency& adjacency,
                             std::span<const std::uint32_t> instances) {
    on_cpu_ =
        options_.source == Source::Cpu || (options_.source == Source::Auto && frame.device().context.info().software);
    adjacency.update(gpu_scene);
    gpu_scene_ = &gpu_scene;
    adjacency_ = &adjacency;
    slots_.clear();
    instance_data_.clear();
    flat_.clear();
    edge_count_ = 0;
    worst_case_ = 0;
    std::vector<gpu::SilhouetteJob> jobs;
    std::uint64_t elements_total = 0;
    const bool triangles = options_.choice == EdgeChoice::LightFacing;
    for (const std::uint32_t instance : instances) {
        const std::uint32_t mesh = gpu_scene.mesh_of_instance(instance);
        const Adjacency& edges = adjacency.of_mesh(mesh);
        const GpuScene::MeshRange& placed = gpu_scene.mesh_ranges()[mesh];
        const GpuAdjacency::MeshRange& range = adjacency.range(mesh);
        const auto elements = static_cast<std::uint32_t>(triangles ? edges.triangle_edges.size() : edges.edges.size());
        edge_count_ += edges.edges.size();
        worst_case_ += (triangles ? 3ULL : 2ULL) * elements;
        elements_total += elements;
        for (std::uint32_t first = 0; !on_cpu_ && first < elements; first += kElementsPerJob) {
            jobs.push_back({static_cast<std::uint32_t>(slots_.size()),
                            (triangles ? range.first_plane : range.first_edge) + first,
                            std::min(kElementsPerJob, elements - first), range.first_plane});
        }
        gpu::SilhouetteInstance data{};
        data.first_vertex = placed.first_vertex;
        data.first_triangle = placed.first_index / 3;
        data.first_plane = range.first_plane;
        data.first_edge = range.first_edge;
        data.first_more = range.first_more;
        data.id = instance;
        data.mirrored = gpu_scene.mirrored(instance) ? 1 : 0;
        slots_.push_back({instance, mesh});
        instance_data_.push_back(data);
        if (on_cpu_ && !flat_.contains(mesh)) {
            flat_.emplace(mesh, std::make_unique<FlatSilhouettes>(*gpu_scene.meshes()[mesh], edges));
        }
    }
    job_count_ = static_cast<std::uint32_t>(jobs.size());
    if (!on_cpu_) {
        jobs_ = StorageBuffer::from(jobs, "silhouette jobs");
        instances_ = StorageBuffer::from(instance_data_, "silhouette instances");
        candidates_ =
            StorageBuffer(kCandidateHeaderBytes + elements_total * sizeof(glm::uvec2), "silhouette candidates");
        job_texels_ = BufferTexture{GL_RGBA32UI, jobs_, "silhouette jobs"};
        instance_texels_ = BufferTexture{GL_RGBA32UI, instances_, "silhouette instances"};
    }
    commands_ = StorageBuffer(PENUMBRA_MAX_VERTICES_PER_EDGE * sizeof(DrawCommand), "silhouette draws");
    commands_.fill_zero();
    no_attributes_ = VertexArray::create();
    capacity_ = 0;
    make_room(std::min<std::uint64_t>(worst_case_, options_.first_bytes / sizeof(gpu::SilhouetteRecord)));
}

void SilhouettePass::make_room(std::uint64_t records) {
    records = std::max<std::uint64_t>(records, 1);
    if (records > capacity_) {
        capacity_ = 0;
        records_ = StorageBuffer();  // the old one first: both may not fit
        records_ = StorageBuffer(kHeaderBytes + records * sizeof(gpu::SilhouetteRecord), "silhouettes");
        capacity_ = records;
        constexpr std::uint32_t kNothing = 0;
        records_.upload(std::span<const std::uint32_t>{&kNothing, 1});
    }
}

void SilhouettePass::extract(Frame& frame, const glm::dvec4& light_ws, const glm::dvec3& origin_ws) {
    PENUMBRA_ASSERT(gpu_scene_ != nullptr);
    if (on_cpu_) {
        find_on_cpu(light_ws, origin_ws);
    } else {
        send_instances(light_ws, origin_ws);
        find_on_device(frame);
        if (capacity_ < worst_case_) {
            if (const std::uint64_t found = read_count(); found > capacity_) {
                make_room(std::min(worst_case_, found + found / 4));
                find_on_device(frame);
            }
        }
    }
    write_commands(frame);
}

void SilhouettePass::send_instances(const glm::dvec4& light_ws, const glm::dvec3& origin_ws) {
    for (std::size_t i = 0; i < slots_.size(); ++i) {
        gpu::SilhouetteInstance& data = instance_data_[i];
        const FacingFrame& frame = adjacency_->range(slots_[i].mesh).frame;
        glm::dmat4 m = gpu_scene_->world_from_recentred(slots_[i].instance);
        const glm::dvec4 light = recentred_light(m, light_ws);
        m[3] -= glm::dvec4{origin_ws, 0.0};
        for (int row = 0; row < 3; ++row) {
            data.rows[row] = glm::vec4{m[0][row], m[1][row], m[2][row], m[3][row]};
        }
        const glm::dvec4 normalised = frame.light(light);
        data.light = glm::vec4{normalised};
        const glm::dvec4 scaled = normalised.w == 0.0 ? normalised : glm::dvec4{frame.scale * glm::dvec3{light}, 1.0};
        data.light_high = glm::vec4{scaled};
        data.light_low = glm::vec4{glm::vec3{scaled - glm::dvec4{data.light_high}}, static_cast<float>(frame.scale)};
    }
    instances_.replace(std::span<const gpu::SilhouetteInstance>{instance_data_});
}

void SilhouettePass::find_on_device(Frame& frame) {
    constexpr std::uint32_t kNothing = 0;
    records_.upload(std::span<const std::uint32_t>{&kNothing, 1});
    if (job_count_ == 0) {
        return;
    }
    Defines defines{{"GROUP_SIZE", std::to_string(kGroupSize) + "u"},
                    {"MAX_GROUPS", std::to_string(kMostGroups) + "u"}};
    if (options_.choice == EdgeChoice::LightFacing) {
        defines.push_back({"CHOOSE_LIGHT_FACING"});
    } else if (options_.choice == EdgeChoice::All) {
        defines.push_back({"CHOOSE_ALL"});
    }
    const std::array<std::uint32_t, 4> no_candidates{0, 0, 1, 1};  // their count, groups of the second step
    candidates_.upload(std::span<const std::uint32_t>{no_candidates});
    adjacency_->bind();
    instance_texels_.bind(6);
    job_texels_.bind(7);
    candidates_.bind_storage(6);
    records_.bind_storage(7);

    const Program& sift = frame.device().programs.get({"passes/silhouette_sift.comp"}, defines);
    sift.set("job_count", job_count_);
    sift.set("sure_facing", kSureFacing);
    sift.use();
    glDispatchCompute(std::min(job_count_, kMostGroups), (job_count_ + kMostGroups - 1) / kMostGroups, 1);
    StorageBuffer::barrier();

    const Program& decide = frame.device().programs.get({"passes/silhouette_records.comp"}, defines);
    decide.set("capacity", static_cast<unsigned>(capacity_));
    decide.set("sure_facing", kSureFacing);
    decide.set("edge_on", static_cast<float>(kEdgeOn));
    decide.set("most_fan_steps", kMostFanSteps);
    decide.use();
    glBindBuffer(GL_DISPATCH_INDIRECT_BUFFER, candidates_.name());
    glDispatchComputeIndirect(kGroupsOffset);
    StorageBuffer::barrier();
}

void SilhouettePass::find_on_cpu(const glm::dvec4& light_ws, const glm::dvec3& origin_ws) {
    std::vector<SilhouetteEdge>& edges = found_edges_;  // kept, for their memory
    std::vector<gpu::SilhouetteRecord>& records = found_records_;
    records.clear();
    for (const Slot& slot : slots_) {
        const GpuScene::MeshRange& placed = gpu_scene_->mesh_ranges()[slot.mesh];
        const Mesh& mesh = *gpu_scene_->meshes()[slot.mesh];
        glm::dmat4 m = gpu_scene_->world_from_recentred(slot.instance);
        glm::dvec4 light = recentred_light(m, light_ws);
        light += glm::dvec4{light.w * placed.centre_local, 0.0};
        m[3] -= glm::dvec4{origin_ws, 0.0};
        edges.clear();
        flat_.at(slot.mesh)->find(light, gpu_scene_->mirrored(slot.instance), options_.choice, edges);
        const auto place = [&](std::uint32_t v, float w) {
            const glm::dvec3 p{glm::vec3{glm::dvec3{mesh.positions_local[v]} - placed.centre_local}};
            return glm::vec4{glm::vec3{m * glm::dvec4{p, 1.0}}, w};
        };
        for (const SilhouetteEdge& edge : edges) {
            records.push_back({place(edge.a, edge.z != edge.a ? 1.0F : 0.0F),
                               place(edge.b, 0.0F),
                               place(edge.z, 0.0F),
                               {slot.instance, edge.a, edge.b, edge.z}});
        }
    }
    make_room(records.size());
    const auto count = static_cast<std::uint32_t>(records.size());
    records_.upload(std::span<const std::uint32_t>{&count, 1});
    records_.upload(std::span<const gpu::SilhouetteRecord>{records}, kHeaderBytes / sizeof(gpu::SilhouetteRecord));
}

void SilhouettePass::write_commands(Frame& frame) {
    const Program& program = frame.device().programs.get({"passes/silhouette_commands.comp"});
    program.set("capacity", static_cast<unsigned>(capacity_));
    commands_.bind_storage(6);
    records_.bind_storage(7);
    program.use();
    glDispatchCompute(1, 1, 1);
    StorageBuffer::barrier();
}

void SilhouettePass::bind(GLuint binding) const {
    glBindBufferRange(GL_SHADER_STORAGE_BUFFER, binding, records_.name(), kHeaderBytes,
                      static_cast<GLsizeiptr>(capacity_ * sizeof(gpu::SilhouetteRecord)));
}

void SilhouettePass::draw(Frame& frame, GLenum mode, int vertices_per_edge) {
    static_cast<void>(frame);
    PENUMBRA_ASSERT(vertices_per_edge >= 1 && vertices_per_edge <= PENUMBRA_MAX_VERTICES_PER_EDGE);
    glBindVertexArray(no_attributes_.name());
    glBindBuffer(GL_DRAW_INDIRECT_BUFFER, commands_.name());
    glDrawArraysIndirect(mode, buffer_offset(static_cast<std::size_t>(vertices_per_edge - 1) * sizeof(DrawCommand)));
    glBindVertexArray(0);
}

std::uint32_t SilhouettePass::read_count() const {
    std::uint32_t count = 0;
    glMemoryBarrier(GL_BUFFER_UPDATE_BARRIER_BIT);
    glGetNamedBufferSubData(records_.name(), 0, sizeof(count), &count);
    return count;
}

std::vector<gpu::SilhouetteRecord> SilhouettePass::read() const {
    std::vector<gpu::SilhouetteRecord> records(std::min<std::uint64_t>(read_count(), capacity_));
    glGetNamedBufferSubData(records_.name(), kHeaderBytes,
                            static_cast<GLsizeiptr>(records.size() * sizeof(gpu::SilhouetteRecord)), records.data());
    return records;
}

std::size_t SilhouettePass::bytes() const noexcept {
    std::size_t bytes = instances_.bytes() + jobs_.bytes() + candidates_.bytes() + records_.bytes() + commands_.bytes();
    for (const auto& [mesh, flat] : flat_) {
        bytes += flat->bytes();
    }
    return bytes;
}

SettingInfo silhouette_setting() {
    return choice_setting(
        "silhouettes", "Silhouettes found",
        "gpu: by compute shader; cpu: by the processor, then sent; auto: gpu, but cpu where the device "
        "is a software rasteriser. The same edges.",
        {"auto", "gpu", "cpu"});
}

SilhouettePass::Source silhouette_source(const Settings& settings) {
    const std::string& source = get_choice(settings, "silhouettes");
    return source == "gpu"   ? SilhouettePass::Source::Gpu
           : source == "cpu" ? SilhouettePass::Source::Cpu
                             : SilhouettePass::Source::Auto;
}

}  // namespace penumbra
