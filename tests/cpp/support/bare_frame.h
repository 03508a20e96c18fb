#pragma once

#include "passes/frame.h"

namespace penumbra {

/// A Frame with nothing but a device and a scene, for passes that need no view and no light. On the render thread.
class BareFrame {
public:
    /// @param scene  must outlive this
    BareFrame(Device& device, const Scene& scene)
        : frame_{{device,
                  scene,
                  gpu_scene,
                  adjacency_,
                  view_pass_,
                  view_,
                  summary_,
                  fullscreen_,
                  clock_,
                  control_,
                  {},
                  visibility_,
                  target_},
                 plan_} {
        gpu_scene.update(scene);
    }
    operator Frame&() noexcept { return frame_; }  // NOLINT(google-explicit-constructor): it stands in for one
    Frame* operator->() noexcept { return &frame_; }

    GpuScene gpu_scene;

private:
    GpuAdjacency adjacency_;
    ViewPass view_pass_;
    View view_;
    LightSummary summary_;
    FullscreenPass fullscreen_;
    StepClock clock_{true};
    Control control_;
    TextureImage visibility_;
    RenderTarget target_;
    Plan plan_;
    Frame frame_;
};

}  // namespace penumbra
