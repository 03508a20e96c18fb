#include "passes/gpu_scene.h"

#include <numeric>
#include <unordered_map>

#include "penumbra/error.h"

namespace penumbra {

namespace {

struct DrawCommand {
    std::uint32_t count, instance_count, first_index;
    std::int32_t base_vertex;
    std::uint32_t base_instance;
};

}  // namespace

bool GpuScene::has_meshes_of(const Scene& scene) const noexcept {
    if (!vertex_array_ || scene.instances.size() != mesh_of_instance_.size()) {
        return false;
    }
    for (std::size_t i = 0; i < mesh_of_instance_.size(); ++i) {
        if (scene.instances[i].mesh != meshes_[mesh_of_instance_[i]]) {
            return false;
        }
    }
    return true;
}

std::vector<std::uint8_t> GpuScene::meshes_needed(const Scene& scene, std::size_t meshes) const {
    std::vector<std::uint8_t> needed(meshes, 0);
    for (std::size_t i = 0; i < mesh_of_instance_.size(); ++i) {
        if (scene.instances[i].visible || scene.instances[i].casts) {
            needed[mesh_of_instance_[i]] = 1;
        }
    }
    return needed;
}

bool GpuScene::update(const Scene& scene) {
    if (has_meshes_of(scene) && meshes_needed(scene, meshes_.size()) == mesh_needed_) {
        place(scene);
        return false;
    }
    std::vector<std::shared_ptr<const Mesh>> meshes;
    std::unordered_map<const Mesh*, std::uint32_t> index_of;
    mesh_of_instance_.clear();
    for (const Instance& instance : scene.instances) {
        const auto [found, is_new] = index_of.emplace(instance.mesh.get(), static_cast<std::uint32_t>(meshes.size()));
        if (is_new) {
            meshes.push_back(instance.mesh);
        }
        mesh_of_instance_.push_back(found->second);
    }
    std::vector<std::uint8_t> needed = meshes_needed(scene, meshes.size());
    const bool geometry_changed = meshes != meshes_ || needed != mesh_needed_ || !vertex_array_;
    vertex_array_ = VertexArray{};  // none, should the device have no room for what follows
    if (geometry_changed) {
        mesh_needed_ = std::move(needed);
        ++revision_;
        meshes_ = std::move(meshes);
        send_geometry();
    }
    place(scene);
    make_vertex_array();
    return geometry_changed;
}

void GpuScene::send_geometry() {
    std::vector<glm::vec3> positions;
    std::vector<std::uint32_t> indices;
    ranges_.clear();
    std::size_t vertex_total = 0;
    std::size_t triangle_total = 0;
    for (std::size_t i = 0; i < meshes_.size(); ++i) {
        if (mesh_needed_[i] != 0) {
            vertex_total += meshes_[i]->positions_local.size();
            triangle_total += meshes_[i]->triangles.size();
        }
    }
    if (vertex_total > 0x7fffffffULL || triangle_total * 3 > 0xffffffffULL) {
        throw InvalidScene("the scene's meshes have " + std::to_string(triangle_total) + " triangles and " +
                           std::to_string(vertex_total) +
                           " vertices together, more than 32-bit indices can count; simplify or hide some");
    }
    positions.reserve(vertex_total);
    indices.reserve(3 * triangle_total);
    for (std::size_t i = 0; i < meshes_.size(); ++i) {
        const auto& mesh = meshes_[i];
        MeshRange range;
        range.first_vertex = static_cast<std::uint32_t>(positions.size());
        range.first_index = static_cast<std::uint32_t>(indices.size());
        range.index_count = static_cast<std::uint32_t>(3 * mesh->triangles.size());
        range.bounds_local = bounds_of(*mesh);
        range.centre_local = range.bounds_local.centre();
        if (mesh_needed_[i] == 0) {
            range.index_count = 0;
            range.sent = false;
            ranges_.push_back(range);
            continue;
        }
        // Vertices far from their mesh's origin would lose digits in every matrix product: recentre them once, exactly.
        for (const glm::vec3& p : mesh->positions_local) {
            positions.emplace_back(glm::dvec3{p} - range.centre_local);
        }
        for (const glm::uvec3& t : mesh->triangles) {
            indices.insert(indices.end(), {t.x, t.y, t.z});
        }
        ranges_.push_back(range);
    }
    positions_ = StorageBuffer::from(positions, "vertex positions");
    indices_ = StorageBuffer::from(indices, "triangle indices");
}

void GpuScene::place(const Scene& scene) {
    world_from_recentred_.clear();
    mirrored_.clear();
    instance_bounds_ws_.clear();
    for (std::size_t i = 0; i < scene.instances.size(); ++i) {
        const Instance& instance = scene.instances[i];
        const MeshRange& range = ranges_[mesh_of_instance_[i]];
        glm::dmat4 matrix = instance.world_from_local;
        matrix[3] = instance.world_from_local * glm::dvec4{range.centre_local, 1.0};
        world_from_recentred_.push_back(matrix);
        mirrored_.push_back(glm::determinant(glm::dmat3{matrix}) < 0.0 ? 1 : 0);
        instance_bounds_ws_.push_back(transformed(range.bounds_local, instance.world_from_local));
    }
}

void GpuScene::make_vertex_array() {
    std::vector<std::uint32_t> numbers(mesh_of_instance_.size());
    std::iota(numbers.begin(), numbers.end(), 0U);
    instance_indices_ = StorageBuffer::from(numbers, "instance indices");
    vertex_array_ = VertexArray::create();
    const GLuint vao = vertex_array_.name();
    glVertexArrayVertexBuffer(vao, 0, positions_.name(), 0, sizeof(glm::vec3));
    glVertexArrayAttribFormat(vao, 0, 3, GL_FLOAT, GL_FALSE, 0);
    glVertexArrayAttribBinding(vao, 0, 0);
    glEnableVertexArrayAttrib(vao, 0);
    glVertexArrayVertexBuffer(vao, 1, instance_indices_.name(), 0, sizeof(std::uint32_t));
    glVertexArrayAttribIFormat(vao, 1, 1, GL_UNSIGNED_INT, 0);
    glVertexArrayAttribBinding(vao, 1, 1);
    glVertexArrayBindingDivisor(vao, 1, 1);
    glEnableVertexArrayAttrib(vao, 1);
    glVertexArrayElementBuffer(vao, indices_.name());
}

std::vector<gpu::InstanceBlock> GpuScene::relative_to(const glm::dvec3& origin_ws) const {
    std::vector<gpu::InstanceBlock> blocks(instance_count());
    for (std::size_t i = 0; i < blocks.size(); ++i) {
        glm::dmat4 m = world_from_recentred_[i];
        m[3] -= glm::dvec4{origin_ws, 0.0};
        for (int row = 0; row < 3; ++row) {
            blocks[i].rows[row] = glm::vec4{m[0][row], m[1][row], m[2][row], m[3][row]};
        }
    }
    return blocks;
}

void GpuScene::draw(std::span<const std::uint32_t> instances, Cull cull) {
    std::vector<DrawCommand> straight;
    std::vector<DrawCommand> mirrored;
    for (const std::uint32_t i : instances) {
        const MeshRange& range = ranges_[mesh_of_instance_[i]];
        if (range.index_count > 0) {
            auto& list = cull != Cull::None && mirrored_[i] != 0 ? mirrored : straight;
            list.push_back({range.index_count, 1, range.first_index, static_cast<std::int32_t>(range.first_vertex), i});
        }
    }
    const std::size_t straight_count = straight.size();
    straight.insert(straight.end(), mirrored.begin(), mirrored.end());
    if (straight.empty()) {
        return;
    }
    commands_.replace(std::span<const DrawCommand>{straight});
    if (cull == Cull::None) {
        glDisable(GL_CULL_FACE);
    } else {
        glEnable(GL_CULL_FACE);
        glCullFace(cull == Cull::Front ? GL_FRONT : GL_BACK);
    }
    glBindVertexArray(vertex_array_.name());
    glBindBuffer(GL_DRAW_INDIRECT_BUFFER, commands_.name());
    const auto issue = [](GLenum front, std::size_t first, std::size_t count) {
        if (count > 0) {
            glFrontFace(front);
            glMultiDrawElementsIndirect(GL_TRIANGLES, GL_UNSIGNED_INT, buffer_offset(first * sizeof(DrawCommand)),
                                        static_cast<GLsizei>(count), 0);
        }
    };
    issue(GL_CCW, 0, straight_count);
    issue(GL_CW, straight_count, straight.size() - straight_count);
    glBindVertexArray(0);
    glDisable(GL_CULL_FACE);
    glFrontFace(GL_CCW);
}

std::size_t GpuScene::memory_bytes() const noexcept {
    return positions_.bytes() + indices_.bytes();
}

}  // namespace penumbra
