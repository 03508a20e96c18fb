// Silhouettes that change nothing: found on the device, by cells that nobody looks up or that are black already, and by
// tiles where another slope is darker.
#include <array>
#include <cstddef>

#include "passes/frame.h"
#include "techniques/plateaus/plateaus.h"

namespace penumbra {

namespace {

enum class SiftPass { All, Bound, Cut };  ///< PASS of sift.vert

}  // namespace

bool Plateaus::sifts(const LightSummary& summary, const Layout& layout) const noexcept {
    return !summary.keeps("silhouette-under-umbra") &&
           !slopes_off_planes(layout);  // those read slopes under the umbra too
}

bool Plateaus::cuts_to_tiles(const LightSummary& summary, const Layout& layout) const noexcept {
    return !summary.keeps("slope-never-darkest") && sheets_ == Sheets::Envelope && !slopes_off_planes(layout);
}

void Plateaus::find_covered(Frame& frame, std::size_t plane, bool whole) {
    const glm::ivec2 size{layout_.blocks[plane].size};
    const bool wanted = wanted_ && !whole;
    const bool skipped = skips_umbra() && skip_depth_;  // it holds both: umbra, and what nobody looks up
    bind_block();
    for (int level = 0; level < kLevels; level += 2) {
        const Program& program =
            frame.device().programs.get({"techniques/plateaus/covered.comp"}, {{"LEVEL", std::to_string(level)},
                                                                               {"SKIPPED", skipped ? "1" : "0"},
                                                                               {"WANTED", wanted ? "1" : "0"},
                                                                               {"SIDES", both_sides_ ? "2" : "1"}});
        // Whole cells of the coarsest level, so that each level finds all cells of the one below.
        const glm::ivec2 cells = ((size + 63) / 64) << (4 - level);
        program.set("plane_index", static_cast<int>(plane));
        program.set("cells", cells);
        if (level == 0 && skipped) {
            skip_depth_.bind(4);
        } else if (level == 0) {
            slopes_.bind(4);
            if (wanted) {
                wanted_.bind(6);
            }
        } else {
            covered_.bind(4);
        }
        covered_.bind_image(0, GL_WRITE_ONLY, level);
        program.use();
        const auto groups = (glm::uvec2{cells} + 7U) / 8U;
        glDispatchCompute(groups.x, groups.y, 1);
        StorageBuffer::barrier();
    }
}

void Plateaus::sift(Frame& frame, std::size_t plane, bool keep_all, bool tiles) {
    const std::vector<Draw> all = draws();
    gpu::PlaneDraws counts{};
    glm::ivec3 per_edge{0};
    for (std::size_t i = 0; i < all.size(); ++i) {
        per_edge[static_cast<int>(i)] = all[i].per_edge;
    }
    for (gpu::PlateauDraw& draw : counts.draws) {
        draw.instance_count = 1;
    }
    counts.wide.instance_count = 1;
    draws_.upload(std::span<const gpu::PlaneDraws>{&counts, 1}, plane);
    const bool fans = fans_ || edges_ != EdgeChoice::Silhouettes;
    const bool hull = sheets_ == Sheets::Tessellated || !draws_tight();
    const char* cones = sheets_ == Sheets::Envelope ? (hull ? "0" : "1") : (fans ? "2" : "1");
    silhouettes_.bind(0);
    bind_block();
    listed_.bind_storage(5);
    draws_.bind_storage(6);
    if (!keep_all) {
        covered_.bind(4);
    }
    if (tiles) {
        const glm::ivec2 across =
            (glm::ivec2{layout_.blocks[plane].size} + PENUMBRA_PLATEAU_TILE - 1) / PENUMBRA_PLATEAU_TILE;
        const std::vector<float> lit(static_cast<std::size_t>(across.x) * across.y, 1.0F);
        darkness_.replace(std::span<const float>{lit});
        darkness_.bind_storage(7);
    }
    glEnable(GL_RASTERIZER_DISCARD);
    for (const SiftPass pass : {SiftPass::All, SiftPass::Bound, SiftPass::Cut}) {
        const bool wide = pass != SiftPass::All;
        if ((wide && !tiles) || (pass == SiftPass::Bound && keep_all)) {
            continue;
        }
        Defines more = defines(plane);
        more.insert(more.end(), {{"HULL", hull ? "1" : "0"},
                                 {"CONES", cones},
                                 {"SHEET", sheets_ == Sheets::Envelope ? "0" : "1"},
                                 {"KEEP_ALL", keep_all ? "1" : "0"},
                                 {"TILES", tiles ? "1" : "0"},
                                 {"PASS", std::to_string(static_cast<int>(pass))}});
        const Program& program =
            frame.device().programs.get({"techniques/plateaus/sift.vert", "techniques/plateaus/nothing.frag"}, more);
        program.set("plane_index", static_cast<int>(plane));
        if (pass != SiftPass::Bound) {
            program.set("vertices_per_edge", per_edge);
        }
        if (tiles) {
            program.set("first_wide_entry", static_cast<unsigned>(first_wide()));
        }
        if (pass == SiftPass::Cut) {
            program.set("first_tile_entry", static_cast<unsigned>(first_piece()));
            program.set("most_tile_entries", static_cast<unsigned>(kMostPieces));
        }
        program.use();
        if (wide) {
            glBindVertexArray(no_attributes_.name());
            glBindBuffer(GL_DRAW_INDIRECT_BUFFER, draws_.name());
            glDrawArraysIndirect(GL_POINTS,
                                 buffer_offset(plane * sizeof(gpu::PlaneDraws) + offsetof(gpu::PlaneDraws, wide)));
            glBindVertexArray(0);
        } else {
            silhouettes_.draw(frame, GL_POINTS, 1);
        }
        StorageBuffer::barrier();
    }
    glDisable(GL_RASTERIZER_DISCARD);
}

std::uint64_t Plateaus::first_piece() const noexcept {
    return std::max<std::uint64_t>(1, silhouettes_.capacity());
}

std::uint64_t Plateaus::first_wide() const noexcept {
    return first_piece() + kMostPieces;
}

}  // namespace penumbra
