#include "reference/masked_tracer.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <bit>
#include <cmath>
#include <numeric>
#include <vector>

#include "base/assert.h"
#include "base/parallel.h"
#include "reference/for_tiles.h"
#include "reference/light_points.h"
#include "reference/mixed_pixels.h"
#include "reference/sampling.h"
#include "reference/scrambled_net.h"
#include "reference/shared_fit.h"
#include "reference/strata_board.h"

namespace penumbra {
namespace {

/// Streams of random numbers; the reference has 1 and 2, pilot rays 6.
constexpr std::uint32_t kFirstStream = 3;
constexpr std::uint32_t kBoardStream = 4;
constexpr std::uint32_t kFineStream = 5;
constexpr int kOpenRadius = 2;  // pixels
/// With `share`, of the first rays: those that say whether there is a penumbra at all.
constexpr int kBeginRays = 4;
constexpr int kEnoughToAgree = 8;
/// Of V, per pixel: the penumbra is narrower than seven pixels, and its ends bend the plane.
constexpr float kSteep = 0.15F;
/// Of V, per pixel: the penumbra is narrower than five pixels, and most pixels beside it see all or nothing.
constexpr float kSharp = 0.2F;
/// Of the noise of n first rays in a penumbra, 0.37 n^-0.75: more scatter around the plane is no noise.
constexpr double kScatter = 1.4;
/// Of that: beyond it the plane is worse than the pixel's own rays, even if no more follow.
constexpr float kRough = 1.3F;

bool is_power_of_two(int x) noexcept {
    return std::has_single_bit(static_cast<unsigned>(x));
}

int bits_of(int power_of_two) noexcept {
    return std::countr_zero(static_cast<unsigned>(power_of_two));
}

/// Calls visit(index) for the pixels around one, not itself.
template <class Visit>
void around(const View& view, std::size_t pixel, int radius, const Visit& visit) {
    const auto width = static_cast<std::size_t>(view.width);
    const int x = static_cast<int>(pixel % width);
    const int y = static_cast<int>(pixel / width);
    for (int ny = std::max(0, y - radius); ny <= std::min(view.height - 1, y + radius); ++ny) {
        for (int nx = std::max(0, x - radius); nx <= std::min(view.width - 1, x + radius); ++nx) {
            const std::size_t i = static_cast<std::size_t>(ny) * width + static_cast<std::size_t>(nx);
            if (i != pixel) {
                visit(i);
            }
        }
    }
}

/// Whether the pixels around leave it open whether all is lit or all dark.
bool open_around(const View& view, std::span<const float> visibility, std::size_t pixel) {
    float least = 2.0F;
    float most = -1.0F;
    around(view, pixel, kOpenRadius, [&](std::size_t i) {
        if (visibility[i] >= 0.0F) {
            least = std::min(least, visibility[i]);
            most = std::max(most, visibility[i]);
        }
    });
    return least < most || (most > 0.0F && most < 1.0F) || most < 0.0F;
}

class MaskedTrace {
public:
    MaskedTrace(const RayScene& rays, const View& view, const Light& light, std::span<const std::uint8_t> listed,
                const MaskedTraceOptions& options, Control& control)
        : rays_{rays},
          view_{view},
          listed_{listed},
          options_{options},
          control_{control},
          points_{light, rays.frame()} {}

    MaskedTraceCounts run(std::span<float> visibility) {
        MaskedTraceCounts counts;
        counts.pixels = static_cast<std::uint64_t>(std::ranges::count(listed_, 1));
        const int first = points_.single_point() ? 1 : std::min(options_.rays, options_.first_rays);
        const bool more = !points_.single_point() && options_.rays > first;
        if (!points_.single_point() && options_.share > 0) {
            share(first, more, counts, visibility);
        } else {
            trace_walk(listed_, {.count = first, .of = first, .stream = kFirstStream}, visibility);
            if (more) {
                trace_rest(open_pixels(visibility), counts, visibility);
            }
        }
        counts.rays = rays_cast_;
        return counts;
    }

private:
    /// Rays [first, first + count) of the `of` that a pixel may cast.
    struct Walk {
        int first = 0, count = 1, of = 1;
        std::uint32_t stream = 0;
        bool interleaved = false;  ///< the pixels of a 4 x 4 block differ as much as they can
        int part_bits = 0;         ///< of 2^part_bits parts each is spread evenly by itself

        [[nodiscard]] Walk next(int rays) const {
            Walk walk = *this;
            walk.first += count;
            walk.count = rays;
            return walk;
        }
    };

    /// The samples of one pixel: a net of points, or cells where the count is no power of two or the light a line.
    class Samples {
    public:
        Samples(const Walk& walk, bool line, std::uint32_t base)
            : first_{walk.first},
              count_{walk.of},
              bits_{bits_of(walk.of)},
              part_bits_{walk.part_bits},
              net_{!line && is_power_of_two(walk.of) && bits_ <= 16},
              interleaved_{walk.interleaved},
              base_{base} {
            if (!net_) {
                strata_ = make_strata(count_, line);
                return;
            }
            const ScrambledNet plain{bits_, 0};
            for (int k = walk.first; k < walk.first + walk.count && part_bits_ > 0; ++k) {
                in_parts_.push_back(plain.point(plain.in_parts(static_cast<std::uint32_t>(k), part_bits_)));
            }
        }
        [[nodiscard]] bool is_net() const noexcept { return net_; }
        /// @param width  of the view
        void start(std::uint32_t pixel, std::uint32_t width) noexcept {
            if (!net_) {
                return;
            }
            std::uint32_t key = sequence_key(pixel, mix(base_));
            if (interleaved_) {
                // The nets of the pixels of a 4 x 4 block are shifted by all multiples of a quarter of the light.
                constexpr std::uint32_t kQuarters = 0xC000C000U;
                const std::uint32_t place = (pixel % width & 3U) << 14U | (pixel / width & 3U) << 30U;
                key = (key & ~kQuarters) | ((place ^ mix(base_ + 1U)) & kQuarters);
            }
            points_ = ScrambledNet{bits_, key};
        }
        [[nodiscard]] const ScrambledNet& points() const noexcept { return points_; }
        [[nodiscard]] CellRay cell(std::uint32_t k) const noexcept {
            CellRay ray;
            ray.index = k;
            if (net_) {
                const ScrambledNet::Cell at = part_bits_ > 0
                                                  ? points_.shifted(in_parts_[k - static_cast<std::uint32_t>(first_)])
                                                  : points_.point(k);
                ray.width = ray.height = 1.0F / static_cast<float>(count_);
                ray.u = static_cast<float>(at.u) * ray.width;
                ray.v = static_cast<float>(at.v) * ray.height;
            } else {
                ray.u = strata_.u[k];
                ray.v = strata_.v[k];
                ray.width = strata_.width[k];
                ray.height = strata_.height[k];
            }
            return ray;
        }

    private:
        int first_, count_, bits_, part_bits_;
        bool net_, interleaved_;
        std::uint32_t base_;
        Strata strata_;
        ScrambledNet points_{0, 0};
        std::vector<ScrambledNet::Cell> in_parts_;  ///< before the pixel's own scrambling
    };

    [[nodiscard]] Samples samples(const Walk& walk) const {
        return {walk, points_.one_dimensional(), sequence_base(options_.seed, walk.stream)};
    }

    /// Sets V of the listed pixels to the share of their rays that got through.
    /// @param before  V by the rays before walk.first, where there are any; may be `visibility` itself
    void trace_walk(std::span<const std::uint8_t> listed, const Walk& walk, std::span<float> visibility,
                    std::span<const float> before = {}) {
        trace_equally(listed, walk, [&](std::uint32_t pixel, std::span<const std::uint8_t> seen) {
            const auto all = static_cast<float>(walk.first + walk.count);
            const float earlier = walk.first > 0 ? before[pixel] * static_cast<float>(walk.first) : 0.0F;
            visibility[pixel] = (earlier + static_cast<float>(std::accumulate(seen.begin(), seen.end(), 0))) / all;
        });
    }

    /// Calls store(pixel, seen) with the samples' visibility in their order.
    template <class Store>
    void trace_equally(std::span<const std::uint8_t> listed, const Walk& walk, const Store& store) {
        const Samples shape = samples(walk);
        for_tiles(rays_, view_, points_, listed, options_.seed, walk.stream, control_,
                  [&](TileTracer& tracer, const TileReceivers& receivers) {
                      Samples at = shape;
                      const auto per_pixel = static_cast<std::size_t>(walk.count);
                      const auto width = static_cast<std::uint32_t>(view_.width);
                      std::vector<std::uint8_t> seen(static_cast<std::size_t>(receivers.count()) * per_pixel);
                      int receiver = 0;
                      int k = 0;
                      std::size_t told = 0;
                      at.start(receivers.pixel(0), width);
                      tracer.trace_cells(
                          receivers,
                          [&](CellRay& ray) {
                              if (receiver == receivers.count()) {
                                  return false;
                              }
                              ray = at.cell(static_cast<std::uint32_t>(walk.first + k));
                              ray.receiver = static_cast<std::uint16_t>(receiver);
                              if (++k == walk.count) {
                                  k = 0;
                                  if (++receiver < receivers.count()) {
                                      at.start(receivers.pixel(receiver), width);
                                  }
                              }
                              return true;
                          },
                          [&](std::uint16_t, std::uint32_t is_seen) { seen[told++] = is_seen != 0 ? 1 : 0; });
                      for (int i = 0; i < receivers.count(); ++i) {
                          store(receivers.pixel(i),
                                std::span{seen}.subspan(static_cast<std::size_t>(i) * per_pixel, per_pixel));
                      }
                      rays_cast_ += seen.size();
                  });
    }

    [[nodiscard]] std::vector<std::uint8_t> open_pixels(std::span<const float> visibility) const {
        std::vector<std::uint8_t> open(listed_.size(), 0);
        for (std::size_t i = 0; i < open.size(); ++i) {
            open[i] = listed_[i] != 0 && open_around(view_, visibility, i) ? 1 : 0;
        }
        return open;
    }

    /// Step 2, and 3 where there are rays for it.
    void trace_rest(const std::vector<std::uint8_t>& open, MaskedTraceCounts& counts, std::span<float> visibility) {
        counts.full_pixels = static_cast<std::uint64_t>(std::ranges::count(open, 1));
        if (options_.rays < 2 * kBoardStrata) {
            trace_walk(open, {.count = options_.rays, .of = options_.rays, .stream = kBoardStream}, visibility);
        } else {
            fill_boards(open, visibility);
            refine(open, visibility);
        }
    }

    /// All steps where pixels lend each other what they found. A pixel's own rays may then decide how many follow, so
    /// each goes on from those it has.
    void share(int first, bool more, MaskedTraceCounts& counts, std::span<float> visibility) {
        const bool one_net = options_.rays < 2 * kBoardStrata && !points_.one_dimensional() && is_power_of_two(first) &&
                             is_power_of_two(options_.rays);
        const int all = one_net && more ? options_.rays : first;
        const int begin = one_net ? std::min(first, kBeginRays) : first;
        Walk walk{.first = 0,
                  .count = begin,
                  .of = all,
                  .stream = kFirstStream,
                  .interleaved = true,
                  .part_bits = one_net ? bits_of(all / (all > first ? first : begin)) : 0};
        trace_walk(listed_, walk, visibility);
        std::vector<std::uint8_t> open(listed_.begin(), listed_.end());
        if (begin < first) {
            keep_mixed(view_, visibility, 1, open, control_);
            walk = walk.next(first - begin);
            trace_walk(open, walk, visibility, visibility);
        }
        found_.assign(visibility.begin(), visibility.end());
        share_first_rays(first, open, visibility);
        if (more && one_net) {
            counts.full_pixels = static_cast<std::uint64_t>(std::ranges::count(open, 1));
            trace_walk(open, walk.next(all - first), visibility, found_);
        } else if (more) {
            trace_rest(open, counts, visibility);
        }
    }

    /// V by what the pixels around found as well.
    /// @param open  pixels to be looked at; 0 after it but for those whose penumbra is too narrow for it. Where it is
    ///              sharp, those are left out whose own rays agree, if these are not few: of f of the light that an
    ///              edge hides, n strata miss all 1 - n f times, and 2 n of them would err by as much.
    void share_first_rays(int first, std::vector<std::uint8_t>& open, std::span<float> visibility) {
        const auto noise = static_cast<float>(kScatter * 0.37 * std::pow(first, -0.75));
        parallel_for(
            view_.height, 8,
            [&](std::int64_t begin, std::int64_t end) {
                control_.check();
                const auto width = static_cast<std::size_t>(view_.width);
                for (std::size_t i = static_cast<std::size_t>(begin) * width; i < static_cast<std::size_t>(end) * width;
                     ++i) {
                    if (open[i] == 0) {
                        continue;
                    }
                    const SharedFit fit = fit_around(view_, found_, i, options_.share);
                    const bool narrow = fit.slope > kSteep || fit.scatter > noise;
                    const bool agree =
                        fit.slope > kSharp && first >= kEnoughToAgree && (found_[i] <= 0.0F || found_[i] >= 1.0F);
                    open[i] = narrow && !agree ? 1 : 0;
                    if (!narrow || (fit.slope <= kSharp && fit.scatter <= kRough * noise)) {
                        visibility[i] = fit.visibility;
                    }
                }
            },
            control_);
    }

    /// Step 2.
    void fill_boards(std::span<const std::uint8_t> open, std::span<const float> visibility) {
        boards_.resize(listed_.size());
        for (std::size_t i = 0; i < boards_.size(); ++i) {
            boards_[i] = visibility[i] >= 1.0F ? ~Board{0} : Board{0};
        }
        const Walk walk{.count = kBoardStrata, .of = kBoardStrata, .stream = kBoardStream};
        const Samples shape = samples(walk);
        trace_equally(open, walk, [&](std::uint32_t pixel, std::span<const std::uint8_t> seen) {
            Samples at = shape;
            at.start(pixel, static_cast<std::uint32_t>(view_.width));
            Board board = 0;
            for (std::uint32_t k = 0; k < kBoardStrata; ++k) {
                std::uint32_t stratum = k;
                if (at.is_net()) {
                    const ScrambledNet::Cell cell = at.points().point(k);
                    stratum = cell.v / kBoardSide * kBoardSide + cell.u / kBoardSide;
                }
                board |= static_cast<Board>(seen[k]) << stratum;
            }
            boards_[pixel] = board;
        });
    }

    /// Step 3.
    void refine(std::span<const std::uint8_t> open, std::span<float> visibility) {
        constexpr int kSideBits = 3;
        const bool line = points_.one_dimensional();
        const int parts = static_cast<int>(std::bit_floor(static_cast<unsigned>(options_.rays / kBoardStrata)));
        const int strata = parts * kBoardStrata;
        const Samples shape = samples({.count = strata, .of = strata, .stream = kFineStream});
        const auto width = static_cast<std::uint32_t>(view_.width);
        // By the inverse of their variances, as if an edge crossed the stratum.
        const auto own_weight = static_cast<float>(1.0 / (1.0 + std::pow(parts, line ? 2.0 : 1.5)));
        // V before this step says which pixels around are known.
        const std::vector<float> before(visibility.begin(), visibility.end());
        for_tiles(rays_, view_, points_, open, options_.seed, kFineStream, control_,
                  [&](TileTracer& tracer, const TileReceivers& receivers) {
                      Samples at = shape;
                      std::array<Board, TileReceivers::kCapacity> wanted{};
                      std::array<std::uint32_t, TileReceivers::kCapacity> seen_in_parts{};
                      for (int i = 0; i < receivers.count(); ++i) {
                          wanted[static_cast<std::size_t>(i)] = open_strata(receivers.pixel(i), open, before);
                      }
                      int receiver = 0;
                      std::uint32_t part = 0;
                      std::uint32_t first = 0;
                      Board left = wanted[0];
                      at.start(receivers.pixel(0), width);
                      tracer.trace_cells(
                          receivers,
                          [&](CellRay& ray) {
                              while (left == 0) {
                                  if (++receiver >= receivers.count()) {
                                      return false;
                                  }
                                  left = wanted[static_cast<std::size_t>(receiver)];
                                  at.start(receivers.pixel(receiver), width);
                              }
                              if (part == 0) {
                                  const auto s = static_cast<std::uint32_t>(std::countr_zero(left));
                                  first = at.is_net() ? at.points().first_in(s % kBoardSide, s / kBoardSide, kSideBits)
                                                      : s * static_cast<std::uint32_t>(parts);
                              }
                              ray = at.cell(at.is_net() ? first + (part << kSideBits) : first + part);
                              ray.receiver = static_cast<std::uint16_t>(receiver);
                              if (++part == static_cast<std::uint32_t>(parts)) {
                                  part = 0;
                                  left &= left - 1;
                              }
                              return true;
                          },
                          [&](std::uint16_t owner, std::uint32_t seen) { seen_in_parts[owner] += seen; });
                      std::uint64_t cast = 0;
                      for (int i = 0; i < receivers.count(); ++i) {
                          const Board cut = wanted[static_cast<std::size_t>(i)];
                          const Board board = boards_[receivers.pixel(i)];
                          const int whole = std::popcount(board & ~cut);
                          const auto own = static_cast<float>(std::popcount(board & cut));
                          const float parts_seen = static_cast<float>(seen_in_parts[static_cast<std::size_t>(i)]) /
                                                   static_cast<float>(parts);
                          const float in_cut = parts_seen + own_weight * (own - parts_seen);
                          visibility[receivers.pixel(i)] =
                              std::clamp((static_cast<float>(whole) + in_cut) / kBoardStrata, 0.0F, 1.0F);
                          cast += static_cast<std::uint64_t>(std::popcount(cut)) * static_cast<std::uint64_t>(parts);
                      }
                      rays_cast_ += cast;
                  });
    }

    /// Strata in which or beside which the pixels around disagree.
    [[nodiscard]] Board open_strata(std::size_t pixel, std::span<const std::uint8_t> open,
                                    std::span<const float> before) const {
        Board all = ~Board{0};
        Board any = 0;
        bool known = false;
        around(view_, pixel, 1, [&](std::size_t i) {
            if (open[i] != 0 || before[i] == 0.0F || before[i] == 1.0F) {
                known = true;
                all &= boards_[i];
                any |= boards_[i];
            }
        });
        return known ? disagreeing(all, any, points_.one_dimensional()) : ~Board{0};
    }

    const RayScene& rays_;
    const View& view_;
    std::span<const std::uint8_t> listed_;
    const MaskedTraceOptions& options_;
    Control& control_;
    LightPoints points_;
    std::vector<Board> boards_;
    std::vector<float> found_;  ///< V by a pixel's own first rays
    std::atomic<std::uint64_t> rays_cast_{0};
};

}  // namespace

MaskedTraceCounts trace_masked(const RayScene& rays, const View& view, const Light& light,
                               std::span<const std::uint8_t> listed, const MaskedTraceOptions& options,
                               std::span<float> visibility, Control& control) {
    PENUMBRA_ASSERT(listed.size() == view.size() && visibility.size() == view.size());
    PENUMBRA_ASSERT(options.rays >= 1 && options.first_rays >= 1 && options.share >= 0);
    return MaskedTrace{rays, view, light, listed, options, control}.run(visibility);
}

}  // namespace penumbra
