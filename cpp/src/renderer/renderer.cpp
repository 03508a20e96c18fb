#include "penumbra/renderer.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <map>
#include <optional>

#include "base/parallel.h"
#include "geometry/radiometry.h"
#include "geometry/seen_surfaces.h"
#include "gl/render_thread.h"
#include "passes/asked_pixels.h"
#include "passes/field_of_use.h"
#include "passes/frame.h"
#include "passes/light_summary.h"
#include "passes/map_layers.h"
#include "reference/embree_library.h"
#include "reference/light_mask.h"
#include "reference/ray_reference.h"
#include "reference/ray_scene.h"
#include "reference/seen_triangles.h"
#include "renderer/kept_frames.h"
#include "scene/digest.h"
#include "scene/scene_validator.h"

namespace penumbra {

namespace {

using Clock = std::chrono::steady_clock;

double ms_since(Clock::time_point start) {
    return std::chrono::duration<double, std::milli>(Clock::now() - start).count();
}

bool runs_anything(const Plan& plan) {
    return std::ranges::any_of(plan.steps, &Step::run);
}

bool leaves_out(const Plan& plan, std::string_view rule) {
    return std::ranges::any_of(plan.steps, [&](const Step& step) { return step.rule == rule; });
}

}  // namespace

/// Everything below lives on the render thread, except what is const after construction.
class Renderer::Impl {
public:
    explicit Impl(const RendererOptions& options)
        : thread_{{.device = options.device, .debug = options.debug, .egl_library = {}}}, view_by_{options.view_by} {
        const DeviceInfo& info = thread_.info();
        environment_.gl_renderer = info.name;
        environment_.gl_version = info.gl_version;
        environment_.gl_vendor = info.vendor;
        environment_.device = describe(info);
        environment_.software = info.software;
        environment_.threads = thread_count();
        environment_.view_by = view_by_ == ViewBy::Raster ? "raster" : "rays";
        environment_.embree = embree::version();
        state_ = thread_.run([&](Device& device) {
            return std::make_unique<State>(device.workarounds.time_by_wall_clock, options.most_kept_bytes);
        });
    }
    ~Impl() {
        try {
            thread_.run([&](Device&) { state_.reset(); });
        } catch (const Error&) {
            // The context is lost and its objects with it: their names must not be freed on this thread.
            static_cast<void>(state_.release());
        }
    }
    Impl(const Impl&) = delete;
    Impl& operator=(const Impl&) = delete;

    RenderThread thread_;
    ViewBy view_by_;
    Environment environment_;

    struct State {
        State(bool wall_clock, std::size_t most_kept_bytes) : clock{wall_clock}, kept{most_kept_bytes} {}
        StepClock clock;
        SceneValidator validator;
        FullscreenPass fullscreen;
        GpuScene gpu_scene;
        GpuAdjacency adjacency;
        ViewPass view_pass;
        std::shared_ptr<const Scene> scene = std::make_shared<const Scene>();
        bool sent = false;  ///< the scene's instances are those of gpu_scene
        std::shared_ptr<View> view;
        View spare_view;  ///< the memory of one that is gone
        double view_ms = 0.0;
        std::vector<glm::uvec2> seen;  ///< by camera rays
        std::unique_ptr<RayScene> ray_scene, seen_scene;
        std::map<std::pair<std::size_t, Keep>, LightSummary> summaries;
        FrameDigests digests;
        KeptFrames kept;
        WorkDone work;
        TextureImage visibility;
        RenderTarget visibility_target;
        MapLayers map_layers;
    };
    std::unique_ptr<State> state_;

    View see_with_rays(Control& control) {
        State& s = *state_;
        const Camera& camera = s.scene->camera;
        s.seen.resize(static_cast<std::size_t>(camera.width_px) * static_cast<std::size_t>(camera.height_px));
        find_seen(seen_scene(control), camera, s.seen, control);
        return s.view_pass.place(*s.scene, s.seen, control, std::move(s.spare_view));
    }

    View render_view(Device& device, Control& control) {
        State& s = *state_;
        glFinish();
        const auto started = Clock::now();
        View view = view_by_ == ViewBy::Raster
                        ? s.view_pass.render(device, s.gpu_scene, *s.scene, control, std::move(s.spare_view))
                        : see_with_rays(control);
        glFinish();
        s.view_ms = ms_since(started);
        ++s.work.views;
        return view;
    }

    void drop_view() {
        State& s = *state_;
        if (s.view.use_count() == 1) {  // else somebody else still reads it
            s.spare_view = std::move(*s.view);
        }
        s.view.reset();
    }

    /// Without shading normals and albedo, unless somebody asked for them.
    const View& view(Device& device, Control& control) {
        State& s = *state_;
        if (!s.view) {
            s.view = std::make_shared<View>(render_view(device, control));
            const Camera& camera = s.scene->camera;
            if (!s.visibility || s.visibility.width() != camera.width_px || s.visibility.height() != camera.height_px) {
                s.visibility = TextureImage::make_2d(GL_R32F, camera.width_px, camera.height_px, "visibility");
                s.visibility_target = RenderTarget{"visibility"};
                s.visibility_target.attach_colour(0, s.visibility);
            }
        }
        return *s.view;
    }

    std::shared_ptr<const View> shaded_view(Device& device, Control& control) {
        static_cast<void>(view(device, control));
        shade_surfaces(*state_->scene, *state_->view, control);
        return state_->view;
    }

    [[nodiscard]] const Light& light(std::size_t index) const {
        const auto& lights = state_->scene->lights;
        if (index >= lights.size()) {
            throw InvalidScene("there is no light " + std::to_string(index) + "; the scene has " +
                               std::to_string(lights.size()) + ", counted from 0");
        }
        return lights[index];
    }

    const LightSummary& summary(Device& device, std::size_t index, const Keep& keep, Control& control) {
        State& s = *state_;
        const Light& chosen = light(index);
        const auto key = std::pair{index, keep};
        auto found = s.summaries.find(key);
        if (found == s.summaries.end()) {
            found = s.summaries
                        .emplace(key, summarise_light(*s.scene, view(device, control), chosen,
                                                      s.gpu_scene.instance_bounds_ws(), keep))
                        .first;
            ++s.work.summaries;
        }
        return found->second;
    }

    const RayScene& ray_scene(Control& control) {
        State& s = *state_;
        if (!s.ray_scene) {
            s.ray_scene = std::make_unique<RayScene>(*s.scene, control);
            ++s.work.ray_scenes;
        }
        return *s.ray_scene;
    }

    /// What the camera can see, for its own rays: mostly just what casts.
    const RayScene& seen_scene(Control& control) {
        State& s = *state_;
        if (std::ranges::all_of(s.scene->instances, [](const Instance& i) { return i.visible == i.casts; })) {
            return ray_scene(control);
        }
        if (!s.seen_scene) {
            s.seen_scene = std::make_unique<RayScene>(*s.scene, control, RayTargets::Visible);
            ++s.work.ray_scenes;
        }
        return *s.seen_scene;
    }

    /// One technique at work on one light.
    struct Run {
        std::unique_ptr<Technique> technique;
        Settings settings;
        Plan plan;
        std::unique_ptr<Frame> frame;
        bool used_rays = false;
        double setup_ms = 0.0;
    };

    /// A scene in the place of the one at hand. What is made of parts that stay the same is kept.
    void replace_scene(const std::shared_ptr<const Scene>& scene) {
        State& s = *state_;
        const Scene& old = *s.scene;
        const auto same_shape = [](const Instance& a, const Instance& b) {
            return a.mesh == b.mesh && a.world_from_local == b.world_from_local && a.casts == b.casts;
        };
        const bool same_instances = s.sent && scene->instances == old.instances;
        const bool same_view = same_instances && scene->camera == old.camera;
        if (!std::ranges::equal(old.instances, scene->instances, same_shape)) {
            s.ray_scene.reset();
        }
        if (!same_instances) {
            s.seen_scene.reset();
        }
        if (!same_view) {
            drop_view();
            s.summaries.clear();
            s.digests.forget_view();
        }
        std::erase_if(s.summaries, [&](const auto& entry) {
            const std::size_t light = entry.first.first;
            return light >= scene->lights.size() ||
                   light_digest(old.lights[light]) != light_digest(scene->lights[light]);
        });
        for (auto& [key, kept] : s.summaries) {
            kept.scene = scene.get();
            kept.light = &scene->lights[key.first];
        }
        s.digests.forget_summaries();
        s.scene = scene;
        if (!same_instances) {
            s.sent = false;  // unless this ends well
            s.digests.forget_meshes(*scene);
            if (s.gpu_scene.update(*scene)) {
                ++s.work.geometries;
                s.work.triangles_sent = s.gpu_scene.triangles_sent();
            }
            s.sent = true;
        }
    }

    /// What V of this job depends on, but for the rays.
    [[nodiscard]] std::string frame_digest(const Job& job, const Settings& settings, const LightSummary& summarised,
                                           std::size_t light) {
        Digest digest;
        digest.add(state_->digests.of_summary(summarised, light));
        digest.add(job.technique);
        for (const auto& [id, value] : settings) {
            digest.add(id);
            digest.add(static_cast<std::uint64_t>(value.index()));
            std::visit([&](const auto& v) { digest.add(v); }, value);
        }
        digest.add(summarised.keep.everything);
        for (const std::string& rule : summarised.keep.rules) {
            digest.add(rule);
        }
        return digest.hex();
    }

    /// A frame handed over, if there is one of just this.
    [[nodiscard]] std::optional<VisibilityResult> kept_frame(Device& device, std::size_t light, const Job& job,
                                                             const Keep& keep, Control& control) {
        State& s = *state_;
        const auto started = Clock::now();
        const TechniqueInfo& info = make_technique(job.technique, job.settings)->info();
        const Settings settings = complete(info.id, info.settings, job.settings);
        const std::string frame = frame_digest(job, settings, summary(device, light, keep, control), light);
        const VisibilityResult* made = s.kept.find(frame, s.digests.of_all_casters(*s.scene), job.statistics);
        if (made == nullptr) {
            return std::nullopt;
        }
        VisibilityResult result = *made;
        result.plan = unchanged_plan(made->plan);
        result.kept = true;
        result.memory_bytes = result.visibility.size() * sizeof(float);
        result.setup_ms = result.update_ms = 0.0;
        result.resolve_ms = ms_since(started);
        return result;
    }

    void keep_frame(const Job& job, const Run& run, const LightSummary& summarised, std::size_t light,
                    const VisibilityResult& made) {
        State& s = *state_;
        s.kept.store(frame_digest(job, run.settings, summarised, light),
                     run.used_rays ? s.digests.of_all_casters(*s.scene) : std::string{}, job.statistics, made);
    }

    std::unique_ptr<Run> start(Device& device, std::size_t index, const Job& job, const Keep& keep, Control& control) {
        State& s = *state_;
        auto run = std::make_unique<Run>();
        run->technique = make_technique(job.technique, job.settings);
        const TechniqueInfo& info = run->technique->info();
        run->settings = complete(info.id, info.settings, job.settings);
        if (const Verdict verdict = run->technique->supports(light(index)); !verdict) {
            throw InvalidSettings(info.id + " cannot serve light \"" + light(index).name + "\": " + verdict.reason);
        }
        const View& seen = view(device, control);
        const LightSummary& summarised = summary(device, index, keep, control);
        run->plan = run->technique->plan(summarised);
        run->plan.warnings = outside_field(run->technique->field_of_use(), summarised);
        if (runs_anything(run->plan) && !leaves_out(run->plan, "pixel-outside-mask")) {
            AskedPixels{summarised}.tell(run->plan);
        }
        run->frame = std::make_unique<Frame>(Frame::Inputs{device, *s.scene, s.gpu_scene, s.adjacency, s.view_pass,
                                                           seen, summarised, s.fullscreen, s.clock, control,
                                                           [this, &control, made = run.get()]() -> const RayScene& {
                                                               made->used_rays = true;
                                                               return ray_scene(control);
                                                           },
                                                           s.visibility, s.visibility_target, &s.map_layers},
                                             run->plan);
        const auto started = Clock::now();
        run->technique->prepare(*run->frame);
        glFinish();
        run->setup_ms = ms_since(started);
        check_gl("set-up of " + info.id);
        return run;
    }

    /// One frame. Steps' times are added to `steps`. @return milliseconds of the whole
    double frame(Device& device, Run& run, bool dynamic, std::map<std::string, std::vector<double>>* steps) {
        State& s = *state_;
        glFinish();
        const auto started = Clock::now();
        if (dynamic) {
            run.technique->update(*run.frame);
        }
        run.technique->resolve(*run.frame);
        const auto times = s.clock.collect();
        glFinish();
        double total = ms_since(started);
        if (!device.workarounds.time_by_wall_clock && !run.technique->info().on_cpu) {
            total = 0.0;  // the GPU's own time: what the CPU waits for is no part of a frame in flight
            for (const StepTime& step : times) {
                total += step.ms;
            }
        }
        if (steps != nullptr) {
            std::map<std::string, double> sums;
            for (const StepTime& step : times) {
                sums[step.name] += step.ms;
            }
            for (const auto& [name, ms] : sums) {
                (*steps)[name].push_back(ms);
            }
        }
        return total;
    }

    /// The first frame.
    [[nodiscard]] VisibilityResult visibility(Run& run, const LightSummary& summarised, bool statistics) {
        VisibilityResult made;
        const auto started = Clock::now();
        run.technique->update(*run.frame);
        glFinish();
        const auto middle = Clock::now();
        run.technique->resolve(*run.frame);
        glFinish();
        made.update_ms = std::chrono::duration<double, std::milli>(middle - started).count();
        made.resolve_ms = ms_since(middle);
        made.setup_ms = run.setup_ms;
        made.plan = run.plan;
        for (const StepTime& step : state_->clock.collect()) {
            made.plan.add_time(step.name, step.ms);
        }
        made.visibility = result(run, summarised);
        made.settings = run.settings;
        made.memory_bytes = run.technique->memory_bytes();
        if (statistics) {
            made.statistics = run.technique->statistics(*run.frame);
        }
        return made;
    }

    [[nodiscard]] std::vector<float> result(const Run& run, const LightSummary& summarised) const {
        const State& s = *state_;
        std::vector<float> visibility;
        if (!runs_anything(run.plan)) {
            visibility.assign(s.view->size(), 1.0F);
        } else if (run.frame->result_on_cpu()) {
            visibility = run.frame->visibility_on_cpu();
        } else {
            visibility = s.visibility.read<float>();
        }
        // Outside the mask V is not asked: one value for all techniques, so that images compare by eye as well.
        for (std::size_t i = 0; i < visibility.size(); ++i) {
            if (summarised.mask[i] == 0) {
                visibility[i] = 1.0F;
            }
        }
        return visibility;
    }
};

Renderer::Renderer(const RendererOptions& options) : impl_{std::make_unique<Impl>(options)} {}
Renderer::~Renderer() = default;

const Environment& Renderer::environment() const noexcept {
    return impl_->environment_;
}

void Renderer::set_scene(const Scene& scene) {
    auto checked = std::make_shared<Scene>(scene);
    impl_->thread_.run([&](Device&) {
        impl_->state_->validator.validate(*checked);
        impl_->replace_scene(checked);
    });
}

WorkDone Renderer::work() const {
    return impl_->thread_.run([&](Device& device) {
        WorkDone work = impl_->state_->work;
        work.programs = static_cast<std::uint64_t>(device.programs.compiled());
        return work;
    });
}

std::shared_ptr<const View> Renderer::view(Control& control) {
    return impl_->thread_.run([&](Device& device) {
        control.check();
        return impl_->shaded_view(device, control);
    });
}

double Renderer::view_ms() const noexcept {
    return impl_->state_->view_ms;
}

std::vector<std::uint8_t> Renderer::mask(std::size_t light, Control& control) {
    return impl_->thread_.run([&](Device& device) {
        control.check();
        return impl_->summary(device, light, false, control).mask;
    });
}

LightReport Renderer::light_report(std::size_t light, bool keep_everything, Control& control) {
    return impl_->thread_.run([&](Device& device) {
        control.check();
        const LightSummary& summary = impl_->summary(device, light, keep_everything, control);
        const LightSummary::Trivial trivial = summary.trivial();
        return LightReport{.lit_pixels = summary.lit_pixels,
                           .pixels = summary.mask.size(),
                           .casters = static_cast<std::uint32_t>(summary.casters.size()),
                           .casters_outside = summary.casters_outside,
                           .caster_triangles = summary.caster_triangles,
                           .has_extent = summary.has_extent,
                           .trivial_rule = trivial.rule,
                           .trivial_reason = trivial.reason};
    });
}

std::string Renderer::supports(std::size_t light, std::string_view technique) const {
    return impl_->thread_.run(
        [&](Device&) { return make_technique(technique, {})->supports(impl_->light(light)).reason; });
}

VisibilityResult Renderer::visibility(std::size_t light, const Job& job, bool keep_everything, Control& control) {
    return std::move(visibility(std::span<const std::size_t>{&light, 1}, job, keep_everything, control).front());
}

std::vector<VisibilityResult> Renderer::visibility(std::span<const std::size_t> lights, const Job& job,
                                                   bool keep_everything, Control& control) {
    return impl_->thread_.run([&](Device& device) {
        const Keep keep{keep_everything, job.keep_rules};
        std::vector<VisibilityResult> results(lights.size());
        std::vector<std::unique_ptr<Impl::Run>> runs(lights.size());
        for (std::size_t i = 0; i < lights.size(); ++i) {
            control.check();
            std::optional<VisibilityResult> kept;
            if (job.reuse) {
                kept = impl_->kept_frame(device, lights[i], job, keep, control);
            }
            if (kept) {
                results[i] = std::move(*kept);
                ++impl_->state_->work.frames_kept;
            } else {
                runs[i] = impl_->start(device, lights[i], job, keep, control);
            }
        }
        for (std::size_t i = 0; i < runs.size(); ++i) {
            if (!runs[i]) {
                continue;
            }
            control.check();
            const LightSummary& summarised = impl_->summary(device, lights[i], keep, control);
            results[i] = impl_->visibility(*runs[i], summarised, job.statistics);
            check_gl("statistics of " + job.technique);
            ++impl_->state_->work.frames;
            if (job.reuse) {
                impl_->keep_frame(job, *runs[i], summarised, lights[i], results[i]);
            }
        }
        return results;
    });
}

std::vector<NamedDebugImage> Renderer::debug_images(std::size_t light, const Job& job,
                                                    std::span<const std::string> views, Control& control) {
    return impl_->thread_.run([&](Device& device) {
        control.check();
        const auto run = impl_->start(device, light, job, false, control);
        const std::vector<DebugView> offered = run->technique->debug_views(run->plan);
        std::vector<DebugView> wanted = views.empty() ? offered : std::vector<DebugView>{};
        for (const std::string& id : views) {
            const auto found = std::ranges::find_if(offered, [&](const DebugView& view) { return view.id == id; });
            if (found == offered.end()) {
                std::string known;
                for (const DebugView& view : offered) {
                    known += (known.empty() ? "" : ", ") + view.id;
                }
                throw InvalidSettings(job.technique + " has no view \"" + id + "\" for this light; " +
                                      (known.empty() ? "it has none" : "choose from: " + known));
            }
            wanted.push_back(*found);
        }
        run->technique->update(*run->frame);
        run->technique->resolve(*run->frame);
        static_cast<void>(impl_->state_->clock.collect());  // nobody asks for the times of these steps
        std::vector<NamedDebugImage> images;
        for (DebugView& view : wanted) {
            control.check();
            DebugImage image = run->technique->debug_image(*run->frame, view.id);
            check_gl("view " + view.id);
            images.push_back({std::move(view), std::move(image)});
        }
        return images;
    });
}

std::vector<BakedTexture> Renderer::bake(std::size_t light, const Job& job, Control& control) {
    return impl_->thread_.run([&](Device& device) {
        control.check();
        // Texels that no pixel sees are baked as well, so nothing may be left out for the view's sake.
        const auto run = impl_->start(device, light, job, true, control);
        run->technique->update(*run->frame);
        static_cast<void>(impl_->state_->clock.collect());
        std::vector<BakedTexture> textures = run->technique->bake(*run->frame);
        check_gl("bake");
        return textures;
    });
}

std::vector<Measurement> Renderer::measure(std::size_t light, std::span<const Job> jobs, bool keep_everything,
                                           const TimingOptions& timing, Control& control) {
    if (!(timing.max_seconds >= 0.0 && std::isfinite(timing.max_seconds))) {
        throw InvalidSettings("measure: max_seconds is " + std::to_string(timing.max_seconds) +
                              "; give finite seconds from 0 on");
    }
    return impl_->thread_.run([&](Device& device) {
        static_cast<void>(impl_->view(device, control));
        Control inner = Control::within(control);   // what a single frame has done is no progress of the measuring
        impl_->state_->view_pass.forget_readers();  // what these jobs do not read is not in their view's time
        std::vector<std::unique_ptr<Impl::Run>> runs;
        std::vector<std::map<std::string, std::vector<double>>> steps(jobs.size());
        for (const Job& job : jobs) {
            control.check();
            const Keep keep{keep_everything, job.keep_rules};
            runs.push_back(impl_->start(device, light, job, keep, inner));
        }
        const auto hand_over = [&](std::size_t i) {
            const Keep keep{keep_everything, jobs[i].keep_rules};
            Job job = jobs[i];
            job.statistics = false;
            const auto started = Clock::now();
            if (!impl_->kept_frame(device, light, job, keep, inner)) {
                const LightSummary& summarised = impl_->summary(device, light, keep, inner);
                impl_->keep_frame(job, *runs[i], summarised, light, impl_->visibility(*runs[i], summarised, false));
            }
            return ms_since(started);
        };
        std::vector<std::function<double()>> timed;
        for (std::size_t i = 0; i < runs.size(); ++i) {
            timed.emplace_back([&, i] { return impl_->frame(device, *runs[i], true, &steps[i]); });
            // A static frame follows a dynamic one of the same technique, so its maps are there.
            timed.emplace_back([&, i] { return impl_->frame(device, *runs[i], false, nullptr); });
            timed.emplace_back([&, i] { return hand_over(i); });
        }
        timed.emplace_back([&] {
            impl_->state_->spare_view = impl_->render_view(device, inner);
            return impl_->state_->view_ms;
        });
        for (const auto& run : runs) {  // every map exists before the first static frame is measured
            impl_->frame(device, *run, true, nullptr);
        }
        const std::vector<TimeSummary> times = measure_interleaved(timed, timing, control);
        std::vector<Measurement> results;
        for (std::size_t i = 0; i < runs.size(); ++i) {
            Measurement m;
            m.setup = summarise_times({runs[i]->setup_ms});
            m.dynamic_frame = times[3 * i];
            m.static_frame = times[3 * i + 1];
            m.kept_frame = times[3 * i + 2];
            m.view = times.back();
            for (auto& [name, samples] : steps[i]) {
                runs[i]->plan.add_time(name, summarise_times(std::move(samples)).median);
            }
            m.plan = runs[i]->plan;
            m.memory_bytes = runs[i]->technique->memory_bytes();
            results.push_back(std::move(m));
        }
        return results;
    });
}

Reference Renderer::reference(std::size_t light, const ReferenceOptions& options, Control& control) {
    return impl_->thread_.run([&](Device& device) {
        const View& view = *impl_->shaded_view(device, control);
        if (options.method == ReferenceMethod::Exact) {
            return exact_reference(*impl_->state_->scene, view, impl_->light(light), control);
        }
        return trace_reference(impl_->ray_scene(control), *impl_->state_->scene, view, impl_->light(light), options,
                               control);
    });
}

std::vector<glm::vec3> Renderer::irradiance(std::size_t light, Control& control) {
    return impl_->thread_.run([&](Device& device) {
        const View& view = *impl_->shaded_view(device, control);
        const Light& chosen = impl_->light(light);
        std::vector<glm::vec3> result(view.size(), glm::vec3{0.0F});
        parallel_for(
            static_cast<std::int64_t>(view.size()), 1024,
            [&](std::int64_t begin, std::int64_t end) {
                for (auto i = static_cast<std::size_t>(begin); i < static_cast<std::size_t>(end); ++i) {
                    if (!view.hit(i)) {
                        continue;
                    }
                    const glm::dvec3 p_ws = view.eye_ws + glm::dvec3{view.position_cr[i]};
                    // A smooth normal may look towards a light that its face turns away from altogether.
                    if (faces_light(chosen, p_ws, glm::dvec3{view.normal_ws[i]})) {
                        result[i] =
                            glm::vec3{unshadowed_irradiance(chosen, p_ws, glm::dvec3{view.shading_normal_ws[i]})};
                    }
                }
            },
            control);
        return result;
    });
}

}  // namespace penumbra
