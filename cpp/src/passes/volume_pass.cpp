#include "passes/volume_pass.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "base/parallel.h"
#include "geometry/layer_bound.h"
#include "passes/frame.h"
#include "passes/tile_list.h"
#include "penumbra/error.h"
#include "scene/setting_forms.h"

namespace penumbra {

namespace {

constexpr std::uint32_t kGroupSize = 64;
/// In an orthographic view what casts from nearer than this share of the farthest receiver's distance to the light
/// casts a shadow that ends before that receiver.
constexpr double kShortest = 1e-4;

/// The light's centre; w = 0: direction towards a sun.
glm::dvec4 centre_of(const Light& light) {
    return light.kind == LightKind::Sun ? glm::dvec4{-light.direction_ws, 0.0} : glm::dvec4{light.position_ws, 1.0};
}

/// In an instance's own space.
glm::dvec4 local_light(const glm::dmat4& world_from_recentred, const glm::dvec3& centre_local,
                       const glm::dvec4& light_ws) {
    // Relative to the instance first: the inverse's own translation would lose digits far from the origin.
    const glm::dvec3 towards = glm::dvec3{light_ws} - light_ws.w * glm::dvec3{world_from_recentred[3]};
    const glm::dvec3 local = glm::inverse(glm::dmat3{world_from_recentred}) * towards;
    return {light_ws.w == 0.0 ? glm::normalize(local) : local + centre_local, light_ws.w};
}

/// Of the light's mask, in pixels: x, y, width, height.
glm::ivec4 rectangle_of(const LightSummary& summary, int width, int height) {
    glm::ivec2 low{width, height};
    glm::ivec2 high{-1};
    for (int y = 0; y < height; ++y) {
        const auto row = summary.mask.begin() + static_cast<std::ptrdiff_t>(y) * width;
        const auto first = std::find(row, row + width, std::uint8_t{1});
        if (first == row + width) {
            continue;
        }
        int last = width - 1;
        while (row[last] == 0) {
            --last;
        }
        low = glm::min(low, glm::ivec2{static_cast<int>(first - row), y});
        high = glm::max(high, glm::ivec2{last, y});
    }
    return high.x < 0 ? glm::ivec4{0} : glm::ivec4{low, high - low + 1};
}

/// Light and eye's near rectangle, as far as they may hide a caster: convex hull of points, open towards a sun.
struct EyeHull {
    std::vector<glm::dvec3> points;
    glm::dvec3 open{0.0};

    [[nodiscard]] bool apart_from(const Bounds& box, const glm::dvec3& axis) const {
        double low = std::numeric_limits<double>::infinity();
        double high = -low;
        for (const glm::dvec3& p : points) {
            low = std::min(low, glm::dot(p, axis));
            high = std::max(high, glm::dot(p, axis));
        }
        const double along = glm::dot(open, axis);
        low = along < 0.0 ? -std::numeric_limits<double>::infinity() : low;
        high = along > 0.0 ? std::numeric_limits<double>::infinity() : high;
        const double middle = glm::dot(box.centre(), axis);
        const double reach = glm::dot(box.half_size(), glm::abs(axis));
        // Rounding of positions relative to the eye must not decide.
        const double slack = 1e-5 * (glm::length(axis) * glm::length(box.centre() - points.front()) + reach);
        return middle - reach > high + slack || middle + reach < low - slack;
    }
};

/// Where volumes end: 0 at infinity; else as far as the light's distance over this (a sun: as a metre over this). All
/// rays of an orthographic camera end in one point at infinity, and float32 cannot clip what is near it: there volumes
/// end beyond the farthest receiver.
double far_share(const LightSummary& summary, const glm::dvec4& light_ws) {
    if (!summary.scene->camera.orthographic || summary.receivers_ws.empty()) {
        return 0.0;
    }
    if (light_ws.w == 0.0) {
        Bounds all = summary.receivers_ws;
        for (const Bounds& caster : summary.caster_bounds_ws) {
            all.add(caster);
        }
        return 1.0 / std::max(4.0 * all.radius(), 1e-20);
    }
    const glm::dvec3 light{light_ws};
    const glm::dvec3 to_middle = summary.receivers_ws.centre() - light;
    const double farthest = glm::length(to_middle) + summary.receivers_ws.radius();
    double nearest = farthest;
    for (std::size_t i = 0; i < summary.casters.size(); ++i) {
        const Bounds& caster = summary.caster_bounds_ws[i];
        if (summary.caster_needed[i] != 0) {
            nearest = std::min(nearest, glm::length(light - glm::clamp(light, caster.low, caster.high)));
        }
    }
    return std::max(0.5 * nearest / std::max(farthest, 1e-20), kShortest);
}

/// One work group per job, in rows that every device allows.
void dispatch_groups(std::size_t jobs) {
    constexpr std::uint32_t kMostGroups = 32768;
    const auto groups = static_cast<std::uint32_t>(jobs);
    glDispatchCompute(std::min(groups, kMostGroups), (groups + kMostGroups - 1) / kMostGroups, 1);
}

}  // namespace

bool eye_is_outside(const Bounds& caster_ws, const Camera& camera, const Light& light) {
    if (camera.orthographic) {
        return false;
    }
    const glm::dvec3 eye_ws{camera.world_from_camera[3]};
    const glm::dvec3 right_ws{camera.world_from_camera[0]};
    const glm::dvec3 up_ws{camera.world_from_camera[1]};
    const glm::dvec3 forward_ws = -glm::dvec3{camera.world_from_camera[2]};
    const double half_width = camera.tan_half_width;
    const double half_height = half_width * camera.height_px * camera.pixel_aspect / camera.width_px;
    const glm::dvec2 middle = 2.0 * half_width * camera.shift;
    EyeHull hull;
    hull.points.push_back(eye_ws);
    for (const double x : {-1.1, 1.1}) {
        for (const double y : {-1.1, 1.1}) {
            hull.points.push_back(eye_ws + camera.near_m * (forward_ws + (middle.x + x * half_width) * right_ws +
                                                            (middle.y + y * half_height) * up_ws));
        }
    }
    const glm::dvec4 light_ws = centre_of(light);
    if (light_ws.w == 0.0) {
        hull.open = glm::dvec3{light_ws};
    } else {
        hull.points.emplace_back(light_ws);
    }
    const glm::dvec3 to_light = light_ws.w == 0.0 ? hull.open : glm::normalize(glm::dvec3{light_ws} - eye_ws);
    std::vector<glm::dvec3> axes{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
    for (int i = 0; i < 3; ++i) {
        for (const glm::dvec3& edge : {to_light, right_ws, up_ws}) {
            axes.push_back(glm::cross(axes[static_cast<std::size_t>(i)], edge));
        }
    }
    // Around the long way from the eye to the light, which is a thin pyramid.
    const glm::dvec3 u = glm::cross(to_light, std::abs(to_light.x) < 0.7 ? glm::dvec3{1, 0, 0} : glm::dvec3{0, 1, 0});
    axes.push_back(to_light);
    axes.push_back(u);
    axes.push_back(glm::cross(to_light, u));
    axes.push_back(forward_ws);
    return std::ranges::any_of(axes, [&](const glm::dvec3& axis) {
        return glm::dot(axis, axis) > 1e-12 && hull.apart_from(caster_ws, glm::normalize(axis));
    });
}

bool VolumePass::needs_no_caps(const LightSummary& summary, std::size_t caster) const {
    // An unseen caster has no surface that its near cap could fall on.
    return options_.leave_out_caps && !summary.keeps("eye-outside-volume") &&
           summary.scene->instances[summary.casters[caster]].visible &&
           eye_is_outside(summary.caster_bounds_ws[caster], summary.scene->camera, *summary.light);
}

bool VolumePass::plan(const LightSummary& summary, std::string_view lookup, Plan& plan) const {
    const LightSummary::Trivial trivial = summary.trivial();
    if (!trivial.reason.empty()) {
        for (const std::string_view step : {std::string_view{"volumes"}, std::string_view{"count"}, lookup}) {
            plan.leave_out(std::string{step}, trivial.rule, trivial.reason);
        }
        return false;
    }
    plan.run("volumes");
    std::size_t without_caps = 0;
    for (std::size_t i = 0; i < summary.casters.size(); ++i) {
        without_caps += needs_no_caps(summary, i) ? 1 : 0;
    }
    if (without_caps > 0) {
        plan.leave_out("caps", "eye-outside-volume",
                       std::to_string(without_caps) + " of " + std::to_string(summary.casters.size()) +
                           " casters lie apart from the space between the light and the eye, so their sides alone are "
                           "counted, in front of what is seen");
    }
    if (summary.casters_outside > 0) {
        plan.leave_out("casters out of reach", "caster-outside-hull",
                       std::to_string(summary.casters_outside) +
                           " casters lie outside the space between the light and the visible receivers");
    }
    plan.run("count");
    plan.run(std::string{lookup});
    return true;
}

void VolumePass::send_vertices(const GpuScene& gpu_scene) {
    if (vertices_ && meshes_ == gpu_scene.meshes()) {
        return;
    }
    makers_.clear();
    meshes_ = gpu_scene.meshes();
    std::vector<glm::vec4> vertices;
    for (std::size_t i = 0; i < meshes_.size(); ++i) {
        if (!gpu_scene.mesh_ranges()[i].sent) {
            continue;
        }
        for (const glm::vec3& p : meshes_[i]->positions_local) {
            const glm::vec3 recentred{glm::dvec3{p} - gpu_scene.mesh_ranges()[i].centre_local};
            vertices.emplace_back(recentred, 1.0F);
            vertices.emplace_back(recentred, 0.0F);
        }
    }
    vertices_ = StorageBuffer::from(vertices, "volume vertices");
}

void VolumePass::prepare(Frame& frame) {
    const GpuScene& gpu_scene = frame.gpu_scene();
    const LightSummary& summary = frame.summary();
    on_cpu_ = options_.source == SilhouettePass::Source::Cpu ||
              (options_.source == SilhouettePass::Source::Auto && frame.device().context.info().software);
    send_vertices(gpu_scene);
    const GpuAdjacency& adjacency = frame.adjacency();
    slots_.clear();
    slot_of_instance_.clear();
    for (std::size_t i = 0; i < summary.casters.size(); ++i) {
        const std::uint32_t instance = summary.casters[i];
        const std::uint32_t mesh = gpu_scene.mesh_of_instance(instance);
        slot_of_instance_[instance] = static_cast<std::uint32_t>(slots_.size());
        slots_.push_back({instance, mesh, needs_no_caps(summary, i)});
        if (!makers_.contains(mesh)) {
            makers_.emplace(mesh, std::make_unique<VolumeMaker>(*meshes_[mesh], adjacency.of_mesh(mesh)));
        }
    }
    std::vector<std::uint32_t> numbers(gpu_scene.instance_count());
    for (std::uint32_t i = 0; i < numbers.size(); ++i) {
        numbers[i] = i;
    }
    instance_numbers_ = StorageBuffer::from(numbers, "instance numbers");
    scissor_ = rectangle_of(summary, frame.view().width, frame.view().height);
    if (!commands_) {
        commands_ = StorageBuffer(sizeof(DrawCommand), "volume draws");
        indices_ = StorageBuffer(sizeof(std::uint32_t), "volume indices");
    }
}

VertexArray VolumePass::make_vertex_array(const StorageBuffer& indices) const {
    VertexArray made = VertexArray::create();
    const GLuint vao = made.name();
    glVertexArrayVertexBuffer(vao, 0, vertices_.name(), 0, sizeof(glm::vec4));
    glVertexArrayAttribFormat(vao, 0, 4, GL_FLOAT, GL_FALSE, 0);
    glVertexArrayAttribBinding(vao, 0, 0);
    glEnableVertexArrayAttrib(vao, 0);
    glVertexArrayVertexBuffer(vao, 1, instance_numbers_.name(), 0, sizeof(std::uint32_t));
    glVertexArrayAttribIFormat(vao, 1, 1, GL_UNSIGNED_INT, 0);
    glVertexArrayAttribBinding(vao, 1, 1);
    glVertexArrayBindingDivisor(vao, 1, 1);
    glEnableVertexArrayAttrib(vao, 1);
    glVertexArrayElementBuffer(vao, indices.name());
    return made;
}

void VolumePass::extract(Frame& frame) {
    const glm::dvec4 light_ws = centre_of(frame.light());
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
        constexpr std::uint32_t kElements = 4 * kGroupSize;
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
    const Program& program =
        frame.device().programs.get({"passes/volume_indices.comp"}, {{"GROUP_SIZE", std::to_string(kGroupSize) + "u"}});
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

void VolumePass::aim_at(const TextureImage& depth_stencil) {
    if (!target_ || target_depth_ != depth_stencil.name()) {
        target_ = RenderTarget{"volume counts"};
        target_.attach_depth(depth_stencil);
        target_depth_ = depth_stencil.name();
        glTextureParameteri(depth_stencil.name(), GL_DEPTH_STENCIL_TEXTURE_MODE, GL_STENCIL_INDEX);
    }
    counted_ = &depth_stencil;
}

void VolumePass::set_uniforms(Frame& frame, const Program& program) {
    const glm::dvec3 eye_ws = frame.summary().eye_ws;
    const glm::dvec4 light_ws = centre_of(frame.light());
    const auto relative = frame.gpu_scene().relative_to(eye_ws);
    instances_.replace(std::span<const gpu::InstanceBlock>{relative});
    instances_.bind_storage(0);
    program.set("far_share", static_cast<float>(far_share(frame.summary(), light_ws)));
    program.set("clip_from_rel", glm::mat4{clip_from_rel(frame.scene().camera)});
    program.set("light_cr", glm::vec4{glm::vec3{glm::dvec3{light_ws} - light_ws.w * eye_ws}, light_ws.w});
}

void VolumePass::issue(const Group& group) {
    glFrontFace(group.clockwise ? GL_CW : GL_CCW);
    glMultiDrawElementsIndirect(GL_TRIANGLES, GL_UNSIGNED_INT, buffer_offset(group.first * sizeof(DrawCommand)),
                                static_cast<GLsizei>(group.count), 0);
}

void VolumePass::draw_under_conditions(const Program& program, std::span<const GLuint> conditions) const {
    for (const Group& group : groups_) {
        set_state(group, program);
        for (std::size_t c = group.first; c < group.first + group.count; ++c) {
            const GLuint query = conditions[slot_of_instance_.at(drawn_[c].base_instance)];
            Group one = group;
            one.first = c;
            one.count = 1;
            if (query != 0) {
                glBeginConditionalRender(query, GL_QUERY_NO_WAIT);
            }
            issue(one);
            if (query != 0) {
                glEndConditionalRender();
            }
        }
    }
}

void VolumePass::set_state(const Group& group, const Program& program) const {
    if (in_image_) {
        // Fragments that fail the z-fail test's comparison, or pass z-pass's.
        glDepthFunc(group.z_pass ? GL_GREATER : GL_LEQUAL);
        program.set("front_adds", group.z_pass ? 1 : -1);
        return;
    }
    glDepthFunc(GL_GREATER);
    glStencilOpSeparate(GL_FRONT, GL_KEEP, group.z_pass ? GL_KEEP : GL_DECR_WRAP,
                        group.z_pass ? GL_INCR_WRAP : GL_KEEP);
    glStencilOpSeparate(GL_BACK, GL_KEEP, group.z_pass ? GL_KEEP : GL_INCR_WRAP, group.z_pass ? GL_DECR_WRAP : GL_KEEP);
}

void VolumePass::sort_into_tiles(Frame& frame, const VolumeMask& mask) {
    const TileGrid& grid = *mask.tiles;
    std::vector<std::uint8_t> hidden(slots_.size(), 0);
    for (std::size_t i = 0; i < mask.conditions.size(); ++i) {
        if (mask.conditions[i] != 0) {
            GLuint passed = 1;
            glGetQueryObjectuiv(mask.conditions[i], GL_QUERY_RESULT, &passed);
            hidden[i] = passed == 0 ? 1 : 0;
        }
    }
    read_back();
    std::vector<std::int32_t> rectangle_of;
    const std::vector<TileRectangle> rectangles = rectangles_of(grid, rectangle_of);
    // Clip positions of all vertices of all slots, as the vertex shader has them but for rounding.
    const GpuScene& gpu_scene = frame.gpu_scene();
    const glm::dvec3 eye_ws = frame.summary().eye_ws;
    const glm::dvec4 light_ws = centre_of(frame.light());
    const glm::dvec4 light{glm::dvec3{light_ws} - light_ws.w * eye_ws, light_ws.w};
    const double share = far_share(frame.summary(), light_ws);
    const glm::dmat4 clip = clip_from_rel(frame.scene().camera);
    std::map<std::uint32_t, std::vector<glm::dvec4>> placed;
    for (const Slot& slot : slots_) {
        glm::dmat4 m = gpu_scene.world_from_recentred(slot.instance);
        m[3] -= glm::dvec4{eye_ws, 0.0};
        const Mesh& mesh = *meshes_[slot.mesh];
        const glm::dvec3 centre = gpu_scene.mesh_ranges()[slot.mesh].centre_local;
        std::vector<glm::dvec4>& positions = placed[slot.instance];
        positions.resize(2 * mesh.positions_local.size());
        for (std::size_t v = 0; v < mesh.positions_local.size(); ++v) {
            const glm::dvec3 p{m * glm::dvec4{glm::dvec3{mesh.positions_local[v]} - centre, 1.0}};
            positions[2 * v] = clip * glm::dvec4{p, 1.0};
            const glm::dvec3 along = light.w * p - glm::dvec3{light};
            positions[2 * v + 1] = clip * glm::dvec4{along + share * (light.w > 0.5 ? glm::dvec3{light} : p), share};
        }
    }
    // Which triangles each rectangle draws, in pieces so that threads share the work.
    struct Piece {
        std::uint32_t command = 0, first = 0, count = 0;
        std::vector<glm::uvec2> pairs;  ///< rectangle, triangle of the index list
    };
    std::vector<Piece> pieces;
    constexpr std::uint32_t kPiece = 2048;
    for (std::uint32_t c = 0; c < drawn_.size(); ++c) {
        const bool drawn = hidden[slot_of_instance_.at(drawn_[c].base_instance)] == 0;
        for (std::uint32_t first = 0; drawn && first < drawn_[c].count / 3; first += kPiece) {
            pieces.push_back({c, first, std::min(kPiece, drawn_[c].count / 3 - first), {}});
        }
    }
    std::vector<std::uint8_t> z_pass(drawn_.size(), 0);
    for (const Group& group : groups_) {
        std::fill_n(z_pass.begin() + static_cast<std::ptrdiff_t>(group.first), group.count, group.z_pass ? 1 : 0);
    }
    const TileWalker all_tiles{grid};
    parallel_for(
        static_cast<std::int64_t>(pieces.size()), 1,
        [&](std::int64_t begin, std::int64_t end) {
            TileWalker walker = all_tiles;  // each thread its own
            std::vector<std::uint32_t> tiles;
            std::vector<std::uint32_t> last(rectangles.size(), 0xffffffffU);
            for (auto i = begin; i < end; ++i) {
                Piece& piece = pieces[static_cast<std::size_t>(i)];
                const DrawCommand& command = drawn_[piece.command];
                const std::vector<glm::dvec4>& positions = placed.at(command.base_instance);
                const std::uint32_t base =
                    2 * gpu_scene.mesh_ranges()[gpu_scene.mesh_of_instance(command.base_instance)].first_vertex;
                std::ranges::fill(last, 0xffffffffU);
                for (std::uint32_t t = piece.first; t < piece.first + piece.count; ++t) {
                    const std::uint32_t* corner = found_indices_.data() + command.first_index + std::size_t{3} * t;
                    tiles.clear();
                    walker.walk(positions[corner[0] - base], positions[corner[1] - base], positions[corner[2] - base],
                                z_pass[piece.command] != 0, tiles);
                    for (const std::uint32_t tile : tiles) {
                        const auto rectangle = static_cast<std::uint32_t>(rectangle_of[tile]);
                        if (last[rectangle] != t) {
                            last[rectangle] = t;
                            piece.pairs.emplace_back(rectangle, command.first_index / 3 + t);
                        }
                    }
                }
            }
        },
        frame.control());

    // By rectangle, then by command, which is the order of the groups.
    std::vector<std::uint32_t> first_of(rectangles.size() + 1, 0);
    for (const Piece& piece : pieces) {
        for (const glm::uvec2& pair : piece.pairs) {
            ++first_of[pair.x + 1];
        }
    }
    for (std::size_t i = 1; i < first_of.size(); ++i) {
        first_of[i] += first_of[i - 1];
    }
    std::vector<std::uint32_t> next(first_of.begin(), first_of.end() - 1);
    std::vector<glm::uvec2> sorted(first_of.back());  // triangle, command
    for (const Piece& piece : pieces) {
        for (const glm::uvec2& pair : piece.pairs) {
            sorted[next[pair.x]++] = {pair.y, piece.command};
        }
    }
    std::vector<std::uint32_t> indices(3 * sorted.size());
    for (std::size_t i = 0; i < sorted.size(); ++i) {
        std::copy_n(found_indices_.begin() + 3 * static_cast<std::ptrdiff_t>(sorted[i].x), 3,
                    indices.begin() + 3 * static_cast<std::ptrdiff_t>(i));
    }
    drawn_in_tiles_ = sorted.size();
    std::vector<std::uint32_t> group_of(drawn_.size(), 0);
    for (std::uint32_t g = 0; g < groups_.size(); ++g) {
        std::fill_n(group_of.begin() + static_cast<std::ptrdiff_t>(groups_[g].first), groups_[g].count, g);
    }
    std::vector<DrawCommand> commands;
    cells_.clear();
    for (std::size_t r = 0; r < rectangles.size(); ++r) {
        if (first_of[r] == first_of[r + 1]) {
            continue;
        }
        constexpr int kTile = TileGrid::kTile_px;
        const TileRectangle& rectangle = rectangles[r];
        Cell cell;
        cell.scissor = {rectangle.column * kTile, rectangle.row * kTile, rectangle.columns * kTile,
                        rectangle.rows * kTile};
        std::uint32_t last_command = 0xffffffffU;
        std::uint32_t last_group = 0xffffffffU;
        for (std::uint32_t i = first_of[r]; i < first_of[r + 1]; ++i) {
            const std::uint32_t command = sorted[i].y;
            if (command != last_command) {
                if (group_of[command] != last_group) {
                    last_group = group_of[command];
                    cell.groups.push_back(groups_[last_group]);
                    cell.groups.back().first = commands.size();
                    cell.groups.back().count = 0;
                }
                ++cell.groups.back().count;
                commands.push_back({0, 1, 3 * i, 0, drawn_[command].base_instance});
                last_command = command;
            }
            commands.back().count += 3;
        }
        cells_.push_back(std::move(cell));
    }
    cell_indices_ = StorageBuffer::from(indices, "volume indices by tiles");
    cell_commands_ = StorageBuffer::from(commands, "volume draws by tiles");
    cell_vertex_array_ = make_vertex_array(cell_indices_);
}

void VolumePass::draw_in_tiles(const Program& program) const {
    glBindVertexArray(cell_vertex_array_.name());
    glBindBuffer(GL_DRAW_INDIRECT_BUFFER, cell_commands_.name());
    for (const Cell& cell : cells_) {
        const glm::ivec2 low = glm::max(glm::ivec2{cell.scissor}, glm::ivec2{scissor_});
        const glm::ivec2 high = glm::min(glm::ivec2{cell.scissor} + glm::ivec2{cell.scissor.z, cell.scissor.w},
                                         glm::ivec2{scissor_} + glm::ivec2{scissor_.z, scissor_.w});
        if (low.x >= high.x || low.y >= high.y) {
            continue;
        }
        glScissor(low.x, low.y, high.x - low.x, high.y - low.y);
        for (const Group& group : cell.groups) {
            set_state(group, program);
            issue(group);
        }
    }
}

/// On the device: the index lists again, without the triangles that no wanted tile needs.
void VolumePass::sift_by_tiles(Frame& frame, const TileList& tiles) {
    std::vector<gpu::VolumeSiftJob> jobs;
    std::vector<DrawCommand> kept = drawn_;
    std::uint64_t room = 0;
    for (const Group& group : groups_) {
        for (std::size_t c = group.first; c < group.first + group.count; ++c) {
            kept[c].count = 0;
            room = std::max<std::uint64_t>(room, std::uint64_t{drawn_[c].first_index} + most_in_command_[c]);
            constexpr std::uint32_t kTriangles = 4 * kGroupSize;
            for (std::uint32_t first = 0; first < most_in_command_[c] / 3; first += kTriangles) {
                jobs.push_back({static_cast<std::uint32_t>(c), first, kTriangles, group.z_pass ? 1U : 0U});
            }
        }
    }
    kept_commands_.replace(std::span<const DrawCommand>{kept});
    if (!kept_indices_ || kept_indices_.bytes() < room * sizeof(std::uint32_t)) {
        kept_indices_ = StorageBuffer();
        kept_indices_ = StorageBuffer(room * sizeof(std::uint32_t), "volume indices in tiles");
    }
    kept_vertex_array_ = make_vertex_array(kept_indices_);
    if (jobs.empty()) {
        return;
    }
    sift_jobs_.replace(std::span<const gpu::VolumeSiftJob>{jobs});
    Defines defines = TileList::defines();
    defines.push_back({"GROUP_SIZE", std::to_string(kGroupSize) + "u"});
    const Program& program = frame.device().programs.get({"passes/volume_sift.comp"}, defines);
    set_uniforms(frame, program);
    program.set("size_px", glm::vec2{static_cast<float>(frame.view().width), static_cast<float>(frame.view().height)});
    program.set("job_count", static_cast<unsigned>(jobs.size()));
    program.use();
    tiles.bind_storage();
    instances_.bind_storage(1);
    vertices_.bind_storage(2);
    sift_jobs_.bind_storage(3);
    indices_.bind_storage(4);
    commands_.bind_storage(5);
    kept_indices_.bind_storage(6);
    kept_commands_.bind_storage(7);
    dispatch_groups(jobs.size());
    StorageBuffer::barrier();
}

std::uint64_t VolumePass::drawn_of_list() const {
    std::uint64_t triangles = 0;
    if (kept_commands_) {
        for (const DrawCommand& command : kept_commands_.read<DrawCommand>()) {
            triangles += command.count / 3;
        }
    }
    return triangles;
}

void VolumePass::count(Frame& frame, const VolumeMask& mask) {
    using Kind = VolumeMask::Kind;
    Defines defines;
    if (in_image_) {
        defines.push_back({"COUNT_IN_IMAGE"});
        counts_.clear(glm::ivec4{0});
        counts_.bind_image(0, GL_READ_WRITE);
    }
    if (mask.kind == Kind::Class) {
        defines.push_back({"MASK_BY_CLASS"});
        mask.classes->bind(1);
    }
    if (mask.tiles != nullptr) {
        sort_into_tiles(frame, mask);
    } else if (mask.tile_list != nullptr) {
        sift_by_tiles(frame, *mask.tile_list);
    }
    const Program& program = frame.device().programs.get({"passes/volume.vert", "passes/volume.frag"}, defines);
    set_uniforms(frame, program);
    if (mask.kind == Kind::Class) {
        program.set("wanted_class", mask.wanted);
    }
    aim_at(mask.kind == Kind::DepthBounds ? *mask.depth_stencil : frame.view_pass().depth_stencil());
    target_.bind();
    program.use();
    const bool by_bit = mask.kind == Kind::Stencil;
    if (!by_bit && !in_image_) {
        const GLint zero = 0;
        glClearNamedFramebufferiv(target_.name(), GL_STENCIL, 0, &zero);
    }
    glClipControl(GL_LOWER_LEFT, GL_ZERO_TO_ONE);
    glEnable(GL_DEPTH_TEST);
    glDepthMask(GL_FALSE);
    glEnable(GL_DEPTH_CLAMP);
    glDisable(GL_CULL_FACE);
    glEnable(GL_SCISSOR_TEST);
    glScissor(scissor_.x, scissor_.y, scissor_.z, scissor_.w);
    const bool sifted = mask.tile_list != nullptr;
    glBindVertexArray((sifted ? kept_vertex_array_ : vertex_array_).name());
    glBindBuffer(GL_DRAW_INDIRECT_BUFFER, (sifted ? kept_commands_ : commands_).name());
    if (!in_image_ || by_bit) {
        glEnable(GL_STENCIL_TEST);
        glStencilFunc(by_bit ? GL_EQUAL : GL_ALWAYS, VolumeMask::kBit, VolumeMask::kBit);
        glStencilMask(in_image_ ? 0 : by_bit ? 0x7F : 0xFF);
    }
    if (mask.kind == Kind::DepthBounds) {
        glEnable(GL_DEPTH_BOUNDS_TEST_EXT);
        glDepthBoundsEXT(std::numeric_limits<float>::min(), 1.0);  // reversed depth: nothing seen is at 0
    }
    if (mask.tiles != nullptr) {
        draw_in_tiles(program);
    } else if (!mask.conditions.empty()) {
        draw_under_conditions(program, mask.conditions);
    } else {
        for (const Group& group : groups_) {
            set_state(group, program);
            issue(group);
        }
    }
    glBindVertexArray(0);
    if (mask.kind == Kind::DepthBounds) {
        glDisable(GL_DEPTH_BOUNDS_TEST_EXT);
    }
    glDisable(GL_STENCIL_TEST);
    glStencilMask(0xFF);
    glStencilOp(GL_KEEP, GL_KEEP, GL_KEEP);
    glStencilFunc(GL_ALWAYS, 0, 0xFF);
    glDisable(GL_SCISSOR_TEST);
    glDisable(GL_DEPTH_CLAMP);
    glDisable(GL_DEPTH_TEST);
    glDepthFunc(GL_GREATER);
    glDepthMask(GL_TRUE);
    glFrontFace(GL_CCW);
    if (in_image_) {
        glMemoryBarrier(GL_TEXTURE_FETCH_BARRIER_BIT);
    }
}

void VolumePass::bind_counts(GLuint unit) const {
    (in_image_ ? counts_ : *counted_).bind(unit);
}

std::vector<std::int32_t> VolumePass::read_counts() const {
    if (in_image_) {
        return counts_.read<std::int32_t>();
    }
    const auto width = static_cast<std::size_t>(counted_->width());
    std::vector<std::uint8_t> stencil(width * static_cast<std::size_t>(counted_->height()));
    glBindFramebuffer(GL_READ_FRAMEBUFFER, target_.name());
    glReadPixels(0, 0, counted_->width(), counted_->height(), GL_STENCIL_INDEX, GL_UNSIGNED_BYTE, stencil.data());
    return {stencil.begin(), stencil.end()};
}

void VolumePass::draw(Frame& frame, const Program& program) {
    set_uniforms(frame, program);
    program.use();
    glEnable(GL_DEPTH_CLAMP);
    glDisable(GL_CULL_FACE);
    glBindVertexArray(vertex_array_.name());
    glBindBuffer(GL_DRAW_INDIRECT_BUFFER, commands_.name());
    for (const Group& group : groups_) {
        issue(group);
    }
    glBindVertexArray(0);
    glDisable(GL_DEPTH_CLAMP);
    glFrontFace(GL_CCW);
}

std::vector<float> VolumePass::read_overdraw(Frame& frame) {
    const TextureImage fragments =
        TextureImage::make_2d(GL_R32F, frame.view().width, frame.view().height, "volume fragments");
    RenderTarget target{"volume fragments"};
    target.attach_colour(0, fragments);
    target.bind();
    target.clear_colour(0, glm::vec4{0.0F});
    glDisable(GL_DEPTH_TEST);
    glEnable(GL_BLEND);
    glBlendEquation(GL_FUNC_ADD);
    glBlendFunc(GL_ONE, GL_ONE);
    draw(frame, frame.device().programs.get({"passes/volume.vert", "passes/volume.frag"}, {{"COUNT_FRAGMENTS"}}));
    glDisable(GL_BLEND);
    return fragments.read<float>();
}

std::size_t VolumePass::bytes() const noexcept {
    std::size_t bytes = vertices_.bytes() + instance_numbers_.bytes() + indices_.bytes() + commands_.bytes() +
                        instances_.bytes() + kept_indices_.bytes() + kept_commands_.bytes() +
                        (counts_ ? counts_.bytes() : 0);
    for (const auto& [mesh, maker] : makers_) {
        bytes += maker->bytes();
    }
    return bytes;
}

std::vector<SettingInfo> volume_settings() {
    return {
        choice_setting("faces", "Triangles of the volumes",
                       "light_facing: those whose front faces the light, right for closed meshes with outward normals; "
                       "all: every triangle, right for whatever mesh; auto: the fewest that are right, mesh by mesh.",
                       {"auto", "light_facing", "all"}),
        choice_setting("counting", "Counting",
                       "stencil: modulo 256 (hybrid: 128); image: 32-bit counts, slower; auto: stencil unless more "
                       "volumes may lie in each other than it can count.",
                       {"auto", "stencil", "image"}),
        silhouette_setting(),
    };
}

VolumePass::Options volume_options(const Settings& settings) {
    VolumePass::Options options;
    options.source = silhouette_source(settings);
    const std::string& faces = get_choice(settings, "faces");
    options.faces = faces == "all"            ? VolumePass::Faces::All
                    : faces == "light_facing" ? VolumePass::Faces::LightFacing
                                              : VolumePass::Faces::Auto;
    const std::string& counting = get_choice(settings, "counting");
    options.counting = counting == "image"     ? VolumePass::Counting::Image
                       : counting == "stencil" ? VolumePass::Counting::Stencil
                                               : VolumePass::Counting::Auto;
    return options;
}

}  // namespace penumbra
