#pragma once

#include <functional>
#include <string_view>
#include <utility>
#include <vector>

#include "gl/framebuffer.h"
#include "gl/render_thread.h"
#include "gl/timer.h"
#include "passes/fullscreen.h"
#include "passes/gpu_adjacency.h"
#include "passes/gpu_scene.h"
#include "passes/light_summary.h"
#include "passes/view_pass.h"
#include "penumbra/control.h"
#include "penumbra/plan.h"
#include "penumbra/view.h"

namespace penumbra {

class MapLayers;
class RayScene;

/// Everything a technique sees while it serves one light in one view, and where its V goes. On the render thread.
class Frame {
public:
    struct Inputs {
        Device& device;
        const Scene& scene;
        GpuScene& gpu_scene;
        GpuAdjacency& adjacency;  ///< brought up to date when it is first asked for
        ViewPass& view_pass;
        const View& view;
        const LightSummary& summary;
        FullscreenPass& fullscreen;
        StepClock& clock;
        Control& control;
        std::function<const RayScene&()> ray_scene;  ///< built when it is first asked for
        TextureImage& visibility;                    ///< R32F of the view's size
        RenderTarget& visibility_target;
        MapLayers* map_layers = nullptr;  ///< maps that lights share; none: each has its own
    };
    Frame(Inputs inputs, const Plan& plan) : in_{std::move(inputs)}, plan_{plan} {}

    [[nodiscard]] Device& device() const noexcept { return in_.device; }
    [[nodiscard]] const Scene& scene() const noexcept { return in_.scene; }
    [[nodiscard]] GpuScene& gpu_scene() const noexcept { return in_.gpu_scene; }
    [[nodiscard]] GpuAdjacency& adjacency() const {
        in_.adjacency.update(in_.gpu_scene);
        return in_.adjacency;
    }
    /// See ViewPass::depth_stencil().
    [[nodiscard]] const TextureImage& view_depth() const {
        return in_.view_pass.depth_stencil(in_.device, in_.gpu_scene, in_.scene);
    }
    [[nodiscard]] const View& view() const noexcept { return in_.view; }
    [[nodiscard]] const LightSummary& summary() const noexcept { return in_.summary; }
    [[nodiscard]] const Light& light() const noexcept { return *in_.summary.light; }
    [[nodiscard]] const RayScene& ray_scene() const { return in_.ray_scene(); }
    [[nodiscard]] MapLayers* map_layers() const noexcept { return in_.map_layers; }
    [[nodiscard]] Control& control() const noexcept { return in_.control; }
    [[nodiscard]] const Plan& plan() const noexcept { return plan_; }

    /// Runs one step of the plan under the clock, or does nothing where the plan leaves it out.
    template <class F>
    void step(std::string_view name, const F& work) {
        if (!plan_.runs(name)) {
            return;
        }
        in_.control.check();
        {
            const StepClock::Scope scope = in_.clock.scope(name);
            work();
        }
        check_gl(name);
    }

    /// The view's receivers at texture unit 0, for read_receiver().
    void bind_view() const;
    /// bind_view() and write_visibility_with().
    void resolve_with(const Program& program);
    /// Runs a full-screen pass that writes V, with the textures that are bound.
    void write_visibility_with(const Program& program);
    [[nodiscard]] FullscreenPass& fullscreen() const noexcept { return in_.fullscreen; }

    /// For techniques on the CPU: V in main memory instead of the texture.
    [[nodiscard]] std::vector<float>& visibility_on_cpu();
    [[nodiscard]] bool result_on_cpu() const noexcept { return !cpu_visibility_.empty(); }

private:
    Inputs in_;
    const Plan& plan_;
    std::vector<float> cpu_visibility_;
};

}  // namespace penumbra
