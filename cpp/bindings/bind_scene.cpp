#include <pybind11/stl.h>

#include "arrays.h"
#include "bindings.h"
#include "penumbra/scene.h"
#include "scene/digest.h"
#include "scene/light_names.h"

namespace penumbra::bindings {

namespace {

/// A mesh as Python holds it: every argument is an object of a bound class, so that one check serves them all.
struct PyMesh {
    std::shared_ptr<Mesh> mesh;
};

PyMesh make_mesh(std::string name, const Faithful<float>& positions, const Faithful<std::uint32_t>& triangles,
                 const std::optional<Faithful<float>>& corner_normals,
                 const std::optional<Faithful<std::uint16_t>>& triangle_material) {
    auto mesh = std::make_shared<Mesh>();
    mesh->name = std::move(name);
    mesh->positions_local = vectors_from<glm::vec3, float, 3>(positions, "positions");
    mesh->triangles = vectors_from<glm::uvec3, std::uint32_t, 3>(triangles, "triangles");
    if (corner_normals) {
        mesh->corner_normals_local = vectors_from<glm::vec3, float, 3>(*corner_normals, "corner_normals");
    }
    if (triangle_material) {
        const Array<std::uint16_t>& slots = triangle_material->values;
        if (slots.ndim() != 1) {
            throw InvalidScene("triangle_material has shape " + shape_text(slots) + ", but (m,) is needed");
        }
        mesh->triangle_material.assign(slots.data(), slots.data() + slots.size());
    }
    const py::gil_scoped_release release;
    validate(*mesh);
    return {std::move(mesh)};
}

void add_instance(Scene& scene, std::string name, const PyMesh& mesh, const Faithful<double>& world_from_local,
                  const Faithful<float>& albedo, bool casts, bool receives, bool visible) {
    Instance instance;
    instance.name = std::move(name);
    instance.mesh = mesh.mesh;
    instance.world_from_local = matrix_from(world_from_local.values, "world_from_local");
    instance.albedo = vectors_from<glm::vec3, float, 3>(albedo, "albedo");
    instance.casts = casts;
    instance.receives = receives;
    instance.visible = visible;
    // Scene.validate() checks it with the rest: checking the whole mesh for every instance would take minutes where
    // there are thousands of them.
    scene.instances.push_back(std::move(instance));
}

void set_transform(Scene& scene, std::size_t instance, const Faithful<double>& world_from_local) {
    if (instance >= scene.instances.size()) {
        throw InvalidScene("there is no instance " + std::to_string(instance) + "; the scene has " +
                           std::to_string(scene.instances.size()) + ", counted from 0");
    }
    scene.instances[instance].world_from_local = matrix_from(world_from_local.values, "world_from_local");
}

std::uint64_t triangle_count(const Scene& scene) {
    std::uint64_t count = 0;
    for (const Instance& instance : scene.instances) {
        count += instance.mesh->triangles.size();
    }
    return count;
}

template <class Owner>
auto vector_property(glm::dvec3 Owner::*member, const char* name) {
    return std::pair{
        [member](const Owner& owner) {
            const glm::dvec3& v = owner.*member;
            return std::array<double, 3>{v.x, v.y, v.z};
        },
        [member, name](Owner& owner, const std::vector<double>& values) { owner.*member = dvec3_from(values, name); }};
}

void set_kind(Light& light, const std::string& name) {
    const auto kind = light_kind_from_string(name);
    if (!kind) {
        throw InvalidScene("light \"" + light.name + "\" has kind \"" + name +
                           "\"; choose point, spot, sun, rectangle, ellipse, line or polygon");
    }
    light.kind = *kind;
}

void bind_light(py::module_& m) {
    const auto position = vector_property(&Light::position_ws, "position_ws");
    const auto direction = vector_property(&Light::direction_ws, "direction_ws");
    const auto half_u = vector_property(&Light::half_u_ws, "half_u_ws");
    const auto half_v = vector_property(&Light::half_v_ws, "half_v_ws");
    const auto power = vector_property(&Light::power_w, "power_w");
    py::class_<Light>(m, "Light",
                      "One light, in world space: metres, radians, watts. See cpp/include/penumbra/light.h.")
        .def(py::init<>())
        .def_readwrite("name", &Light::name)
        .def_property(
            "kind", [](const Light& light) { return std::string{to_string(light.kind)}; }, &set_kind)
        .def_property("position_ws", position.first, position.second)
        .def_property("direction_ws", direction.first, direction.second)
        .def_property("half_u_ws", half_u.first, half_u.second)
        .def_property("half_v_ws", half_v.first, half_v.second)
        .def_property("power_w", power.first, power.second)
        .def_property(
            "corners_ws",
            [](const Light& light) {
                std::vector<std::array<double, 3>> corners;
                corners.reserve(light.corners_ws.size());
                for (const glm::dvec3& c : light.corners_ws) {
                    corners.push_back({c.x, c.y, c.z});
                }
                return corners;
            },
            [](Light& light, const std::vector<std::vector<double>>& corners) {
                light.corners_ws.clear();
                for (const auto& corner : corners) {
                    light.corners_ws.push_back(dvec3_from(corner, "corners_ws"));
                }
            })
        .def_readwrite("radius_m", &Light::radius_m)
        .def_readwrite("sun_angle_rad", &Light::sun_angle_rad)
        .def_readwrite("spot_angle_rad", &Light::spot_angle_rad)
        .def_readwrite("spot_blend", &Light::spot_blend)
        .def_property(
            "spot_stretch",
            [](const Light& light) {
                return std::array<double, 2>{light.spot_stretch.x, light.spot_stretch.y};
            },
            [](Light& light, const std::array<double, 2>& value) {
                light.spot_stretch = {value[0], value[1]};
            })
        .def_readwrite("casts_shadow", &Light::casts_shadow);
}

void bind_camera(py::module_& m) {
    const auto pair = [](glm::dvec2 Camera::*member) {
        return std::pair{[member](const Camera& camera) {
                             return std::array<double, 2>{(camera.*member).x, (camera.*member).y};
                         },
                         [member](Camera& camera, const std::array<double, 2>& value) {
                             camera.*member = {value[0], value[1]};
                         }};
    };
    const auto shift = pair(&Camera::shift);
    const auto offset = pair(&Camera::pixel_offset);
    py::class_<Camera>(m, "Camera", "Looks along its local -z, +y up. See cpp/include/penumbra/scene.h.")
        .def(py::init<>())
        .def_readwrite("name", &Camera::name)
        .def_property(
            "world_from_camera", [](const Camera& camera) { return matrix_to(camera.world_from_camera); },
            [](Camera& camera, const Faithful<double>& matrix) {
                camera.world_from_camera = matrix_from(matrix.values, "world_from_camera");
            })
        .def_readwrite("orthographic", &Camera::orthographic)
        .def_readwrite("tan_half_width", &Camera::tan_half_width)
        .def_readwrite("half_width_m", &Camera::half_width_m)
        .def_property("shift", shift.first, shift.second)
        .def_readwrite("pixel_aspect", &Camera::pixel_aspect)
        .def_readwrite("near_m", &Camera::near_m)
        .def_readwrite("far_m", &Camera::far_m)
        .def_readwrite("width_px", &Camera::width_px)
        .def_readwrite("height_px", &Camera::height_px)
        .def_property("pixel_offset", offset.first, offset.second);
}

}  // namespace

void bind_scene(py::module_& m) {
    bind_light(m);
    bind_camera(m);
    py::class_<PyMesh>(m, "Mesh", "Triangles in their own space, shared by all their instances.")
        .def(
            py::init(&make_mesh), py::arg("name"), py::arg("positions"), py::arg("triangles"),
            py::arg("corner_normals") = py::none(), py::arg("triangle_material") = py::none(),
            "positions (n, 3) float32; triangles (m, 3) uint32; corner_normals (3 m, 3) float32 or None (flat);\n"
            "triangle_material (m,) uint16 or None. Raises InvalidScene for indices out of range, NaN or wrong shapes.")
        .def_property_readonly("name", [](const PyMesh& self) { return self.mesh->name; })
        .def_property_readonly("vertex_count", [](const PyMesh& self) { return self.mesh->positions_local.size(); })
        .def_property_readonly("triangle_count", [](const PyMesh& self) { return self.mesh->triangles.size(); });
    py::class_<Scene, std::shared_ptr<Scene>>(m, "Scene", "What is rendered: instances, lights, one camera.")
        .def(py::init<>())
        .def("add_instance", &add_instance, py::arg("name"), py::arg("mesh").none(false), py::arg("world_from_local"),
             py::arg("albedo"), py::arg("casts") = true, py::arg("receives") = true, py::arg("visible") = true,
             "world_from_local (4, 4) float64; albedo (k, 3) float32, linear, one row per material slot.")
        .def(
            "add_light", [](Scene& scene, const Light& light) { scene.lights.push_back(light); }, py::arg("light"))
        .def("set_transform", &set_transform, py::arg("instance"), py::arg("world_from_local"),
             "Moves an instance, counted from 0 in the order they were added; (4, 4) float64.")
        .def(
            "copy", [](const Scene& scene) { return std::make_shared<Scene>(scene); },
            "Another scene with the same meshes: what is changed in one of them does not change the other.")
        .def_readwrite("lights", &Scene::lights)
        .def_readwrite("camera", &Scene::camera)
        .def(
            "validate", [](Scene& scene) { validate(scene); }, py::call_guard<py::gil_scoped_release>())
        .def("digest", &scene_digest, py::call_guard<py::gil_scoped_release>(),
             "Hash over all that influences an image: equal digests give equal images.")
        .def_property_readonly("triangle_count", &triangle_count)
        .def_property_readonly("instance_count", [](const Scene& scene) { return scene.instances.size(); });
}

}  // namespace penumbra::bindings
