#pragma once

#include <span>
#include <vector>

#include "gl/framebuffer.h"
#include "gl/render_thread.h"
#include "gl/texture.h"
#include "passes/gpu_scene.h"
#include "penumbra/control.h"
#include "penumbra/view.h"

namespace penumbra {

/// Reversed depth (1 near, 0 far) of the camera's view of a point relative to the eye, world axes.
[[nodiscard]] glm::dmat4 clip_from_rel(const Camera& camera);

/// What the camera sees. The device finds which triangle each pixel shows; the surfaces there are placed in float64 in
/// main memory (geometry/seen_surfaces), where plans, masks and rays need them anyway. Techniques on the device get
/// them as one texture, made when the first of them asks.
class ViewPass {
public:
    /// Makes the textures of the camera's size if they are not there, and renders.
    /// @param spare  as place_surfaces()
    /// @return without shading normals and albedo: shade_surfaces() @throws Cancelled
    View render(Device& device, GpuScene& gpu_scene, const Scene& scene, Control& control, View spare = {});

    /// The same of triangles found in another way, in `seen` as place_surfaces() takes them.
    View place(const Scene& scene, std::span<const glm::uvec2> seen, Control& control, View spare = {});

    /// The texture that lib/receiver.glsl reads. Made of the view when it is first asked for, and by render() itself
    /// from then on, so that the times of a view hold what its techniques need.
    /// @param view  of the last render() @throws Cancelled
    const TextureImage& receiver(const View& view, Control& control);
    /// No technique is known any more that reads receiver().
    void forget_readers() noexcept { receiver_wanted_ = false; }
    /// DEPTH32F_STENCIL8: reversed depth (1 near, 0 far or nothing), drawn by view_ids.vert with depth clamp on, so
    /// that a pass which places vertices by the same expression and clamps as well gets the same bits. The stencil is
    /// whose turn it is: clear it first, leave the depth as it is. There after render(); after place() it is drawn
    /// when it is first asked for.
    const TextureImage& depth_stencil(Device& device, GpuScene& gpu_scene, const Scene& scene);
    [[nodiscard]] std::size_t memory_bytes() const noexcept;

private:
    void allocate(int width_px, int height_px);
    /// Fills ids_ and depth_.
    void draw(Device& device, GpuScene& gpu_scene, const Scene& scene);
    void upload(const View& view, Control& control);

    TextureImage ids_;  ///< RG32UI: instance + 1 (0: nothing is seen), triangle of its mesh
    TextureImage depth_, receiver_;
    RenderTarget ids_target_;
    StorageBuffer instances_;
    std::vector<glm::uvec2> seen_;
    std::vector<glm::uvec4> receivers_;
    bool drawn_ = false, receiver_wanted_ = false, receiver_ready_ = false;
};

}  // namespace penumbra
