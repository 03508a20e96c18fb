#include "geometry/seen_surfaces.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <utility>
#include <vector>

#include "base/assert.h"
#include "base/parallel.h"
#include "geometry/pixel_rays.h"

namespace penumbra {
namespace {

constexpr std::int64_t kRowsPerPiece = 8;

/// A placed triangle, world axes, relative to the eye.
struct Corners {
    glm::dvec3 a, b, c;
};

/// Instances' transforms relative to the eye, composed once.
class PlacedInstances {
public:
    PlacedInstances(const Scene& scene, const glm::dvec3& eye_ws) : scene_{scene} {
        from_local_.reserve(scene.instances.size());
        for (const Instance& instance : scene.instances) {
            glm::dmat4 m = instance.world_from_local;
            m[3] -= glm::dvec4{eye_ws, 0.0};
            from_local_.push_back(m);
        }
    }
    [[nodiscard]] Corners corners(std::uint32_t instance, std::uint32_t triangle) const {
        const Mesh& mesh = *scene_.instances[instance].mesh;
        const glm::uvec3 t = mesh.triangles[triangle];
        const glm::dmat4& m = from_local_[instance];
        const auto place = [&](std::uint32_t vertex) {
            return glm::dvec3{m * glm::dvec4{glm::dvec3{mesh.positions_local[vertex]}, 1.0}};
        };
        return {place(t.x), place(t.y), place(t.z)};
    }

private:
    const Scene& scene_;
    std::vector<glm::dmat4> from_local_;
};

/// The plane of a triangle, with all that its pixels have in common.
struct Facet {
    glm::dvec3 a{0.0}, normal{0.0};  ///< unit
    glm::dvec3 low{0.0}, high{0.0};  ///< its box
    bool is_surface = false;

    Facet() = default;
    explicit Facet(const Corners& corners)
        : a{corners.a},
          low{glm::min(glm::min(corners.a, corners.b), corners.c)},
          high{glm::max(glm::max(corners.a, corners.b), corners.c)} {
        const glm::dvec3 n = glm::cross(corners.b - corners.a, corners.c - corners.a);
        const double area = glm::length(n);
        is_surface = area > 0.0;
        normal = is_surface ? n / area : n;
    }
};

/// @return unit, turned to the side of `geometric`
glm::vec3 smooth_normal(const Instance& instance, std::uint32_t triangle, const Corners& corners,
                        const glm::dvec3& position, const glm::vec3& geometric) {
    const std::vector<glm::vec3>& normals = instance.mesh->corner_normals_local;
    // Barycentric coordinates from the three sub-areas.
    const glm::dvec3 ab = corners.b - corners.a;
    const glm::dvec3 ac = corners.c - corners.a;
    const glm::dvec3 ap = position - corners.a;
    const glm::dvec3 m = glm::cross(ab, ac);
    const double whole = glm::dot(m, m);
    const double v = glm::dot(m, glm::cross(ap, ac)) / whole;
    const double w = glm::dot(m, glm::cross(ab, ap)) / whole;
    const std::size_t first = std::size_t{3} * triangle;
    const glm::dvec3 local = glm::dvec3{normals[first]} * (1.0 - v - w) + glm::dvec3{normals[first + 1]} * v +
                             glm::dvec3{normals[first + 2]} * w;
    // Normals go with the cofactors of the linear part, also mirrored and sheared.
    const glm::dmat4& t = instance.world_from_local;
    const glm::dvec3 x{t[0]};
    const glm::dvec3 y{t[1]};
    const glm::dvec3 z{t[2]};
    const glm::dvec3 turned = local.x * glm::cross(y, z) + local.y * glm::cross(z, x) + local.z * glm::cross(x, y);
    const double size = glm::length(turned);
    if (!(size > 0.0)) {
        return geometric;
    }
    return glm::vec3{glm::dot(turned, glm::dvec3{geometric}) < 0.0 ? -turned / size : turned / size};
}

void for_rows(int height, const std::function<void(int)>& work, Control& control) {
    parallel_for(
        height, kRowsPerPiece,
        [&](std::int64_t begin, std::int64_t end) {
            for (auto y = static_cast<int>(begin); y < static_cast<int>(end); ++y) {
                work(y);
            }
        },
        control);
}

}  // namespace

View place_surfaces(const Scene& scene, std::span<const glm::uvec2> seen, Control& control, View spare) {
    const Camera& camera = scene.camera;
    View view = std::move(spare);
    view.shading_normal_ws.clear();
    view.albedo.clear();
    view.width = camera.width_px;
    view.height = camera.height_px;
    view.eye_ws = glm::dvec3{camera.world_from_camera[3]};
    PENUMBRA_ASSERT(seen.size() == view.size());
    view.position_cr.resize(seen.size());
    view.normal_ws.resize(seen.size());
    view.instance.resize(seen.size());
    view.triangle.resize(seen.size());
    const PlacedInstances placed{scene, view.eye_ws};
    const PixelRays rays{camera};
    const auto place_row = [&](int y) {
        const glm::dvec3 row = rays.row(y);
        std::size_t i = static_cast<std::size_t>(y) * static_cast<std::size_t>(view.width);
        glm::uvec2 last{0U};
        Facet facet;  // neighbours mostly share it
        for (int x = 0; x < view.width; ++x, ++i) {
            const glm::uvec2 ids = seen[i];
            if (ids != last) {
                last = ids;
                facet = ids.x > 0 ? Facet{placed.corners(ids.x - 1, ids.y)} : Facet{};
            }
            if (!facet.is_surface) {
                view.position_cr[i] = view.normal_ws[i] = glm::vec3{0.0F};
                view.instance[i] = view.triangle[i] = -1;
                continue;
            }
            const PixelRays::Ray ray = rays.at(row, x);
            const double along = glm::dot(facet.normal, ray.along);
            // A triangle seen edge-on has no well placed intersection: stay within its box.
            const double distance = glm::dot(facet.normal, facet.a - ray.origin) / along;
            const double t = std::isfinite(distance) ? distance : 0.0;
            view.position_cr[i] = glm::vec3{glm::clamp(ray.origin + t * ray.along, facet.low, facet.high)};
            view.normal_ws[i] = glm::vec3{along > 0.0 ? -facet.normal : facet.normal};
            view.instance[i] = static_cast<std::int32_t>(ids.x) - 1;
            view.triangle[i] = static_cast<std::int32_t>(ids.y);
        }
    };
    for_rows(view.height, place_row, control);
    return view;
}

void shade_surfaces(const Scene& scene, View& view, Control& control) {
    if (view.shading_normal_ws.size() == view.size() && view.albedo.size() == view.size()) {
        return;
    }
    std::vector<glm::vec3> normals(view.size(), glm::vec3{0.0F});
    std::vector<glm::vec3> albedo(view.size(), glm::vec3{0.0F});
    const PlacedInstances placed{scene, view.eye_ws};
    const auto shade_row = [&](int y) {
        for (std::size_t i = static_cast<std::size_t>(y) * static_cast<std::size_t>(view.width), x = 0;
             x < static_cast<std::size_t>(view.width); ++x, ++i) {
            if (!view.hit(i)) {
                continue;
            }
            const auto number = static_cast<std::uint32_t>(view.instance[i]);
            const auto triangle = static_cast<std::uint32_t>(view.triangle[i]);
            const Instance& instance = scene.instances[number];
            normals[i] = instance.mesh->corner_normals_local.empty()
                             ? view.normal_ws[i]
                             : smooth_normal(instance, triangle, placed.corners(number, triangle),
                                             glm::dvec3{view.position_cr[i]}, view.normal_ws[i]);
            const std::vector<std::uint16_t>& slots = instance.mesh->triangle_material;
            const std::size_t slot = slots.empty() ? 0 : slots[triangle];
            albedo[i] = instance.albedo[std::min(slot, instance.albedo.size() - 1)];
        }
    };
    for_rows(view.height, shade_row, control);
    view.shading_normal_ws = std::move(normals);
    view.albedo = std::move(albedo);
}

}  // namespace penumbra
