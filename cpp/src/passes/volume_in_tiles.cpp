// Of VolumePass: only what touches wanted tiles of the picture, sorted on the processor or sifted on the device.

#include <algorithm>

#include "base/parallel.h"
#include "passes/frame.h"
#include "passes/tile_list.h"
#include "passes/volume_jobs.h"
#include "passes/volume_light.h"
#include "passes/volume_pass.h"

namespace penumbra {

void VolumePass::sort_into_tiles(Frame& frame, const VolumeMask& mask) {
    const TileGrid& grid = *mask.tiles;
    std::vector<std::uint8_t> hidden(slots_.size(), 0);
    for (std::size_t i = 0; i < mask.conditions.size(); ++i) {
        if (mask.conditions[i] != 0) {
            GLuint passed = 1;
            glGetQueryObjectuiv(mask.conditions[i], GL_QUERY_RESULT, &passed);
            hidden[i] = passed == 0 ? 1 : 0;
        }
    }
    read_back();
    std::vector<std::int32_t> rectangle_of;
    const std::vector<TileRectangle> rectangles = rectangles_of(grid, rectangle_of);
    // Clip positions of all vertices of all slots, as the vertex shader has them but for rounding.
    const GpuScene& gpu_scene = frame.gpu_scene();
    const glm::dvec3 eye_ws = frame.summary().eye_ws;
    const glm::dvec4 light_ws = homogeneous_centre(frame.light());
    const glm::dvec4 light{glm::dvec3{light_ws} - light_ws.w * eye_ws, light_ws.w};
    const double share = far_share(frame.summary(), light_ws);
    const glm::dmat4 clip = clip_from_rel(frame.scene().camera);
    std::map<std::uint32_t, std::vector<glm::dvec4>> placed;
    for (const Slot& slot : slots_) {
        glm::dmat4 m = gpu_scene.world_from_recentred(slot.instance);
        m[3] -= glm::dvec4{eye_ws, 0.0};
        const Mesh& mesh = *meshes_[slot.mesh];
        const glm::dvec3 centre = gpu_scene.mesh_ranges()[slot.mesh].centre_local;
        std::vector<glm::dvec4>& positions = placed[slot.instance];
        positions.resize(2 * mesh.positions_local.size());
        for (std::size_t v = 0; v < mesh.positions_local.size(); ++v) {
            const glm::dvec3 p{m * glm::dvec4{glm::dvec3{mesh.positions_local[v]} - centre, 1.0}};
            positions[2 * v] = clip * glm::dvec4{p, 1.0};
            const glm::dvec3 along = light.w * p - glm::dvec3{light};
            positions[2 * v + 1] = clip * glm::dvec4{along + share * (light.w > 0.5 ? glm::dvec3{light} : p), share};
        }
    }
    // Which triangles each rectangle draws, in pieces so that threads share the work.
    struct Piece {
        std::uint32_t command = 0, first = 0, count = 0;
        std::vector<glm::uvec2> pairs;  ///< rectangle, triangle of the index list
    };
    std::vector<Piece> pieces;
    constexpr std::uint32_t kPiece = 2048;
    for (std::uint32_t c = 0; c < drawn_.size(); ++c) {
        const bool drawn = hidden[slot_of_instance_.at(drawn_[c].base_instance)] == 0;
        for (std::uint32_t first = 0; drawn && first < drawn_[c].count / 3; first += kPiece) {
            pieces.push_back({c, first, std::min(kPiece, drawn_[c].count / 3 - first), {}});
        }
    }
    std::vector<std::uint8_t> z_pass(drawn_.size(), 0);
    for (const Group& group : groups_) {
        std::fill_n(z_pass.begin() + static_cast<std::ptrdiff_t>(group.first), group.count, group.z_pass ? 1 : 0);
    }
    const TileWalker all_tiles{grid};
    parallel_for(
        static_cast<std::int64_t>(pieces.size()), 1,
        [&](std::int64_t begin, std::int64_t end) {
            TileWalker walker = all_tiles;  // each thread its own
            std::vector<std::uint32_t> tiles;
            std::vector<std::uint32_t> last(rectangles.size(), 0xffffffffU);
            for (auto i = begin; i < end; ++i) {
                Piece& piece = pieces[static_cast<std::size_t>(i)];
                const DrawCommand& command = drawn_[piece.command];
                const std::vector<glm::dvec4>& positions = placed.at(command.base_instance);
                const std::uint32_t base =
                    2 * gpu_scene.mesh_ranges()[gpu_scene.mesh_of_instance(command.base_instance)].first_vertex;
                std::ranges::fill(last, 0xffffffffU);
                for (std::uint32_t t = piece.first; t < piece.first + piece.count; ++t) {
                    const std::uint32_t* corner = found_indices_.data() + command.first_index + std::size_t{3} * t;
                    tiles.clear();
                    walker.walk(positions[corner[0] - base], positions[corner[1] - base], positions[corner[2] - base],
                                z_pass[piece.command] != 0, tiles);
                    for (const std::uint32_t tile : tiles) {
                        const auto rectangle = static_cast<std::uint32_t>(rectangle_of[tile]);
                        if (last[rectangle] != t) {
                            last[rectangle] = t;
                            piece.pairs.emplace_back(rectangle, command.first_index / 3 + t);
                        }
                    }
                }
            }
        },
        frame.control());

    // By rectangle, then by command, which is the order of the groups.
    std::vector<std::uint32_t> first_of(rectangles.size() + 1, 0);
    for (const Piece& piece : pieces) {
        for (const glm::uvec2& pair : piece.pairs) {
            ++first_of[pair.x + 1];
        }
    }
    for (std::size_t i = 1; i < first_of.size(); ++i) {
        first_of[i] += first_of[i - 1];
    }
    std::vector<std::uint32_t> next(first_of.begin(), first_of.end() - 1);
    std::vector<glm::uvec2> sorted(first_of.back());  // triangle, command
    for (const Piece& piece : pieces) {
        for (const glm::uvec2& pair : piece.pairs) {
            sorted[next[pair.x]++] = {pair.y, piece.command};
        }
    }
    std::vector<std::uint32_t> indices(3 * sorted.size());
    for (std::size_t i = 0; i < sorted.size(); ++i) {
        std::copy_n(found_indices_.begin() + 3 * static_cast<std::ptrdiff_t>(sorted[i].x), 3,
                    indices.begin() + 3 * static_cast<std::ptrdiff_t>(i));
    }
    drawn_in_tiles_ = sorted.size();
    std::vector<std::uint32_t> group_of(drawn_.size(), 0);
    for (std::uint32_t g = 0; g < groups_.size(); ++g) {
        std::fill_n(group_of.begin() + static_cast<std::ptrdiff_t>(groups_[g].first), groups_[g].count, g);
    }
    std::vector<DrawCommand> commands;
    cells_.clear();
    for (std::size_t r = 0; r < rectangles.size(); ++r) {
        if (first_of[r] == first_of[r + 1]) {
            continue;
        }
        constexpr int kTile = TileGrid::kTile_px;
        const TileRectangle& rectangle = rectangles[r];
        Cell cell;
        cell.scissor = {rectangle.column * kTile, rectangle.row * kTile, rectangle.columns * kTile,
                        rectangle.rows * kTile};
        std::uint32_t last_command = 0xffffffffU;
        std::uint32_t last_group = 0xffffffffU;
        for (std::uint32_t i = first_of[r]; i < first_of[r + 1]; ++i) {
            const std::uint32_t command = sorted[i].y;
            if (command != last_command) {
                if (group_of[command] != last_group) {
                    last_group = group_of[command];
                    cell.groups.push_back(groups_[last_group]);
                    cell.groups.back().first = commands.size();
                    cell.groups.back().count = 0;
                }
                ++cell.groups.back().count;
                commands.push_back({0, 1, 3 * i, 0, drawn_[command].base_instance});
                last_command = command;
            }
            commands.back().count += 3;
        }
        cells_.push_back(std::move(cell));
    }
    cell_indices_ = StorageBuffer::from(indices, "volume indices by tiles");
    cell_commands_ = StorageBuffer::from(commands, "volume draws by tiles");
    cell_vertex_array_ = make_vertex_array(cell_indices_);
}

void VolumePass::draw_in_tiles(const Program& program) const {
    glBindVertexArray(cell_vertex_array_.name());
    glBindBuffer(GL_DRAW_INDIRECT_BUFFER, cell_commands_.name());
    for (const Cell& cell : cells_) {
        const glm::ivec2 low = glm::max(glm::ivec2{cell.scissor}, glm::ivec2{scissor_});
        const glm::ivec2 high = glm::min(glm::ivec2{cell.scissor} + glm::ivec2{cell.scissor.z, cell.scissor.w},
                                         glm::ivec2{scissor_} + glm::ivec2{scissor_.z, scissor_.w});
        if (low.x >= high.x || low.y >= high.y) {
            continue;
        }
        glScissor(low.x, low.y, high.x - low.x, high.y - low.y);
        for (const Group& group : cell.groups) {
            set_state(group, program);
            issue(group);
        }
    }
}

/// On the device: the index lists again, without the triangles that no wanted tile needs.
void VolumePass::sift_by_tiles(Frame& frame, const TileList& tiles) {
    std::vector<gpu::VolumeSiftJob> jobs;
    std::vector<DrawCommand> kept = drawn_;
    std::uint64_t room = 0;
    for (const Group& group : groups_) {
        for (std::size_t c = group.first; c < group.first + group.count; ++c) {
            kept[c].count = 0;
            room = std::max<std::uint64_t>(room, std::uint64_t{drawn_[c].first_index} + most_in_command_[c]);
            constexpr std::uint32_t kTriangles = 4 * kVolumeGroupSize;
            for (std::uint32_t first = 0; first < most_in_command_[c] / 3; first += kTriangles) {
                jobs.push_back({static_cast<std::uint32_t>(c), first, kTriangles, group.z_pass ? 1U : 0U});
            }
        }
    }
    kept_commands_.replace(std::span<const DrawCommand>{kept});
    if (!kept_indices_ || kept_indices_.bytes() < room * sizeof(std::uint32_t)) {
        kept_indices_ = StorageBuffer();
        kept_indices_ = StorageBuffer(room * sizeof(std::uint32_t), "volume indices in tiles");
    }
    kept_vertex_array_ = make_vertex_array(kept_indices_);
    if (jobs.empty()) {
        return;
    }
    sift_jobs_.replace(std::span<const gpu::VolumeSiftJob>{jobs});
    Defines defines = TileList::defines();
    defines.push_back({"GROUP_SIZE", std::to_string(kVolumeGroupSize) + "u"});
    const Program& program = frame.device().programs.get({"passes/volume_sift.comp"}, defines);
    set_uniforms(frame, program);
    program.set("size_px", glm::vec2{static_cast<float>(frame.view().width), static_cast<float>(frame.view().height)});
    program.set("job_count", static_cast<unsigned>(jobs.size()));
    program.use();
    tiles.bind_storage();
    instances_.bind_storage(1);
    vertices_.bind_storage(2);
    sift_jobs_.bind_storage(3);
    indices_.bind_storage(4);
    commands_.bind_storage(5);
    kept_indices_.bind_storage(6);
    kept_commands_.bind_storage(7);
    dispatch_groups(jobs.size());
    StorageBuffer::barrier();
}

std::uint64_t VolumePass::drawn_of_list() const {
    std::uint64_t triangles = 0;
    if (kept_commands_) {
        for (const DrawCommand& command : kept_commands_.read<DrawCommand>()) {
            triangles += command.count / 3;
        }
    }
    return triangles;
}

}  // namespace penumbra
