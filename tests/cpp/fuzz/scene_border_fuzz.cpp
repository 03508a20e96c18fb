// Any bytes are a scene (scene_bytes.h): it is refused in one sentence, or everything that needs no OpenGL is done to
// it and holds what it promises. libFuzzer looks for bytes that break it (tools/fuzz); corpus_test.cpp replays those
// kept.

#include <cmath>
#include <cstdint>
#include <glm/gtc/matrix_inverse.hpp>
#include <stdexcept>
#include <utility>

#include "fuzz/scene_bytes.h"
#include "geometry/adjacency.h"
#include "geometry/cone_base.h"
#include "geometry/layer_bound.h"
#include "geometry/light_plane.h"
#include "geometry/light_region.h"
#include "geometry/light_shape.h"
#include "geometry/radiometry.h"
#include "geometry/region_silhouettes.h"
#include "geometry/shadow_volume.h"
#include "geometry/silhouettes.h"
#include "geometry/simplify.h"
#include "geometry/smoothie.h"
#include "penumbra/control.h"
#include "penumbra/error.h"
#include "penumbra/reference.h"
#include "scene/bounds.h"
#include "scene/digest.h"

namespace penumbra::fuzz {

namespace {

void require(bool holds, const char* what) {
    if (!holds) {
        throw std::logic_error{what};
    }
}

void require_sentence(const Error& refusal) {
    const std::string text = refusal.what();
    require(text.size() > 8 && text.find('\n') == std::string::npos, "a refusal is one sentence");
}

SettingInfo setting(const char* id, SettingValue value, double minimum = 0.0, double maximum = 0.0) {
    SettingInfo info;
    info.id = id;
    info.default_value = std::move(value);
    info.minimum = minimum;
    info.maximum = maximum;
    return info;
}

const std::vector<SettingInfo>& setting_infos() {
    static const std::vector<SettingInfo> infos = [] {
        std::vector<SettingInfo> all{setting("size", 64, 16, 16384), setting("scale", 1.0, 0.0, 100.0),
                                     setting("mask", true), setting("bias", std::string{"slope"}),
                                     setting("plane", std::string{"auto"})};
        all[3].choices = {"none", "slope"};
        return all;
    }();
    return infos;
}

void check_settings(const Settings& given) {
    try {
        const Settings all = complete("technique", setting_infos(), given);
        require(all.size() == setting_infos().size(), "every setting has a value");
        require(get_int(all, "size") >= 16 && get_int(all, "size") <= 16384, "a value in its range");
        require(get_double(all, "scale") >= 0.0 && get_double(all, "scale") <= 100.0, "a value in its range");
    } catch (const InvalidSettings& refusal) {
        require_sentence(refusal);
    }
}

/// Positions of point lights, and the direction of suns, as the mesh sees them: w 1 and 0.
glm::dvec4 light_in(const Instance& instance, const Light& light) {
    const glm::dvec4 light_ws =
        light.kind == LightKind::Sun ? glm::dvec4{-light.direction_ws, 0.0} : glm::dvec4{light.position_ws, 1.0};
    return glm::inverse(instance.world_from_local) * light_ws;
}

void check_silhouettes(const Mesh& mesh, const Adjacency& adjacency, const glm::dvec4& light_local) {
    FlatSilhouettes flat{mesh, adjacency};
    for (const EdgeChoice choice : {EdgeChoice::Silhouettes, EdgeChoice::LightFacing, EdgeChoice::All}) {
        std::vector<SilhouetteEdge> found;
        flat.find(light_local, false, choice, found);
        std::vector<SilhouetteEdge> expected = find_silhouettes(mesh, adjacency, light_local, false, choice);
        std::ranges::sort(found);
        std::ranges::sort(expected);
        require(found == expected, "both ways to silhouettes find the same");
        for (const SilhouetteEdge& edge : found) {
            require(edge.a < mesh.positions_local.size() && edge.b < mesh.positions_local.size(), "edges of vertices");
        }
    }
}

void check_volume(const Mesh& mesh, const Adjacency& adjacency, const glm::dvec4& light_local) {
    VolumeMaker maker{mesh, adjacency};
    for (const VolumeFaces faces : {VolumeFaces::Towards, VolumeFaces::Averted, VolumeFaces::All}) {
        VolumeIndices indices;
        maker.append(light_local, faces, {}, 5, indices);
        require(indices.wound.size() % 3 == 0 && indices.flipped.size() % 3 == 0, "volumes are triangles");
        static_cast<void>(count_crossings(mesh, light_local, {0.1, 0.2, 0.3}, faces));
        require(most_sides(adjacency, faces) <= 4 * 3 * mesh.triangles.size(), "as many sides as edges run");
    }
    static_cast<void>(volume_faces(maker.closure(), mesh, maker.bounds_local(), light_local));
}

void check_mesh(const Scene& scene, const Instance& instance, bool wild) {
    const Mesh& mesh = *instance.mesh;
    const Adjacency adjacency = make_adjacency(mesh);
    require(adjacency.triangle_edges.size() == mesh.triangles.size(), "an entry per triangle");
    for (const glm::uvec3& edges : adjacency.triangle_edges) {
        for (int k = 0; k < 3; ++k) {
            require(edges[k] == Adjacency::kNone || edges[k] < adjacency.edges.size(), "edges that there are");
        }
    }
    const Closure closure = closure_of(mesh, adjacency);
    require(!adjacency.closed_manifold() || mesh.triangles.empty() || closure.shells > 0 || adjacency.edges.empty(),
            "what is closed has a shell");
    const double winding = winding_number(mesh, {0.1, 0.2, 0.3});
    require(wild || std::isfinite(winding), "a winding number");
    for (const Light& light : scene.lights) {
        const glm::dvec4 light_local = light_in(instance, light);
        check_silhouettes(mesh, adjacency, light_local);
        check_volume(mesh, adjacency, light_local);
        std::vector<std::uint32_t> found;
        find_region_silhouettes(mesh, adjacency, light_region(light).in(glm::inverse(instance.world_from_local)),
                                found);
        for (const std::uint32_t edge : found) {
            require(edge < adjacency.edges.size(), "region silhouettes are edges");
        }
    }
    const SimplifiedMesh simple = simplify(instance.mesh, mesh.triangles.size() / 2);
    require(simple.mesh->triangles.size() <= mesh.triangles.size(), "simpler is not more");
    validate(*simple.mesh);
}

void check_bounds(const Scene& scene) {
    const Bounds whole = bounds_of(scene);
    for (const Instance& instance : scene.instances) {
        const Bounds bounds = bounds_of(instance);
        require(bounds.empty() ||
                    (std::isfinite(bounds.radius()) && whole.low.x <= bounds.low.x && whole.high.z >= bounds.high.z),
                "the scene's bounds hold its instances");
    }
}

void check_light(const Scene& scene, const Light& light, bool wild) {
    const double area = emitting_area(light);
    require(wild || (std::isfinite(area) && area >= 0.0), "an area");
    static_cast<void>(longest_half_axis(light));
    static_cast<void>(has_no_extent(light));
    const glm::dvec3 e = unshadowed_irradiance(light, {0.25, 0.5, 0.0}, {0.0, 0.0, 1.0});
    require(wild || (std::isfinite(e.x) && std::isfinite(e.y) && std::isfinite(e.z)), "an irradiance");
    for (const ConeShape shape : {ConeShape::Disc, ConeShape::Sphere, ConeShape::Light}) {
        const double support = cone_base(light, shape, glm::dmat3{1.0}).support({0.6, 0.8});
        require(wild || std::isfinite(support), "a cone's base");
    }
    const double width = LightExtent::of(light, glm::dmat3{1.0}).half_width({0.6, 0.8});
    require(wild || (std::isfinite(width) && width >= 0.0), "a width");
    static_cast<void>(ellipse_as_polygon(light, light.position_ws));

    std::vector<Bounds> bounds;
    for (const Instance& instance : scene.instances) {
        bounds.push_back(bounds_of(instance));
    }
    LayerBound layers{
        light.kind == LightKind::Sun ? glm::dvec4{-light.direction_ws, 0.0} : glm::dvec4{light.position_ws, 1.0},
        bounds};
    std::size_t added = 0;
    for (const Instance& instance : scene.instances) {
        for (const glm::uvec3& t : instance.mesh->triangles) {
            const auto corner = [&](std::uint32_t v) {
                return glm::dvec3{instance.world_from_local *
                                  glm::dvec4{glm::dvec3{instance.mesh->positions_local[v]}, 1.0}};
            };
            layers.add(corner(t.x), corner(t.y), corner(t.z));
            ++added;
        }
    }
    require(layers.most() <= added, "no more layers than triangles");
}

void check_exact_visibility(const Scene& scene, const Light& light) {
    const std::vector<glm::dvec3> points{{0.25, 0.5, 0.0}, {0.0, 0.0, 0.0}, {-1.0, 2.0, 1.0}, light.position_ws};
    const std::vector<glm::dvec3> normals(points.size(), glm::dvec3{0.0, 0.0, 1.0});
    Control control;
    try {
        const ExactResult found = exact_visibility(scene, light, points, normals, control);
        for (std::size_t i = 0; i < points.size(); ++i) {
            require(found.area[i] >= 0.0 && found.area[i] <= 1.0, "V is a share");
            require(found.irradiance[i] >= 0.0 && found.irradiance[i] <= 1.0, "a ratio is a share");
        }
    } catch (const InvalidScene& refusal) {  // not a polygon, or without area
        require_sentence(refusal);
    }
}

void check(std::span<const std::uint8_t> bytes) {
    SceneBytes source{bytes};
    const bool wild = source.wild();
    check_settings(source.settings(setting_infos()));
    Scene scene = source.scene();
    try {
        validate(scene);
    } catch (const InvalidScene& refusal) {
        require_sentence(refusal);
        return;
    }
    require(scene_digest(scene) == scene_digest(Scene{scene}), "equal scenes have equal digests");
    Scene again = scene;
    validate(again);  // what is valid stays valid
    check_bounds(scene);
    for (const Light& light : scene.lights) {
        check_light(scene, light, wild);
        check_exact_visibility(scene, light);
    }
    for (const Instance& instance : scene.instances) {
        check_mesh(scene, instance, wild);
    }
}

}  // namespace

}  // namespace penumbra::fuzz

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    penumbra::fuzz::check({data, size});
    return 0;
}
