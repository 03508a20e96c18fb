#include "passes/volume_pass.h"

#include <algorithm>

#include "passes/frame.h"
#include "passes/volume_eye.h"
#include "scene/setting_forms.h"

namespace penumbra {

namespace {

/// Of the light's mask, in pixels: x, y, width, height.
glm::ivec4 rectangle_of(const LightSummary& summary, int width, int height) {
    glm::ivec2 low{width, height};
    glm::ivec2 high{-1};
    for (int y = 0; y < height; ++y) {
        const auto row = summary.mask.begin() + static_cast<std::ptrdiff_t>(y) * width;
        const auto first = std::find(row, row + width, std::uint8_t{1});
        if (first == row + width) {
            continue;
        }
        int last = width - 1;
        while (row[last] == 0) {
            --last;
        }
        low = glm::min(low, glm::ivec2{static_cast<int>(first - row), y});
        high = glm::max(high, glm::ivec2{last, y});
    }
    return high.x < 0 ? glm::ivec4{0} : glm::ivec4{low, high - low + 1};
}

}  // namespace

bool VolumePass::needs_no_caps(const LightSummary& summary, std::size_t caster) const {
    // An unseen caster has no surface that its near cap could fall on.
    return options_.leave_out_caps && !summary.keeps("eye-outside-volume") &&
           summary.scene->instances[summary.casters[caster]].visible &&
           eye_is_outside(summary.caster_bounds_ws[caster], summary.scene->camera, *summary.light);
}

bool VolumePass::plan(const LightSummary& summary, std::string_view lookup, Plan& plan) const {
    const LightSummary::Trivial trivial = summary.trivial();
    if (!trivial.reason.empty()) {
        for (const std::string_view step : {std::string_view{"volumes"}, std::string_view{"count"}, lookup}) {
            plan.leave_out(std::string{step}, trivial.rule, trivial.reason);
        }
        return false;
    }
    plan.run("volumes");
    std::size_t without_caps = 0;
    for (std::size_t i = 0; i < summary.casters.size(); ++i) {
        without_caps += needs_no_caps(summary, i) ? 1 : 0;
    }
    if (without_caps > 0) {
        plan.leave_out("caps", "eye-outside-volume",
                       std::to_string(without_caps) + " of " + std::to_string(summary.casters.size()) +
                           " casters lie apart from the space between the light and the eye, so their sides alone are "
                           "counted, in front of what is seen");
    }
    if (summary.casters_outside > 0) {
        plan.leave_out("casters out of reach", "caster-outside-hull",
                       std::to_string(summary.casters_outside) +
                           " casters lie outside the space between the light and the visible receivers");
    }
    plan.run("count");
    plan.run(std::string{lookup});
    return true;
}

void VolumePass::send_vertices(const GpuScene& gpu_scene) {
    if (vertices_ && meshes_ == gpu_scene.meshes()) {
        return;
    }
    makers_.clear();
    meshes_ = gpu_scene.meshes();
    std::vector<glm::vec4> vertices;
    for (std::size_t i = 0; i < meshes_.size(); ++i) {
        if (!gpu_scene.mesh_ranges()[i].sent) {
            continue;
        }
        for (const glm::vec3& p : meshes_[i]->positions_local) {
            const glm::vec3 recentred{glm::dvec3{p} - gpu_scene.mesh_ranges()[i].centre_local};
            vertices.emplace_back(recentred, 1.0F);
            vertices.emplace_back(recentred, 0.0F);
        }
    }
    vertices_ = StorageBuffer::from(vertices, "volume vertices");
}

void VolumePass::prepare(Frame& frame) {
    const GpuScene& gpu_scene = frame.gpu_scene();
    const LightSummary& summary = frame.summary();
    on_cpu_ = options_.source == SilhouettePass::Source::Cpu ||
              (options_.source == SilhouettePass::Source::Auto && frame.device().context.info().software);
    send_vertices(gpu_scene);
    const GpuAdjacency& adjacency = frame.adjacency();
    slots_.clear();
    slot_of_instance_.clear();
    for (std::size_t i = 0; i < summary.casters.size(); ++i) {
        const std::uint32_t instance = summary.casters[i];
        const std::uint32_t mesh = gpu_scene.mesh_of_instance(instance);
        slot_of_instance_[instance] = static_cast<std::uint32_t>(slots_.size());
        slots_.push_back({instance, mesh, needs_no_caps(summary, i)});
        if (!makers_.contains(mesh)) {
            makers_.emplace(mesh, std::make_unique<VolumeMaker>(*meshes_[mesh], adjacency.of_mesh(mesh)));
        }
    }
    std::vector<std::uint32_t> numbers(gpu_scene.instance_count());
    for (std::uint32_t i = 0; i < numbers.size(); ++i) {
        numbers[i] = i;
    }
    instance_numbers_ = StorageBuffer::from(numbers, "instance numbers");
    scissor_ = rectangle_of(summary, frame.view().width, frame.view().height);
    if (!commands_) {
        commands_ = StorageBuffer(sizeof(DrawCommand), "volume draws");
        indices_ = StorageBuffer(sizeof(std::uint32_t), "volume indices");
    }
}

VertexArray VolumePass::make_vertex_array(const StorageBuffer& indices) const {
    VertexArray made = VertexArray::create();
    const GLuint vao = made.name();
    glVertexArrayVertexBuffer(vao, 0, vertices_.name(), 0, sizeof(glm::vec4));
    glVertexArrayAttribFormat(vao, 0, 4, GL_FLOAT, GL_FALSE, 0);
    glVertexArrayAttribBinding(vao, 0, 0);
    glEnableVertexArrayAttrib(vao, 0);
    glVertexArrayVertexBuffer(vao, 1, instance_numbers_.name(), 0, sizeof(std::uint32_t));
    glVertexArrayAttribIFormat(vao, 1, 1, GL_UNSIGNED_INT, 0);
    glVertexArrayAttribBinding(vao, 1, 1);
    glVertexArrayBindingDivisor(vao, 1, 1);
    glEnableVertexArrayAttrib(vao, 1);
    glVertexArrayElementBuffer(vao, indices.name());
    return made;
}

std::size_t VolumePass::bytes() const noexcept {
    std::size_t bytes = vertices_.bytes() + instance_numbers_.bytes() + indices_.bytes() + commands_.bytes() +
                        instances_.bytes() + kept_indices_.bytes() + kept_commands_.bytes() +
                        (counts_ ? counts_.bytes() : 0);
    for (const auto& [mesh, maker] : makers_) {
        bytes += maker->bytes();
    }
    return bytes;
}

std::vector<SettingInfo> volume_settings() {
    return {
        choice_setting("faces", "Triangles of the volumes",
                       "light_facing: those whose front faces the light, right for closed meshes with outward normals; "
                       "all: every triangle, right for whatever mesh; auto: the fewest that are right, mesh by mesh.",
                       {"auto", "light_facing", "all"}),
        choice_setting("counting", "Counting",
                       "stencil: modulo 256 (hybrid: 128); image: 32-bit counts, slower; auto: stencil unless more "
                       "volumes may lie in each other than it can count.",
                       {"auto", "stencil", "image"}),
        silhouette_setting(),
    };
}

VolumePass::Options volume_options(const Settings& settings) {
    VolumePass::Options options;
    options.source = silhouette_source(settings);
    const std::string& faces = get_choice(settings, "faces");
    options.faces = faces == "all"            ? VolumePass::Faces::All
                    : faces == "light_facing" ? VolumePass::Faces::LightFacing
                                              : VolumePass::Faces::Auto;
    const std::string& counting = get_choice(settings, "counting");
    options.counting = counting == "image"     ? VolumePass::Counting::Image
                       : counting == "stencil" ? VolumePass::Counting::Stencil
                                               : VolumePass::Counting::Auto;
    return options;
}

}  // namespace penumbra
