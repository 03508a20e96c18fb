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
#include "reference/light_points.h"
#include "reference/receivers.h"
#include "reference/sampling.h"
#include "reference/scrambled_net.h"
#include "reference/shared_fit.h"
#include "reference/strata_board.h"
#include "reference/tile_tracer.h"
#include "reference/visibility_tracer.h"

namespace penumbra {
namespace {

/// Streams of random numbers; the reference has 1 and 2.
constexpr std::uint32_t kFirstStream = 3;
constexpr std::uint32_t kBoardStream = 4;
constexpr std::uint32_t kFineStream = 5;
constexpr std::uint32_t kPilotStream = 6;
constexpr int kPilotStrata = 16;  // of the light: as many as a 4 x 4 block has pixels
constexpr int kTilesPerPiece = 4;
constexpr int kOpenRadius = 2;  // pixels
/// Of V, per pixel: the penumbra is narrower than seven pixels, and its ends bend the plane.
constexpr float kSteep = 0.15F;
/// Of the noise of n first rays in a penumbra, 0.37 n^-0.75: more scatter around the plane is no noise.
constexpr double kScatter = 1.15;

/// Calls work(tracer, receivers) for every tile that has listed pixels.
template <class Work>
void for_tiles(const RayScene& rays, const View& view, const LightPoints& points, std::span<const std::uint8_t> listed,
               std::uint32_t seed, std::uint32_t stream, Control& control, const Work& work) {
    const Tiles tiles{rays, view};
    parallel_for(
        tiles.count(), kTilesPerPiece,
        [&](std::int64_t begin, std::int64_t end) {
            TileTracer tracer{rays, points, seed, stream};
            TileReceivers receivers;
            for (std::int64_t tile = begin; tile < end; ++tile) {
                control.check();
                tiles.collect(listed, tile, receivers);
                if (receivers.count() > 0) {
                    work(tracer, receivers);
                }
            }
        },
        control);
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

    /// Step 1, or any other number of rays for every pixel listed.
    void trace_all(std::span<const std::uint8_t> listed, int count, std::uint32_t stream, std::span<float> visibility) {
        trace_equally(listed, count, stream, [&](std::uint32_t pixel, std::span<const std::uint8_t> seen) {
            visibility[pixel] =
                static_cast<float>(std::accumulate(seen.begin(), seen.end(), 0)) / static_cast<float>(count);
        });
    }

    MaskedTraceCounts run(std::span<float> visibility) {
        MaskedTraceCounts counts;
        counts.pixels = static_cast<std::uint64_t>(std::ranges::count(listed_, 1));
        const int first = points_.single_point() ? 1 : std::min(options_.rays, options_.first_rays);
        interleaved_ = options_.share > 0;
        trace_all(listed_, first, kFirstStream, visibility);
        interleaved_ = false;
        if (!points_.single_point() && (options_.share > 0 || options_.rays > options_.first_rays)) {
            const std::vector<std::uint8_t> open =
                options_.share > 0 ? share_first_rays(visibility) : open_pixels(visibility);
            counts.full_pixels = static_cast<std::uint64_t>(std::ranges::count(open, 1));
            if (options_.rays <= options_.first_rays) {
                counts.full_pixels = 0;
            } else if (options_.rays < 2 * kBoardStrata) {
                trace_all(open, options_.rays, kBoardStream, visibility);
            } else {
                fill_boards(open, visibility);
                refine(open, visibility);
            }
        }
        counts.rays = rays_cast_;
        return counts;
    }

private:
    /// The samples of one pixel: a net of points, or cells where the count is no power of two or the light a line.
    class Samples {
    public:
        Samples(int count, bool line, std::uint32_t base)
            : count_{count},
              bits_{std::countr_zero(static_cast<unsigned>(count))},
              net_{!line && std::has_single_bit(static_cast<unsigned>(count)) && bits_ <= 16},
              base_{base} {
            if (!net_) {
                strata_ = make_strata(count, line);
            }
        }
        [[nodiscard]] bool is_net() const noexcept { return net_; }
        void start(std::uint32_t pixel) noexcept {
            if (net_) {
                points_ = ScrambledNet{bits_, sequence_key(pixel, mix(base_))};
            }
        }
        /// So that the nets of the pixels of a 4 x 4 block are shifted by all multiples of a quarter of the light.
        void start(std::uint32_t pixel, std::uint32_t width) noexcept {
            if (net_) {
                constexpr std::uint32_t kQuarters = 0xC000C000U;
                const std::uint32_t place = (pixel % width & 3U) << 14U | (pixel / width & 3U) << 30U;
                const std::uint32_t key = sequence_key(pixel, mix(base_)) & ~kQuarters;
                points_ = ScrambledNet{bits_, key | ((place ^ mix(base_ + 1U)) & kQuarters)};
            }
        }
        [[nodiscard]] const ScrambledNet& points() const noexcept { return points_; }
        [[nodiscard]] CellRay cell(std::uint32_t k) const noexcept {
            CellRay ray;
            ray.index = k;
            if (net_) {
                const ScrambledNet::Cell at = points_.point(k);
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
        int count_, bits_;
        bool net_;
        std::uint32_t base_;
        Strata strata_;
        ScrambledNet points_{0, 0};
    };

    [[nodiscard]] Samples samples(int count, std::uint32_t stream) const {
        return {count, points_.one_dimensional(), sequence_base(options_.seed, stream)};
    }

    /// Calls store(pixel, seen) with the samples' visibility in their order.
    template <class Store>
    void trace_equally(std::span<const std::uint8_t> listed, int count, std::uint32_t stream, const Store& store) {
        for_tiles(rays_, view_, points_, listed, options_.seed, stream, control_,
                  [&](TileTracer& tracer, const TileReceivers& receivers) {
                      Samples at = samples(count, stream);
                      const auto per_pixel = static_cast<std::size_t>(count);
                      std::vector<std::uint8_t> seen(static_cast<std::size_t>(receivers.count()) * per_pixel);
                      int receiver = 0;
                      int k = 0;
                      std::size_t told = 0;
                      const auto start = [&](std::uint32_t pixel) {
                          interleaved_ ? at.start(pixel, static_cast<std::uint32_t>(view_.width)) : at.start(pixel);
                      };
                      start(receivers.pixel(0));
                      tracer.trace_cells(
                          receivers,
                          [&](CellRay& ray) {
                              if (receiver == receivers.count()) {
                                  return false;
                              }
                              ray = at.cell(static_cast<std::uint32_t>(k));
                              ray.receiver = static_cast<std::uint16_t>(receiver);
                              if (++k == count) {
                                  k = 0;
                                  if (++receiver < receivers.count()) {
                                      start(receivers.pixel(receiver));
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

    /// @return 1 where the penumbra is too narrow for it
    std::vector<std::uint8_t> share_first_rays(std::span<float> visibility) {
        std::vector<std::uint8_t> open(listed_.size(), 0);
        const std::vector<float> found(visibility.begin(), visibility.end());
        const auto noise = static_cast<float>(kScatter * 0.37 * std::pow(options_.first_rays, -0.75));
        parallel_for(
            view_.height, 8,
            [&](std::int64_t begin, std::int64_t end) {
                control_.check();
                const auto width = static_cast<std::size_t>(view_.width);
                for (std::size_t i = static_cast<std::size_t>(begin) * width; i < static_cast<std::size_t>(end) * width;
                     ++i) {
                    if (listed_[i] != 0) {
                        const SharedFit fit = fit_around(view_, found, i, options_.share);
                        visibility[i] = fit.visibility;
                        open[i] = fit.slope > kSteep || fit.scatter > noise ? 1 : 0;
                    }
                }
            },
            control_);
        return open;
    }

    /// Step 2.
    void fill_boards(std::span<const std::uint8_t> open, std::span<const float> visibility) {
        boards_.resize(listed_.size());
        for (std::size_t i = 0; i < boards_.size(); ++i) {
            boards_[i] = visibility[i] >= 1.0F ? ~Board{0} : Board{0};
        }
        const Samples shape = samples(kBoardStrata, kBoardStream);
        trace_equally(open, kBoardStrata, kBoardStream, [&](std::uint32_t pixel, std::span<const std::uint8_t> seen) {
            Samples at = shape;
            at.start(pixel);
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
        const Samples shape = samples(parts * kBoardStrata, kFineStream);
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
                      at.start(receivers.pixel(0));
                      tracer.trace_cells(
                          receivers,
                          [&](CellRay& ray) {
                              while (left == 0) {
                                  if (++receiver >= receivers.count()) {
                                      return false;
                                  }
                                  left = wanted[static_cast<std::size_t>(receiver)];
                                  at.start(receivers.pixel(receiver));
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
    std::atomic<std::uint64_t> rays_cast_{0};
    bool interleaved_ = false;  ///< first rays that will be shared
};

/// Least and most V of the listed pixels in each column of a window; 1 and 0 where there are none.
struct Extremes {
    std::vector<float> least, most;
    explicit Extremes(std::size_t columns) : least(columns), most(columns) {}
};

/// Of the rows up to kPilotRadius away from y.
void extremes_of_columns(const View& view, std::span<const std::uint8_t> listed, std::span<const float> visibility,
                         int y, Extremes& out) {
    std::ranges::fill(out.least, 1.0F);
    std::ranges::fill(out.most, 0.0F);
    const auto width = static_cast<std::size_t>(view.width);
    for (int row = std::max(0, y - kPilotRadius); row <= std::min(view.height - 1, y + kPilotRadius); ++row) {
        const std::size_t first = static_cast<std::size_t>(row) * width;
        for (std::size_t x = 0; x < width; ++x) {
            const bool counts = listed[first + x] != 0;
            out.least[x] = std::min(out.least[x], counts ? visibility[first + x] : 1.0F);
            out.most[x] = std::max(out.most[x], counts ? visibility[first + x] : 0.0F);
        }
    }
}

}  // namespace

std::vector<std::uint8_t> find_penumbrae(const RayScene& rays, const View& view, const Light& light,
                                         std::span<const std::uint8_t> listed, std::uint32_t seed,
                                         std::span<float> visibility, Control& control) {
    PENUMBRA_ASSERT(listed.size() == view.size() && visibility.size() == view.size());
    const LightPoints points{light, rays.frame()};
    // The lanes of a packet are a block of pixels, and each lane has a stratum of its own.
    const Cells cells =
        make_cells(SamplePattern::Stratified, false, kPilotStrata, 0, kPilotStrata, points.one_dimensional());
    for_tiles(
        rays, view, points, listed, seed, kPilotStream, control,
        [&](TileTracer& tracer, const TileReceivers& receivers) { tracer.trace_one(receivers, cells, visibility); });
    std::vector<std::uint8_t> open(view.size(), 0);
    const auto width = static_cast<std::size_t>(view.width);
    const auto open_in_row = [&](int y, Extremes& of_columns) {
        extremes_of_columns(view, listed, visibility, y, of_columns);
        for (std::size_t x = 0; x < width; ++x) {
            const std::size_t i = static_cast<std::size_t>(y) * width + x;
            if (listed[i] != 0) {
                const std::size_t first = x - std::min<std::size_t>(x, kPilotRadius);
                const std::size_t last = std::min(width - 1, x + kPilotRadius);
                float least = 1.0F;
                float most = 0.0F;
                for (std::size_t column = first; column <= last; ++column) {
                    least = std::min(least, of_columns.least[column]);
                    most = std::max(most, of_columns.most[column]);
                }
                open[i] = least < most ? 1 : 0;
            }
        }
    };
    parallel_for(
        view.height, 8,
        [&](std::int64_t begin, std::int64_t end) {
            Extremes of_columns{width};
            for (auto y = static_cast<int>(begin); y < static_cast<int>(end); ++y) {
                open_in_row(y, of_columns);
            }
        },
        control);
    return open;
}

MaskedTraceCounts trace_masked(const RayScene& rays, const View& view, const Light& light,
                               std::span<const std::uint8_t> listed, const MaskedTraceOptions& options,
                               std::span<float> visibility, Control& control) {
    PENUMBRA_ASSERT(listed.size() == view.size() && visibility.size() == view.size());
    PENUMBRA_ASSERT(options.rays >= 1 && options.first_rays >= 1 && options.share >= 0);
    return MaskedTrace{rays, view, light, listed, options, control}.run(visibility);
}

}  // namespace penumbra
