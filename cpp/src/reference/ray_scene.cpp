#include "reference/ray_scene.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <unordered_map>

#include "base/parallel.h"
#include "reference/embree_library.h"
#include "scene/bounds.h"

namespace penumbra {
namespace {

/// Vertices per piece of parallel work: about a tenth of a millisecond.
constexpr std::int64_t kVertexGrain = 16384;

/// Rays enter an instance's space by a float32 matrix, which multiplies their rounding by the matrix' condition. Up to
/// this factor the offsets of receivers.cpp have room; beyond it the mesh is flattened in float64 instead.
constexpr double kLargestCondition = 4.0;

/// At least 2^-100, so that float32 holds its inverse.
double power_of_two_above(double length) noexcept {
    return length > 0.0 ? std::exp2(std::max(-100.0, std::ceil(std::log2(length)))) : 1.0;
}

double largest(const glm::dvec3& v) noexcept {
    return std::max({std::abs(v.x), std::abs(v.y), std::abs(v.z)});
}
float largest(const glm::vec3& v) noexcept {
    return std::max({std::abs(v.x), std::abs(v.y), std::abs(v.z)});
}

double frobenius(const glm::dmat3& m) noexcept {
    return std::sqrt(glm::dot(m[0], m[0]) + glm::dot(m[1], m[1]) + glm::dot(m[2], m[2]));
}

/// 1 for a rotation with uniform scale, larger the more a matrix shears or squeezes.
double condition(const glm::dmat3& m) noexcept {
    return frobenius(m) * frobenius(glm::inverse(m)) / 3.0;
}

/// An affine map of points, applied in float64.
struct Affine {
    glm::dmat3 linear{1.0};
    glm::dvec3 offset{0.0};
};

std::vector<glm::vec3> transformed(const std::vector<glm::vec3>& positions, const Affine& map, Control& control) {
    std::vector<glm::vec3> result(positions.size());
    parallel_for(
        static_cast<std::int64_t>(positions.size()), kVertexGrain,
        [&](std::int64_t begin, std::int64_t end) {
            for (std::int64_t i = begin; i < end; ++i) {
                result[i] = glm::vec3(map.linear * glm::dvec3(positions[i]) + map.offset);
            }
        },
        control);
    return result;
}

std::vector<float> reach_per_triangle(const Mesh& mesh, const std::vector<glm::vec3>& positions_an) {
    std::vector<float> reach;
    reach.reserve(mesh.triangles.size());
    for (const glm::uvec3& t : mesh.triangles) {
        reach.push_back(std::max({largest(positions_an[t.x]), largest(positions_an[t.y]), largest(positions_an[t.z])}));
    }
    return reach;
}

/// Copies a mesh into Embree's own buffers. @throws OutOfMemory, DeviceError
void attach_mesh(const embree::Table& table, embree::Device* device, embree::Scene* scene, const Mesh& mesh,
                 const std::vector<glm::vec3>& positions) {
    const embree::TriangleBuffers buffers = table.new_triangles(device, positions.size(), mesh.triangles.size());
    if (buffers.geometry == nullptr) {
        embree::throw_if_failed("copying the meshes");
        throw DeviceError("ray tracing: Embree gave no buffers for mesh \"" + mesh.name + "\"");
    }
    static_assert(sizeof(glm::vec3) == 3 * sizeof(float) && sizeof(glm::uvec3) == 3 * sizeof(std::uint32_t));
    std::memcpy(buffers.positions, positions.data(), positions.size() * sizeof(glm::vec3));
    std::memcpy(buffers.indices, mesh.triangles.data(), mesh.triangles.size() * sizeof(glm::uvec3));
    table.attach_triangles(scene, buffers.geometry);
}

}  // namespace

void RayScene::Release::operator()(embree::Scene* scene) const noexcept {
    embree::library().release_scene(scene);
}

RayScene::ScenePtr RayScene::new_scene() const {
    ScenePtr scene{table_->new_scene(device_)};
    if (scene == nullptr) {
        embree::throw_if_failed("making a scene");
    }
    return scene;
}

void RayScene::commit(embree::Scene* scene, Control& control) const {
    table_->commit(
        scene, [](void* user) { return !static_cast<const Control*>(user)->cancelled(); }, &control);
    control.check();
    embree::throw_if_failed("building the acceleration structure");
}

RayScene::RayScene(const Scene& scene, Control& control, RayTargets targets)
    : table_{&embree::library()}, device_{embree::device()}, reach_(scene.instances.size()) {
    const Bounds bounds = bounds_of(scene);
    frame_.origin_ws = bounds.centre();
    frame_.unit_m = power_of_two_above(largest(bounds.half_size()));
    top_ = new_scene();

    std::unordered_map<const Mesh*, int> met_uses;
    std::unordered_map<const Mesh*, int> uses;
    for (const Instance& instance : scene.instances) {
        met_uses[instance.mesh.get()] += is_target(instance, targets) ? 1 : 0;
        ++uses[instance.mesh.get()];
    }

    // A shared mesh in the frame of its own box, again within +-1.
    struct Child {
        embree::Scene* scene;
        glm::dvec3 centre;
        double unit;
    };
    std::unordered_map<const Mesh*, Child> children;
    const auto child_of = [&](const Mesh& mesh) -> const Child& {
        const auto found = children.find(&mesh);
        if (found != children.end()) {
            return found->second;
        }
        const Bounds local = bounds_of(mesh);
        const double unit = power_of_two_above(largest(local.half_size()));
        shared_.push_back(new_scene());
        const Affine map{glm::dmat3(1.0 / unit), local.centre() * (-1.0 / unit)};
        attach_mesh(*table_, device_, shared_.back().get(), mesh, transformed(mesh.positions_local, map, control));
        commit(shared_.back().get(), control);
        triangle_count_ += mesh.triangles.size();
        return children.emplace(&mesh, Child{shared_.back().get(), local.centre(), unit}).first->second;
    };

    for (std::size_t i = 0; i < scene.instances.size(); ++i) {
        control.check();
        const Instance& instance = scene.instances[i];
        const Mesh& mesh = *instance.mesh;
        if (mesh.triangles.empty()) {
            continue;
        }
        const double per_unit = 1.0 / frame_.unit_m;
        const glm::dmat3 linear = glm::dmat3(instance.world_from_local) * per_unit;
        const glm::dvec3 offset = (glm::dvec3(instance.world_from_local[3]) - frame_.origin_ws) * per_unit;

        const bool is_met = is_target(instance, targets);
        const bool as_instance = is_met && met_uses[&mesh] > 1 && condition(linear) <= kLargestCondition;
        if (as_instance) {
            const Child& child = child_of(mesh);
            const glm::mat3 axes{linear * child.unit};
            const glm::vec3 origin{linear * child.centre + offset};
            const std::array matrix{axes[0].x, axes[0].y, axes[0].z, axes[1].x, axes[1].y, axes[1].z,
                                    axes[2].x, axes[2].y, axes[2].z, origin.x,  origin.y,  origin.z};
            table_->attach_instance(device_, top_.get(), child.scene, matrix.data());
            ++instanced_count_;
            // Child coordinates lie within +-1, so no vertex is farther than this.
            reach_[i].all = largest(origin) + largest(axes[0]) + largest(axes[1]) + largest(axes[2]);
        } else {
            const std::vector<glm::vec3> positions_an =
                transformed(mesh.positions_local, Affine{linear, offset}, control);
            std::vector<float> reach = reach_per_triangle(mesh, positions_an);
            reach_[i].all = std::ranges::max(reach);
            if (uses[&mesh] == 1) {
                reach_[i].per_triangle = std::move(reach);
            }
            if (is_met) {
                attach_mesh(*table_, device_, top_.get(), mesh, positions_an);
                triangle_count_ += mesh.triangles.size();
            }
        }
        if (is_met) {
            instance_of_.push_back(static_cast<std::uint32_t>(i));
        }
        empty_ = empty_ && !is_met;
    }
    embree::throw_if_failed("collecting the instances");
    commit(top_.get(), control);
}

}  // namespace penumbra
