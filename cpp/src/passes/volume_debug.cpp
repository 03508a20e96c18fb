#include "passes/volume_debug.h"

#include <algorithm>
#include <cmath>

#include "passes/debug_picture.h"
#include "passes/frame.h"
#include "passes/volume_pass.h"

namespace penumbra {

namespace {

constexpr glm::vec3 kOverdraw{1.0F, 0.9F, 0.1F};

DebugImage wireframe(Frame& frame, VolumePass& volumes) {
    return view_picture(
        frame, "edges of the volumes' triangles: sides, and caps where they are drawn", [&](RenderTarget&) {
            const Program& program = frame.device().programs.get({"passes/volume.vert", "passes/debug_flat.frag"});
            program.set("colour", kOverdraw);
            glPolygonMode(GL_FRONT_AND_BACK, GL_LINE);
            volumes.draw(frame, program);
            glPolygonMode(GL_FRONT_AND_BACK, GL_FILL);
        });
}

}  // namespace

std::vector<DebugView> volume_views() {
    return {{"volumes", "Shadow volumes"}, {"overdraw", "Volume polygons per pixel"}, {"counts", "Counts"}};
}

DebugImage volume_picture(Frame& frame, VolumePass& volumes, std::string_view id) {
    if (id == "volumes") {
        return wireframe(frame, volumes);
    }
    DebugImage image = view_picture(frame, "", [](RenderTarget&) {});
    if (id == "overdraw") {
        const std::vector<float> fragments = volumes.read_overdraw(frame);
        const float most = std::max(1.0F, *std::ranges::max_element(fragments));
        for (std::size_t i = 0; i < image.rgb.size(); ++i) {
            image.rgb[i] = glm::min(0.5F * image.rgb[i] + std::sqrt(fragments[i] / most) * kOverdraw, glm::vec3{1.0F});
        }
        image.caption = "polygons of the volumes drawn at each pixel, yellow; the brightest has " +
                        std::to_string(static_cast<int>(most));
        return image;
    }
    const std::vector<std::int32_t> counts = volumes.read_counts();
    std::int32_t most = 1;
    for (std::size_t i = 0; i < counts.size(); ++i) {
        most = std::max(most, frame.view().hit(i) ? std::abs(counts[i]) : 0);
    }
    for (std::size_t i = 0; i < counts.size(); ++i) {
        if (frame.view().hit(i)) {
            image.rgb[i] = glm::vec3{std::sqrt(static_cast<float>(std::abs(counts[i])) / static_cast<float>(most))};
        } else {
            image.rgb[i] = glm::vec3{0.1F, 0.1F, 0.3F};
        }
    }
    image.caption = "faces of volumes between the light and the surface: black none (lit), white " +
                    std::to_string(most) + "; blue: nothing seen";
    return image;
}

std::vector<Statistic> volume_statistics(Frame& frame, VolumePass& volumes) {
    const std::vector<float> fragments = volumes.read_overdraw(frame);
    double sum = 0.0;
    double covered = 0.0;
    for (const float n : fragments) {
        sum += n;
        covered += n > 0.0F ? 1.0 : 0.0;
    }
    const double pixels = std::max(1.0, static_cast<double>(fragments.size()));
    return {
        {"volume_triangles", "Triangles of the volumes", "triangles", static_cast<double>(volumes.triangle_count())},
        {"volume_fragments", "Fragments of the volumes", "fragments", sum},
        {"overdraw", "Volume fragments per pixel of the picture", "fragments", sum / pixels},
        {"coverage", "Pixels that a volume's polygon covers", "share of the picture", covered / pixels},
        {"layers", "Volumes that may lie in each other", "layers", static_cast<double>(volumes.most_layers())},
        {"counted_in_image", "Counted in 32 bits", "", volumes.in_image() ? 1.0 : 0.0}};
}

}  // namespace penumbra
