#pragma once

#include <memory>
#include <span>
#include <string>
#include <vector>

#include "penumbra/control.h"
#include "penumbra/measure.h"
#include "penumbra/plan.h"
#include "penumbra/reference.h"
#include "penumbra/scene.h"
#include "penumbra/settings.h"
#include "penumbra/technique.h"
#include "penumbra/view.h"

namespace penumbra {

/// What finds the triangle that each pixel shows. Rays need no drawing, which pays without a graphics card where meshes
/// are heavy; they are as exact as float32 in the frame of the whole scene, where a rasteriser's numbers are the
/// camera's but its grid is 1/256 pixel.
enum class ViewBy { Raster, Rays };

struct RendererOptions {
    std::string device;  ///< "" first hardware device with OpenGL 4.5, else software; or index, or part of a name
    bool debug = false;  ///< driver messages become errors
    ViewBy view_by = ViewBy::Raster;
    std::size_t most_kept_bytes = std::size_t{256} << 20U;  ///< of the frames that Job::reuse keeps, in main memory
};

/// Where and with what it runs; stands in every report.
struct Environment {
    std::string gl_renderer, gl_version, gl_vendor, device;
    bool software = false;
    int threads = 0;
    std::string view_by;  ///< "raster" or "rays"
    std::string embree;
};

/// What the scene holds for one light, in numbers.
struct LightReport {
    std::uint64_t lit_pixels = 0;  ///< pixels in the comparison's mask
    std::uint64_t pixels = 0;      ///< of the image
    std::uint32_t casters = 0;     ///< instances that may shade a visible receiver
    std::uint32_t casters_outside = 0;
    std::uint64_t caster_triangles = 0;
    bool has_extent = false;
    std::string trivial_rule, trivial_reason;  ///< why V is 1 everywhere, or empty
};

struct VisibilityResult {
    std::vector<float> visibility;  ///< as View, row 0 at the bottom; 1 outside the mask
    Settings settings;              ///< complete
    Plan plan;
    std::vector<Statistic> statistics;
    std::size_t memory_bytes = 0;  ///< kept by the technique between frames
    double setup_ms = 0.0, update_ms = 0.0, resolve_ms = 0.0;
    bool kept = false;  ///< of an earlier frame that nothing has changed since; then resolve_ms is the handing over
};

struct Job {
    std::string technique;
    Settings settings;
    bool statistics = true;  ///< visibility() counts what the frame did, which may cost as much as the frame
    std::vector<std::string> keep_rules = {};  ///< ids of rules to be kept as well NOLINT(*-redundant-member-init)
    /// visibility() keeps V, and hands over an earlier frame's if view, light, casters and settings are the same.
    bool reuse = false;
};

/// Times of one job: set-up once, a dynamic frame (casters or light moved), a static frame (maps kept), a kept frame
/// (nothing changed, so V is handed over: Job::reuse), and the view that all techniques share (its own line, in no
/// sum).
struct Measurement {
    TimeSummary setup, dynamic_frame, static_frame, kept_frame, view;
    Plan plan;  ///< with the median time of each step
    std::size_t memory_bytes = 0;
};

/// What a renderer has done since it was made. What a count does not go up by was not run.
struct WorkDone {
    std::uint64_t programs = 0;        ///< shader programs compiled
    std::uint64_t views = 0;           ///< G-buffers made
    std::uint64_t summaries = 0;       ///< lights summarised
    std::uint64_t ray_scenes = 0;      ///< acceleration structures built
    std::uint64_t geometries = 0;      ///< times that meshes were sent
    std::uint64_t triangles_sent = 0;  ///< by the last of them
    std::uint64_t frames = 0;          ///< made by a technique, in visibility()
    std::uint64_t frames_kept = 0;     ///< handed over instead
};

struct NamedDebugImage {
    DebugView view;
    DebugImage image;
};

/// Renders one scene on one device. Owns a render thread with its own EGL context; calls block until done, may come
/// from any thread and are queued. Two renderers may live in one process.
class Renderer {
public:
    /// @throws DeviceError if there is no usable device; the sentence says what to install.
    explicit Renderer(const RendererOptions& options = {});
    ~Renderer();
    Renderer(const Renderer&) = delete;
    Renderer& operator=(const Renderer&) = delete;

    [[nodiscard]] const Environment& environment() const noexcept;
    [[nodiscard]] WorkDone work() const;

    /// Takes a copy (meshes are shared), checks it and makes it current. Only what changed is checked and sent again:
    /// an instance that moved costs its matrix, another light keeps the view, another camera what rays are cast at.
    /// @throws InvalidScene; the former scene then stays.
    void set_scene(const Scene& scene);

    /// The G-buffer of the scene's camera; made once per camera and set of instances.
    [[nodiscard]] std::shared_ptr<const View> view(Control& control);
    [[nodiscard]] double view_ms() const noexcept;  ///< time of the view passes, without the copy to main memory

    [[nodiscard]] std::vector<std::uint8_t> mask(std::size_t light, Control& control);
    [[nodiscard]] LightReport light_report(std::size_t light, bool keep_everything, Control& control);
    /// Empty, or why the technique cannot serve the light.
    [[nodiscard]] std::string supports(std::size_t light, std::string_view technique) const;

    [[nodiscard]] VisibilityResult visibility(std::size_t light, const Job& job, bool keep_everything,
                                              Control& control);
    /// The same for several lights at once: their techniques live side by side, and maps of one size are layers of
    /// common arrays. In the order of `lights`.
    [[nodiscard]] std::vector<VisibilityResult> visibility(std::span<const std::size_t> lights, const Job& job,
                                                           bool keep_everything, Control& control);
    /// Pictures of a technique's inside after one frame. @param views ids; empty: all that its plan offers
    /// @throws InvalidSettings for an unknown view; the message lists those there are
    [[nodiscard]] std::vector<NamedDebugImage> debug_images(std::size_t light, const Job& job,
                                                            std::span<const std::string> views, Control& control);
    /// The technique's textures of V on surfaces of the scene, with nothing left out; empty if it makes none.
    [[nodiscard]] std::vector<BakedTexture> bake(std::size_t light, const Job& job, Control& control);
    [[nodiscard]] std::vector<Measurement> measure(std::size_t light, std::span<const Job> jobs, bool keep_everything,
                                                   const TimingOptions& timing, Control& control);
    [[nodiscard]] Reference reference(std::size_t light, const ReferenceOptions& options, Control& control);
    /// Analytic unshadowed irradiance with the shading normal, RGB W/m^2; 0 where nothing is seen and where the face
    /// itself turns away from the whole light, whatever its smooth normal says.
    [[nodiscard]] std::vector<glm::vec3> irradiance(std::size_t light, Control& control);

private:
    class Impl;
    std::unique_ptr<Impl> impl_;
};

}  // namespace penumbra
