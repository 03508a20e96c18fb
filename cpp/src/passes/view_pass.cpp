#include "passes/view_pass.h"

#include <utility>

#include "geometry/seen_surfaces.h"
#include "passes/receiver_texel.h"

namespace penumbra {

namespace {

/// False only if nothing that is seen comes nearer than the near plane or goes beyond the far plane.
bool crosses_range(const GpuScene& gpu_scene, const Scene& scene) {
    const Camera& camera = scene.camera;
    const glm::dvec3 eye_ws{camera.world_from_camera[3]};
    const glm::dvec3 forward_ws = -glm::dvec3{camera.world_from_camera[2]};
    for (std::size_t i = 0; i < scene.instances.size(); ++i) {
        const Bounds& bounds = gpu_scene.instance_bounds_ws()[i];
        const double middle = glm::dot(bounds.centre() - eye_ws, forward_ws);
        const double reach = glm::dot(bounds.half_size(), glm::abs(forward_ws));
        const bool behind = !camera.orthographic && middle + reach < 0.0;
        if (scene.instances[i].visible && !behind &&
            (middle - reach < 1.001 * camera.near_m || middle + reach > 0.999 * camera.far_m)) {
            return true;
        }
    }
    return false;
}

}  // namespace

glm::dmat4 clip_from_rel(const Camera& camera) {
    const double n = camera.near_m;
    const double f = camera.far_m;
    const double aspect = camera.height_px * camera.pixel_aspect / camera.width_px;
    const double half_width = camera.orthographic ? camera.half_width_m : camera.tan_half_width;
    const double half_height = half_width * aspect;
    const glm::dvec2 centre = 2.0 * half_width * camera.shift;
    const glm::dvec2 sample{2.0 * camera.pixel_offset.x / camera.width_px,
                            2.0 * camera.pixel_offset.y / camera.height_px};
    // Rows of the projection, for camera space with z = -distance.
    glm::dmat4 projection{0.0};
    projection[0][0] = 1.0 / half_width;
    projection[1][1] = 1.0 / half_height;
    if (camera.orthographic) {
        projection[3][0] = -centre.x / half_width - sample.x;
        projection[3][1] = -centre.y / half_height - sample.y;
        projection[2][2] = 1.0 / (f - n);
        projection[3][2] = f / (f - n);
        projection[3][3] = 1.0;
    } else {
        projection[2][0] = centre.x / half_width + sample.x;
        projection[2][1] = centre.y / half_height + sample.y;
        projection[2][2] = n / (f - n);
        projection[3][2] = n * f / (f - n);
        projection[2][3] = -1.0;
    }
    const glm::dmat4 camera_from_rel{glm::transpose(glm::dmat3{camera.world_from_camera})};
    return projection * camera_from_rel;
}

void ViewPass::allocate(int width_px, int height_px) {
    if (ids_ && ids_.width() == width_px && ids_.height() == height_px) {
        return;
    }
    ids_ = TextureImage::make_2d(GL_RG32UI, width_px, height_px, "view ids");
    depth_ = TextureImage::make_2d(GL_DEPTH32F_STENCIL8, width_px, height_px, "view depth");
    ids_target_ = RenderTarget{"view ids"};
    ids_target_.attach_colour(0, ids_);
    ids_target_.attach_depth(depth_);
}

void ViewPass::upload(const View& view, Control& control) {
    if (!receiver_ || receiver_.width() != view.width || receiver_.height() != view.height) {
        receiver_ = TextureImage::make_2d(GL_RGBA32UI, view.width, view.height, "view receiver");
    }
    receivers_.resize(view.size());
    receiver_texels(view, receivers_, control);
    receiver_.upload(std::span<const glm::uvec4>{receivers_});
    check_gl("view receiver");
    receiver_ready_ = true;
}

const TextureImage& ViewPass::receiver(const View& view, Control& control) {
    receiver_wanted_ = true;
    if (!receiver_ready_) {
        upload(view, control);
    }
    return receiver_;
}

View ViewPass::render(Device& device, GpuScene& gpu_scene, const Scene& scene, Control& control, View spare) {
    draw(device, gpu_scene, scene);
    seen_.resize(static_cast<std::size_t>(ids_.width()) * static_cast<std::size_t>(ids_.height()));
    ids_.read_into(std::span{seen_});
    View view = place(scene, seen_, control, std::move(spare));
    drawn_ = true;
    return view;
}

View ViewPass::place(const Scene& scene, std::span<const glm::uvec2> seen, Control& control, View spare) {
    drawn_ = receiver_ready_ = false;
    View view = place_surfaces(scene, seen, control, std::move(spare));
    if (receiver_wanted_) {
        upload(view, control);
    }
    return view;
}

const TextureImage& ViewPass::depth_stencil(Device& device, GpuScene& gpu_scene, const Scene& scene) {
    if (!drawn_) {
        draw(device, gpu_scene, scene);
        drawn_ = true;
    }
    return depth_;
}

void ViewPass::draw(Device& device, GpuScene& gpu_scene, const Scene& scene) {
    const Camera& camera = scene.camera;
    allocate(camera.width_px, camera.height_px);

    const auto relative = gpu_scene.relative_to(glm::dvec3{camera.world_from_camera[3]});
    instances_.replace(std::span<const gpu::InstanceBlock>{relative});
    std::vector<std::uint32_t> seen;
    for (std::uint32_t i = 0; i < scene.instances.size(); ++i) {
        if (scene.instances[i].visible) {
            seen.push_back(i);
        }
    }
    // Clipping would make new vertices with other depths, so nearness is cut pixel by pixel, and only where it matters.
    const Defines cut = crosses_range(gpu_scene, scene) ? Defines{{"CUT_RANGE"}} : Defines{};
    const Program& ids = device.programs.get({"passes/view_ids.vert", "passes/view_ids.frag"}, cut);
    ids_target_.bind();
    ids_target_.clear_colour(0, glm::uvec4{0U});
    glClipControl(GL_LOWER_LEFT, GL_ZERO_TO_ONE);
    glEnable(GL_DEPTH_TEST);
    glDepthMask(GL_TRUE);
    glDepthFunc(GL_GREATER);
    glDisable(GL_BLEND);
    glEnable(GL_DEPTH_CLAMP);
    ids_target_.clear_depth_stencil(0.0F, 0);
    ids.set("clip_from_rel", glm::mat4{clip_from_rel(camera)});
    ids.use();
    instances_.bind_storage(0);
    gpu_scene.draw(seen, Cull::None);
    glDisable(GL_DEPTH_CLAMP);
    check_gl("view ids");
}

std::size_t ViewPass::memory_bytes() const noexcept {
    return ids_.bytes() + depth_.bytes() + receiver_.bytes();
}

}  // namespace penumbra
