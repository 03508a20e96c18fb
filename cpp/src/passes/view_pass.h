#pragma once

#include "gl/framebuffer.h"
#include "gl/render_thread.h"
#include "gl/texture.h"
#include "passes/fullscreen.h"
#include "passes/gpu_scene.h"
#include "penumbra/view.h"

namespace penumbra {

/// Reversed depth (1 near, 0 far) of the camera's view of a point relative to the eye, world axes.
[[nodiscard]] glm::dmat4 clip_from_rel(const Camera& camera);

/// The G-buffer on the device. Two passes: which triangle is seen, then its position and normals in float64.
class ViewPass {
public:
    /// Makes the textures of the camera's size if they are not there, and renders. Ends with the GPU busy.
    void render(Device& device, GpuScene& gpu_scene, const Scene& scene, FullscreenPass& fullscreen);

    [[nodiscard]] const TextureImage& position() const noexcept { return position_; }       ///< RGBA32F, w 1 where seen
    [[nodiscard]] const TextureImage& normal() const noexcept { return normal_; }           ///< RGBA32F, geometric
    [[nodiscard]] const TextureImage& shading_normal() const noexcept { return shading_; }  ///< RGBA32F
    [[nodiscard]] const TextureImage& albedo() const noexcept { return albedo_; }           ///< RGBA32F, linear
    [[nodiscard]] const TextureImage& ids() const noexcept { return ids_; }                 ///< RG32UI
    [[nodiscard]] const TextureImage& receiver() const noexcept { return receiver_; }       ///< see lib/receiver.glsl
    /// DEPTH32F_STENCIL8: reversed depth (1 near, 0 far or nothing), drawn by view_ids.vert with depth clamp on, so
    /// that a pass which places vertices by the same expression and clamps as well gets the same bits. The stencil is
    /// whose turn it is: clear it first, leave the depth as it is.
    [[nodiscard]] const TextureImage& depth_stencil() const noexcept { return depth_; }
    [[nodiscard]] const glm::dvec3& eye_ws() const noexcept { return eye_ws_; }

    /// Copy in main memory; waits for the GPU.
    [[nodiscard]] View read() const;
    [[nodiscard]] std::size_t memory_bytes() const noexcept;

private:
    void allocate(int width_px, int height_px);

    TextureImage ids_, depth_, position_, normal_, shading_, albedo_, receiver_;
    RenderTarget ids_target_, surface_target_;
    StorageBuffer instances_, exact_instances_;
    glm::dvec3 eye_ws_{0.0};
};

}  // namespace penumbra
