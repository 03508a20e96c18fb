// What the hard shadow map costs beyond the OpenGL work that no implementation can avoid: one depth pass over the same
// triangles and one full-screen lookup with one comparison, both written as barely as possible. Both sides are
// measured in turns in one run, on the same device, and the last lines print the ratio of the medians: target 1.3.

#include <chrono>
#include <cstdio>
#include <memory>

#include "gl/buffer.h"
#include "gl/framebuffer.h"
#include "gl/render_thread.h"
#include "penumbra/renderer.h"
#include "support/scenes.h"

namespace penumbra {
namespace {

using Clock = std::chrono::steady_clock;

constexpr int kSide_px = 512;
constexpr int kMap_px = 1024;

Scene ball_over_ground(int rings) {
    Scene scene;
    scene.instances.push_back(scenes::place(scenes::sheet(-20, 20, -20, 20), "ground"));
    scene.instances.push_back(scenes::place(scenes::sphere(rings, false), "ball", {0.3, 0.2, 1.4}));
    scene.lights.push_back(scenes::rectangle_light({0.5, -0.5, 6.0}, 1.0, 1.0));
    const double a = 0.8;
    const glm::dmat4 tilt{
        {1, 0, 0, 0}, {0, std::cos(a), std::sin(a), 0}, {0, -std::sin(a), std::cos(a), 0}, {0, 0, 0, 1}};
    scene.camera.world_from_camera = tilt;
    scene.camera.world_from_camera[3] = tilt * glm::dvec4{0, 0, 9, 1};
    scene.camera.tan_half_width = 0.4;
    scene.camera.width_px = scene.camera.height_px = kSide_px;
    return scene;
}

const ShaderSources& bare_shaders() {
    static const ShaderSources sources{
        {"depth.vert",
         "layout(location = 0) in vec3 p; uniform mat4 m; void main() { gl_Position = m * vec4(p, 1.0); }"},
        {"depth.frag", "void main() {}"},
        {"full.vert",
         "void main() { vec2 c = vec2((gl_VertexID << 1) & 2, gl_VertexID & 2); gl_Position = vec4(c * 2.0 - 1.0, 0.5, "
         "1.0); }"},
        {"lookup.frag",
         "layout(binding = 0) uniform sampler2D position; layout(binding = 1) uniform sampler2D depth; uniform mat4 "
         "m;\n"
         "layout(location = 0) out float v;\n"
         "void main() {\n"
         "    vec4 p = texelFetch(position, ivec2(gl_FragCoord.xy), 0);\n"
         "    vec4 q = m * vec4(p.xyz, 1.0);\n"
         "    vec3 c = q.xyz / q.w;\n"
         "    float d = texelFetch(depth, clamp(ivec2((c.xy * 0.5 + 0.5) * 1024.0), ivec2(0), ivec2(1023)), 0).r;\n"
         "    v = c.z + 1e-4 >= d ? 1.0 : 0.0;\n"
         "}"},
    };
    return sources;
}

/// The bare frame: geometry in one buffer, matrices made beforehand, no uniforms but one matrix a pass.
struct Bare {
    ProgramLibrary programs{bare_shaders()};
    StorageBuffer vertices, indices;
    VertexArray mesh, empty;
    TextureImage map, position, visibility;
    RenderTarget map_target, visibility_target;
    glm::mat4 clip_from_world{1.0F};
    int index_count = 0;

    Bare(const Scene& scene, const View& view) {
        std::vector<glm::vec3> points;
        std::vector<std::uint32_t> corners;
        for (const Instance& instance : scene.instances) {
            const auto first = static_cast<std::uint32_t>(points.size());
            for (const glm::vec3& p : instance.mesh->positions_local) {
                points.emplace_back(instance.world_from_local * glm::dvec4{glm::dvec3{p}, 1.0});
            }
            for (const glm::uvec3& t : instance.mesh->triangles) {
                corners.insert(corners.end(), {first + t.x, first + t.y, first + t.z});
            }
        }
        vertices = StorageBuffer::from(points, "vertices");
        indices = StorageBuffer::from(corners, "indices");
        index_count = static_cast<int>(corners.size());
        mesh = VertexArray::create();
        empty = VertexArray::create();
        glVertexArrayVertexBuffer(mesh.name(), 0, vertices.name(), 0, sizeof(glm::vec3));
        glVertexArrayAttribFormat(mesh.name(), 0, 3, GL_FLOAT, GL_FALSE, 0);
        glVertexArrayAttribBinding(mesh.name(), 0, 0);
        glEnableVertexArrayAttrib(mesh.name(), 0);
        glVertexArrayElementBuffer(mesh.name(), indices.name());
        map = TextureImage::make_2d(GL_DEPTH_COMPONENT32F, kMap_px, kMap_px, "map");
        map_target = RenderTarget{"map"};
        map_target.attach_depth(map);
        std::vector<glm::vec4> seen;
        for (const glm::vec3& p : view.position_cr) {
            seen.emplace_back(glm::vec3{view.eye_ws} + p, 1.0F);
        }
        position = TextureImage::make_2d(GL_RGBA32F, kSide_px, kSide_px, "position");
        position.upload(std::span<const glm::vec4>{seen});
        visibility = TextureImage::make_2d(GL_R32F, kSide_px, kSide_px, "visibility");
        visibility_target = RenderTarget{"visibility"};
        visibility_target.attach_colour(0, visibility);
        // From the light straight down: x, y over the distance, reversed depth 1 / distance.
        const glm::vec3 light{scene.lights[0].position_ws};
        clip_from_world = glm::mat4{0.0F};
        clip_from_world[0][0] = clip_from_world[1][1] = 1.0F;
        clip_from_world[2][3] = -1.0F;
        clip_from_world[3] = glm::vec4{-light.x, -light.y, 1.0F, light.z};
    }

    double frame() {
        glFinish();
        const auto started = Clock::now();
        const Program& depth = programs.get({"depth.vert", "depth.frag"});
        map_target.bind();
        glClipControl(GL_LOWER_LEFT, GL_ZERO_TO_ONE);
        glEnable(GL_DEPTH_TEST);
        glDepthMask(GL_TRUE);
        glDepthFunc(GL_GREATER);
        map_target.clear_depth(0.0F);
        depth.set("m", clip_from_world);
        depth.use();
        glBindVertexArray(mesh.name());
        glDrawElements(GL_TRIANGLES, index_count, GL_UNSIGNED_INT, nullptr);
        const Program& lookup = programs.get({"full.vert", "lookup.frag"});
        visibility_target.bind();
        glDisable(GL_DEPTH_TEST);
        lookup.set("m", clip_from_world);
        lookup.use();
        position.bind(0);
        map.bind(1);
        glBindVertexArray(empty.name());
        glDrawArrays(GL_TRIANGLES, 0, 3);
        glFinish();
        return std::chrono::duration<double, std::milli>(Clock::now() - started).count();
    }
};

void compare(int rings) {
    const Scene scene = ball_over_ground(rings);
    Control control;
    Renderer renderer;
    renderer.set_scene(scene);
    const auto view = renderer.view(control);
    std::size_t triangles = 0;
    for (const Instance& instance : scene.instances) {
        triangles += instance.mesh->triangles.size();
    }
    RenderThread thread;
    std::unique_ptr<Bare> bare = thread.run([&](Device&) { return std::make_unique<Bare>(scene, *view); });
    const std::vector<Job> jobs{{"shadow_map", {{"map_size", kMap_px}}}};
    TimingOptions few;
    few.warm_up = 1;
    few.min_runs = few.max_runs = 5;
    std::vector<double> ours, ours_static, theirs;
    for (int round = 0; round < 30; ++round) {
        const Measurement m = renderer.measure(0, jobs, false, few, control).front();
        ours.push_back(m.dynamic_frame.median);
        ours_static.push_back(m.static_frame.median);
        for (int i = 0; i < 5; ++i) {
            theirs.push_back(thread.run([&](Device&) { return bare->frame(); }));
        }
    }
    thread.run([&](Device&) { bare.reset(); });
    const TimeSummary a = summarise_times(ours), b = summarise_times(theirs), s = summarise_times(ours_static);
    std::printf(
        "%7zu triangles: shadow_map dynamic %.2f ms, static %.2f ms; bare depth pass + lookup %.2f ms; ratio %.2f\n",
        triangles, a.median, s.median, b.median, a.median / b.median);
}

}  // namespace
}  // namespace penumbra

int main() {
    try {
        penumbra::Renderer renderer;
        std::printf("%s, %d threads, view %d x %d, map %d\n", renderer.environment().gl_renderer.c_str(),
                    renderer.environment().threads, penumbra::kSide_px, penumbra::kSide_px, penumbra::kMap_px);
    } catch (const penumbra::Error& error) {
        std::fprintf(stderr, "frame_bench: %s\n", error.what());
        return 1;
    }
    for (const int rings : {54, 112}) {  // 11,450 and 49,730 triangles
        penumbra::compare(rings);
    }
    return 0;
}
