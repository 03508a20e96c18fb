#include "penumbra/renderer.h"

#include <pybind11/stl.h>

#include "arrays.h"
#include "bindings.h"
#include "convert.h"
#include "waiting.h"

namespace penumbra::bindings {

using namespace pybind11::literals;

namespace {

ViewBy view_by_of(const std::string& name) {
    if (name != "raster" && name != "rays") {
        throw InvalidSettings("view_by is \"" + name + "\"; choose from: raster, rays");
    }
    return name == "rays" ? ViewBy::Rays : ViewBy::Raster;
}

/// The renderer and the size of its images, so that arrays get their shape.
struct PyRenderer {
    PyRenderer(const std::string& device, bool debug, std::size_t most_kept_bytes, const std::string& view_by)
        : renderer{
              {.device = device, .debug = debug, .view_by = view_by_of(view_by), .most_kept_bytes = most_kept_bytes}} {}
    Renderer renderer;
    py::ssize_t width = 512, height = 512;

    template <class T>
    py::array image(std::vector<T>&& values) const {
        return array_from<T>(std::move(values), {height, width});
    }
    py::array image3(std::vector<glm::vec3>&& values) const {
        return array_from<float>(std::move(values), {height, width, 3});
    }
};

py::array view_array3(const std::shared_ptr<const View>& view, const std::vector<glm::vec3>& values) {
    // The capsule keeps the view alive; the array is a window onto it.
    auto* owner = new std::shared_ptr<const View>(view);
    const py::capsule capsule(owner, [](void* p) { delete static_cast<std::shared_ptr<const View>*>(p); });
    return py::array_t<float>({py::ssize_t{view->height}, py::ssize_t{view->width}, py::ssize_t{3}},
                              reinterpret_cast<const float*>(values.data()), capsule);
}

py::array view_array(const std::shared_ptr<const View>& view, const std::vector<std::int32_t>& values) {
    auto* owner = new std::shared_ptr<const View>(view);
    const py::capsule capsule(owner, [](void* p) { delete static_cast<std::shared_ptr<const View>*>(p); });
    return py::array_t<std::int32_t>({py::ssize_t{view->height}, py::ssize_t{view->width}}, values.data(), capsule);
}

struct PyView {
    std::shared_ptr<const View> view;
    double time_ms = 0.0;
};

void bind_view(py::module_& m) {
    py::class_<PyView>(m, "View", "G-buffer at the pixel samples; row 0 is the bottom row, lengths in metres.")
        .def_property_readonly("width", [](const PyView& v) { return v.view->width; })
        .def_property_readonly("height", [](const PyView& v) { return v.view->height; })
        .def_property_readonly("eye_ws",
                               [](const PyView& v) {
                                   const glm::dvec3& e = v.view->eye_ws;
                                   return std::array<double, 3>{e.x, e.y, e.z};
                               })
        .def_property_readonly("position_cr", [](const PyView& v) { return view_array3(v.view, v.view->position_cr); })
        .def_property_readonly("normal_ws", [](const PyView& v) { return view_array3(v.view, v.view->normal_ws); })
        .def_property_readonly("shading_normal_ws",
                               [](const PyView& v) { return view_array3(v.view, v.view->shading_normal_ws); })
        .def_property_readonly("albedo", [](const PyView& v) { return view_array3(v.view, v.view->albedo); })
        .def_property_readonly("instance", [](const PyView& v) { return view_array(v.view, v.view->instance); })
        .def_property_readonly("triangle", [](const PyView& v) { return view_array(v.view, v.view->triangle); })
        .def_readonly("time_ms", &PyView::time_ms);
}

py::dict environment(const PyRenderer& self) {
    const Environment& e = self.renderer.environment();
    return py::dict("gl_renderer"_a = e.gl_renderer, "gl_version"_a = e.gl_version, "gl_vendor"_a = e.gl_vendor,
                    "device"_a = e.device, "software"_a = e.software, "threads"_a = e.threads, "embree"_a = e.embree,
                    "view_by"_a = e.view_by);
}

void set_scene(PyRenderer& self, const Scene& scene) {
    {
        const py::gil_scoped_release release;
        self.renderer.set_scene(scene);
    }
    self.width = scene.camera.width_px;
    self.height = scene.camera.height_px;
}

PyView view(PyRenderer& self, const py::object& progress) {
    auto seen = wait_for([&](Control& control) { return self.renderer.view(control); }, progress, "view");
    return {std::move(seen), self.renderer.view_ms()};
}

py::array mask(PyRenderer& self, std::size_t light) {
    return self.image(wait_for([&](Control& c) { return self.renderer.mask(light, c); }, py::none(), "mask"));
}

py::dict summary(PyRenderer& self, std::size_t light, bool keep_everything) {
    const LightReport r = wait_for([&](Control& c) { return self.renderer.light_report(light, keep_everything, c); },
                                   py::none(), "summary");
    return py::dict("lit_pixels"_a = r.lit_pixels, "pixels"_a = r.pixels, "casters"_a = r.casters,
                    "casters_left_out"_a = r.casters_outside, "caster_triangles"_a = r.caster_triangles,
                    "has_extent"_a = r.has_extent, "trivial_rule"_a = r.trivial_rule,
                    "trivial_reason"_a = r.trivial_reason);
}

py::dict visibility(PyRenderer& self, std::size_t light, const std::string& technique, const py::dict& settings,
                    bool keep_everything, bool statistics, const py::object& progress, bool reuse,
                    const std::vector<std::string>& keep_rules) {
    const Job job{technique, settings_from(settings), statistics, keep_rules, reuse};
    VisibilityResult r = wait_for([&](Control& c) { return self.renderer.visibility(light, job, keep_everything, c); },
                                  progress, technique);
    const py::dict times("setup"_a = r.setup_ms, "update"_a = r.update_ms, "resolve"_a = r.resolve_ms);
    return py::dict("visibility"_a = self.image(std::move(r.visibility)), "settings"_a = to_python(r.settings),
                    "plan"_a = to_python(r.plan), "warnings"_a = to_python(r.plan.warnings),
                    "statistics"_a = to_python(r.statistics), "memory_bytes"_a = r.memory_bytes, "time_ms"_a = times,
                    "kept"_a = r.kept);
}

py::dict work(const PyRenderer& self) {
    const WorkDone w = self.renderer.work();
    return py::dict("programs"_a = w.programs, "views"_a = w.views, "summaries"_a = w.summaries,
                    "ray_scenes"_a = w.ray_scenes, "geometries"_a = w.geometries, "triangles_sent"_a = w.triangles_sent,
                    "frames"_a = w.frames, "frames_kept"_a = w.frames_kept);
}

py::list debug_images(PyRenderer& self, std::size_t light, const std::string& technique, const py::dict& settings,
                      const std::vector<std::string>& views, const py::object& progress) {
    const Job job{technique, settings_from(settings)};
    auto images =
        wait_for([&](Control& c) { return self.renderer.debug_images(light, job, views, c); }, progress, technique);
    py::list all;
    for (NamedDebugImage& named : images) {
        DebugImage& image = named.image;
        const std::vector<py::ssize_t> shape{image.height_px, image.width_px, 3};
        all.append(py::dict("id"_a = named.view.id, "title"_a = named.view.title, "caption"_a = image.caption,
                            "rgb"_a = array_from<float>(std::move(image.rgb), shape)));
    }
    return all;
}

py::list bake(PyRenderer& self, std::size_t light, const std::string& technique, const py::dict& settings,
              const py::object& progress) {
    const Job job{technique, settings_from(settings)};
    auto textures = wait_for([&](Control& c) { return self.renderer.bake(light, job, c); }, progress, technique);
    py::list all;
    for (BakedTexture& texture : textures) {
        std::vector<std::array<double, 3>> corners;
        corners.reserve(texture.corners_ws.size());
        for (const glm::dvec3& c : texture.corners_ws) {
            corners.push_back({c.x, c.y, c.z});
        }
        const std::vector<py::ssize_t> shape{texture.height_px, texture.width_px};
        all.append(py::dict("name"_a = texture.name, "corners_ws"_a = corners,
                            "visibility"_a = array_from<float>(std::move(texture.visibility), shape)));
    }
    return all;
}

py::list measure(PyRenderer& self, std::size_t light, const std::vector<std::pair<std::string, py::dict>>& jobs,
                 bool keep_everything, double max_seconds, int min_runs, int max_runs, const py::object& progress,
                 const std::vector<std::vector<std::string>>& keep_rules) {
    if (!keep_rules.empty() && keep_rules.size() != jobs.size()) {
        throw InvalidSettings("keep_rules has " + std::to_string(keep_rules.size()) + " lists for " +
                              std::to_string(jobs.size()) + " jobs; give each job one, or none at all");
    }
    std::vector<Job> wanted;
    wanted.reserve(jobs.size());
    for (const auto& [technique, settings] : jobs) {
        Job job{technique, settings_from(settings)};
        if (!keep_rules.empty()) {
            job.keep_rules = keep_rules[wanted.size()];
        }
        wanted.push_back(std::move(job));
    }
    TimingOptions timing;
    timing.max_seconds = max_seconds;
    timing.min_runs = min_runs;
    timing.max_runs = max_runs;
    const auto results =
        wait_for([&](Control& c) { return self.renderer.measure(light, wanted, keep_everything, timing, c); }, progress,
                 "measuring");
    py::list all;
    for (const Measurement& m : results) {
        all.append(py::dict("setup"_a = to_python(m.setup), "dynamic"_a = to_python(m.dynamic_frame),
                            "static"_a = to_python(m.static_frame), "kept"_a = to_python(m.kept_frame),
                            "view"_a = to_python(m.view), "plan"_a = to_python(m.plan),
                            "warnings"_a = to_python(m.plan.warnings), "memory_bytes"_a = m.memory_bytes));
    }
    return all;
}

py::dict reference(PyRenderer& self, std::size_t light, double standard_error, std::uint32_t seed,
                   int max_rays_per_pixel, bool keep_everything, bool exact, const py::object& progress) {
    const ReferenceOptions options{.method = exact ? ReferenceMethod::Exact : ReferenceMethod::RayTraced,
                                   .standard_error = standard_error,
                                   .seed = seed,
                                   .max_rays_per_pixel = max_rays_per_pixel,
                                   .keep_everything = keep_everything};
    Reference r =
        wait_for([&](Control& c) { return self.renderer.reference(light, options, c); }, progress, "reference");
    return py::dict("method"_a = r.method, "area"_a = self.image(std::move(r.area)),
                    "irradiance"_a = self.image(std::move(r.irradiance)),
                    "standard_error"_a = self.image(std::move(r.standard_error)),
                    "irradiance_standard_error"_a = self.image(std::move(r.irradiance_standard_error)),
                    "mask"_a = self.image(std::move(r.mask)), "rays"_a = r.rays,
                    "mean_rays_per_pixel"_a = r.mean_rays_per_pixel, "time_ms"_a = r.time_ms, "reached"_a = r.reached,
                    "pixels_skipped"_a = r.pixels_skipped);
}

py::array irradiance(PyRenderer& self, std::size_t light, const py::object& progress) {
    return self.image3(
        wait_for([&](Control& c) { return self.renderer.irradiance(light, c); }, progress, "irradiance"));
}

py::dict exact(const Scene& scene, std::size_t light, const Array<double>& positions, const Array<double>& normals) {
    if (light >= scene.lights.size()) {
        throw InvalidScene("there is no light " + std::to_string(light) + "; the scene has " +
                           std::to_string(scene.lights.size()) + ", counted from 0");
    }
    const auto p = vectors_from<glm::dvec3, double, 3>(positions, "positions");
    const auto n = vectors_from<glm::dvec3, double, 3>(normals, "normals");
    Scene checked = scene;
    validate(checked);
    ExactResult r = wait_for([&](Control& c) { return exact_visibility(checked, checked.lights[light], p, n, c); },
                             py::none(), "exact visibility");
    const auto count = static_cast<py::ssize_t>(p.size());
    return py::dict("area"_a = array_from<double>(std::move(r.area), {count}),
                    "irradiance"_a = array_from<double>(std::move(r.irradiance), {count}));
}

}  // namespace

void bind_renderer(py::module_& m) {
    bind_view(m);
    py::class_<PyRenderer>(m, "Renderer",
                           "Renders one scene on one device, on a thread of its own. Long calls release the GIL, hear\n"
                           "Ctrl-C, and tell progress(fraction, text) if it is given.")
        .def(py::init<const std::string&, bool, std::size_t, const std::string&>(), "device"_a = "", "debug"_a = false,
             "most_kept_bytes"_a = RendererOptions{}.most_kept_bytes, "view_by"_a = "raster",
             py::call_guard<py::gil_scoped_release>(),
             "device: \"\" (automatic), an index, or part of a renderer's name. Raises DeviceError.\n"
             "most_kept_bytes: of the frames that visibility(reuse=True) keeps, in main memory.\n"
             "view_by: \"raster\" draws what the camera sees; \"rays\" traces it, which is faster without a graphics\n"
             "card where meshes are heavy and stand still.")
        .def_property_readonly("environment", &environment)
        .def("work", &work, "What it has done so far: programs compiled, views drawn, frames made and kept, and more.")
        .def("set_scene", &set_scene, "scene"_a, "Checks the scene and makes it current. Raises InvalidScene.")
        .def("view", &view, "progress"_a = py::none())
        .def("mask", &mask, "light"_a, "(h, w) uint8: 1 where this light's visibility is asked.")
        .def("summary", &summary, "light"_a, "keep_everything"_a = false)
        .def(
            "supports",
            [](PyRenderer& self, std::size_t light, const std::string& technique) {
                return self.renderer.supports(light, technique);
            },
            "light"_a, "technique"_a, py::call_guard<py::gil_scoped_release>(),
            "Empty, or why the technique cannot serve the light.")
        .def("visibility", &visibility, "light"_a, "technique"_a, "settings"_a = py::dict(),
             "keep_everything"_a = false, "statistics"_a = true, "progress"_a = py::none(), "reuse"_a = false,
             "keep_rules"_a = std::vector<std::string>{},
             "{visibility (h, w) float32 0 umbra .. 1 lit, settings, plan, warnings, statistics,\n"
             "memory_bytes, time_ms, kept}; warnings {id, reason}: where the technique leaves its field of use.\n"
             "statistics: count what the frame did, which may cost as much as the frame.\n"
             "reuse: keep V, and hand over an earlier frame's if view, light, casters and settings are the same.\n"
             "keep_rules: ids of rules that must leave nothing out.")
        .def("debug_images", &debug_images, "light"_a, "technique"_a, "settings"_a = py::dict(),
             "views"_a = std::vector<std::string>{}, "progress"_a = py::none(),
             "Pictures of the technique's inside: {id, title, caption, rgb (h, w, 3) float32, display values 0 .. 1}.\n"
             "views: ids, default all that the plan offers.")
        .def(
            "bake", &bake, "light"_a, "technique"_a, "settings"_a = py::dict(), "progress"_a = py::none(),
            "The technique's textures of V on surfaces: {name, visibility (h, w) float32, corners_ws: world positions\n"
            "of the image's corners at the UVs (0, 0), (1, 0), (1, 1), (0, 1)}; empty if it makes none.")
        .def("measure", &measure, "light"_a, "jobs"_a, "keep_everything"_a = false, "max_seconds"_a = 4.0,
             "min_runs"_a = 5, "max_runs"_a = 200, "progress"_a = py::none(),
             "keep_rules"_a = std::vector<std::vector<std::string>>{},
             "Times of (technique, settings) jobs, measured interleaved; milliseconds.\n"
             "keep_rules: for each job the rules that must leave nothing out; [\"all\"] for all of them.")
        .def("reference", &reference, "light"_a, "standard_error"_a = 0.002, "seed"_a = 1,
             "max_rays_per_pixel"_a = 65536, "keep_everything"_a = false, "exact"_a = false, "progress"_a = py::none(),
             "The truth by ray tracing to a standard error: area and irradiance (h, w) float32, and more.\n"
             "exact: float64 boundary intervals instead, for rectangle and polygon lights.")
        .def("irradiance", &irradiance, "light"_a, "progress"_a = py::none(),
             "Analytic unshadowed irradiance (h, w, 3) float32, W/m^2.");
    m.def("exact_visibility", &exact, "scene"_a, "light"_a, "positions"_a, "normals"_a,
          "Exact visibility and irradiance ratio of a rectangle or polygon light at points (n, 3) float64, world.");
}

}  // namespace penumbra::bindings
