#include <algorithm>
#include <bit>
#include <cstddef>
#include <span>
#include <unordered_map>

#include "penumbra/scene.h"
#include "scene/message.h"
#include "scene/normalise.h"
#include "scene/scene_validator.h"

namespace penumbra {

namespace {

using message::is_finite;
using message::refuse;

/// Determinant over the product of the columns' lengths: 1 for a rotation with any scale along the axes, 0 for flat.
constexpr double kSingular = 1e-12;
constexpr int kMaxSize_px = 32768;
/// Beyond this the G-buffer alone passes 16 GiB.
constexpr long long kMaxPixels = 1LL << 28;

bool any_not_finite(std::span<const glm::vec3> values) noexcept {
    // All exponent bits set means infinite or NaN. Or-ing flags keeps the loop free of branches, so it vectorises.
    static_assert(sizeof(glm::vec3) == 3 * sizeof(float));
    constexpr std::uint32_t kExponent = 0x7F800000U;
    std::uint32_t found = 0;
    for (const glm::vec3& value : values) {
        found |= static_cast<std::uint32_t>((std::bit_cast<std::uint32_t>(value.x) & kExponent) == kExponent);
        found |= static_cast<std::uint32_t>((std::bit_cast<std::uint32_t>(value.y) & kExponent) == kExponent);
        found |= static_cast<std::uint32_t>((std::bit_cast<std::uint32_t>(value.z) & kExponent) == kExponent);
    }
    return found != 0;
}

void check_finite(const Mesh& mesh, const char* member, std::span<const glm::vec3> values) {
    if (!any_not_finite(values)) {
        return;
    }
    for (std::size_t i = 0; i < values.size(); ++i) {
        if (!is_finite(glm::dvec3{values[i]})) {
            refuse("mesh \"", mesh.name, "\": ", member, ' ', i, " is ", values[i], "; give finite numbers");
        }
    }
}

void check_indices(const Mesh& mesh) {
    const std::size_t count = mesh.positions_local.size();
    std::uint32_t highest = 0;
    for (const glm::uvec3& triangle : mesh.triangles) {
        highest = std::max({highest, triangle.x, triangle.y, triangle.z});
    }
    if (mesh.triangles.empty() || highest < count) {
        return;
    }
    for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
        for (int corner = 0; corner < 3; ++corner) {
            if (mesh.triangles[i][corner] >= count) {
                refuse("mesh \"", mesh.name, "\": triangle ", i, " uses position ", mesh.triangles[i][corner],
                       ", but there are ", count, "; give indices below that");
            }
        }
    }
}

/// What a position of the mesh can reach along each local axis.
glm::dvec3 reach(const Mesh& mesh) noexcept {
    glm::vec3 most{0.0F};
    for (const glm::vec3& position : mesh.positions_local) {
        most = glm::max(most, glm::abs(position));
    }
    return glm::dvec3{most};
}

void check_transform(const char* what, const std::string& name, const glm::dmat4& matrix) {
    for (int column = 0; column < 4; ++column) {
        for (int row = 0; row < 4; ++row) {
            if (!std::isfinite(matrix[column][row])) {
                refuse(what, " \"", name, "\": transform holds ", matrix[column][row], " in row ", row, ", column ",
                       column, "; give finite numbers");
            }
        }
    }
    const glm::dvec4 last_row{matrix[0][3], matrix[1][3], matrix[2][3], matrix[3][3]};
    if (glm::any(glm::greaterThan(glm::abs(last_row - glm::dvec4{0.0, 0.0, 0.0, 1.0}), glm::dvec4{1e-9}))) {
        refuse(what, " \"", name, "\": transform is not affine, its last row is ", last_row,
               "; give a matrix whose last row is (0, 0, 0, 1)");
    }
    // Each column is brought to unit length before the determinant, so that no scale under- or overflows.
    glm::dmat3 directions{matrix};
    glm::dvec3 lengths{0.0};
    for (int column = 0; column < 3; ++column) {
        const glm::dvec3 axis = glm::abs(directions[column]);
        const double largest = std::max({axis.x, axis.y, axis.z});
        if (largest > 0.0) {
            directions[column] /= largest;
            const double length = glm::length(directions[column]);
            directions[column] /= length;
            lengths[column] = length * largest;
        }
    }
    const double relative = glm::determinant(directions);
    if (std::abs(relative) <= kSingular) {
        refuse(what, " \"", name, "\": transform is singular, its determinant is ", relative,
               " of the product of its column lengths ", lengths,
               "; give it a scale other than 0 in every direction or leave it out");
    }
}

/// @param mesh_reach reach(*instance.mesh)
void check_instance(const Instance& instance, const glm::dvec3& mesh_reach) {
    check_transform("instance", instance.name, instance.world_from_local);
    if (instance.albedo.empty()) {
        refuse("instance \"", instance.name, "\": albedo is empty; give one colour per material slot, at least one");
    }
    for (std::size_t i = 0; i < instance.albedo.size(); ++i) {
        if (!is_finite(glm::dvec3{instance.albedo[i]})) {
            refuse("instance \"", instance.name, "\": albedo ", i, " is ", instance.albedo[i], "; give finite numbers");
        }
    }
    const glm::dmat4& m = instance.world_from_local;
    glm::dvec3 farthest = glm::abs(glm::dvec3{m[3]});
    for (int column = 0; column < 3; ++column) {
        farthest += glm::abs(glm::dvec3{m[column]}) * mesh_reach[column];
    }
    if (!is_finite(farthest) || glm::any(glm::greaterThan(farthest, glm::dvec3{message::kLargest_m}))) {
        refuse("instance \"", instance.name, "\": reaches as far as ", farthest, " m from the origin; keep it within ",
               message::kLargest_m, " m");
    }
}

void check_mesh_given(const Instance& instance) {
    if (instance.mesh == nullptr) {
        refuse("instance \"", instance.name, "\": has no mesh; give one or leave the instance out");
    }
}

void check_range(const Camera& camera, const char* member, double value, double low, double high, const char* unit) {
    if (!(value >= low && value <= high)) {
        refuse("camera \"", camera.name, "\": ", member, " is ", value, "; give a value from ", low, " to ", high,
               unit);
    }
}

/// Takes scale and shear out: the viewing axis keeps its direction, then +y is made perpendicular to it. The side
/// that x points to stays, so a mirrored camera gives a mirrored picture, as in Cycles.
void make_rigid(glm::dmat4& world_from_camera) {
    const auto unit = [](const glm::dvec3& v) {
        const glm::dvec3 size = glm::abs(v);
        return glm::normalize(v / std::max({size.x, size.y, size.z}));
    };
    const glm::dvec3 x_axis{world_from_camera[0]};
    const glm::dvec3 z = unit(glm::dvec3{world_from_camera[2]});
    const glm::dvec3 y_axis = unit(glm::dvec3{world_from_camera[1]});
    const glm::dvec3 y = unit(y_axis - z * glm::dot(z, y_axis));
    const glm::dvec3 right_handed = glm::cross(y, z);
    const glm::dvec3 x = glm::dot(unit(x_axis), right_handed) < 0.0 ? -right_handed : right_handed;
    world_from_camera[0] = glm::dvec4{x, 0.0};
    world_from_camera[1] = glm::dvec4{y, 0.0};
    world_from_camera[2] = glm::dvec4{z, 0.0};
    world_from_camera[3].w = 1.0;
}

}  // namespace

void validate(const Mesh& mesh) {
    check_finite(mesh, "position", mesh.positions_local);
    check_indices(mesh);
    check_finite(mesh, "corner normal", mesh.corner_normals_local);
    const std::size_t triangles = mesh.triangles.size();
    if (!mesh.corner_normals_local.empty() && mesh.corner_normals_local.size() != 3 * triangles) {
        refuse("mesh \"", mesh.name, "\": has ", mesh.corner_normals_local.size(), " corner normals for ", triangles,
               " triangles; give none or ", 3 * triangles);
    }
    if (!mesh.triangle_material.empty() && mesh.triangle_material.size() != triangles) {
        refuse("mesh \"", mesh.name, "\": has ", mesh.triangle_material.size(), " material indices for ", triangles,
               " triangles; give none or ", triangles);
    }
}

void validate(const Instance& instance) {
    check_mesh_given(instance);
    validate(*instance.mesh);
    check_instance(instance, reach(*instance.mesh));
}

void validate(Camera& camera) {
    check_transform("camera", camera.name, camera.world_from_camera);
    const glm::dvec3 position{camera.world_from_camera[3]};
    if (glm::any(glm::greaterThan(glm::abs(position), glm::dvec3{message::kLargest_m}))) {
        refuse("camera \"", camera.name, "\": stands at ", position, "; keep it within ", message::kLargest_m,
               " m of the origin");
    }
    check_range(camera, "tangent of half the angle of view", camera.tan_half_width, 1e-6, 1e6, "");
    check_range(camera, "orthographic half width", camera.half_width_m, 1e-18, message::kLargest_m, " m");
    check_range(camera, "pixel aspect", camera.pixel_aspect, 1e-3, 1e3, "");
    for (int axis = 0; axis < 2; ++axis) {
        check_range(camera, axis == 0 ? "shift x" : "shift y", camera.shift[axis], -1e4, 1e4, " image widths");
        check_range(camera, axis == 0 ? "pixel offset x" : "pixel offset y", camera.pixel_offset[axis], -1e6, 1e6,
                    " px");
    }
    check_range(camera, "near clipping distance", camera.near_m, 1e-18, message::kLargest_m, " m");
    if (!(camera.far_m > camera.near_m && camera.far_m <= message::kLargest_m)) {
        refuse("camera \"", camera.name, "\": far clipping distance is ", camera.far_m, " m with the near one at ",
               camera.near_m, " m; give a greater one, at most ", message::kLargest_m, " m");
    }
    for (const int size : {camera.width_px, camera.height_px}) {
        if (size < 1 || size > kMaxSize_px) {
            refuse("camera \"", camera.name, "\": image is ", camera.width_px, " x ", camera.height_px,
                   " px; give 1 to ", kMaxSize_px, " px a side");
        }
    }
    const long long pixels = static_cast<long long>(camera.width_px) * camera.height_px;
    if (pixels > kMaxPixels) {
        refuse("camera \"", camera.name, "\": image of ", camera.width_px, " x ", camera.height_px, " px has ", pixels,
               " pixels; give at most ", kMaxPixels, " or render it in tiles");
    }
    make_rigid(camera.world_from_camera);
}

void SceneValidator::validate(Scene& scene) {
    std::unordered_map<const Mesh*, Known> met;
    met.reserve(known_.size());
    for (const Instance& instance : scene.instances) {
        check_mesh_given(instance);
        const auto [entry, is_new] = met.try_emplace(instance.mesh.get());
        if (is_new) {
            if (const auto before = known_.find(instance.mesh.get()); before != known_.end()) {
                entry->second = before->second;
            } else {
                penumbra::validate(*instance.mesh);
                entry->second = {instance.mesh, reach(*instance.mesh)};
            }
        }
        check_instance(instance, entry->second.reach);
    }
    for (Light& light : scene.lights) {
        normalise(light);
    }
    penumbra::validate(scene.camera);
    known_ = std::move(met);
}

void validate(Scene& scene) {
    SceneValidator{}.validate(scene);
}

}  // namespace penumbra
