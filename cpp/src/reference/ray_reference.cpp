#include "reference/ray_reference.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <chrono>
#include <cmath>
#include <string>
#include <vector>

#include "base/parallel.h"
#include "reference/light_mask.h"
#include "reference/light_points.h"
#include "reference/ray_batch.h"
#include "reference/receivers.h"
#include "reference/sampling.h"
#include "reference/vector_clones.h"

namespace penumbra {
namespace {

/// Strata per side of the pilot. 36 pairs, pooled over 3 x 3 pixels, hold some 40 differing pairs in the middle of a
/// penumbra, which predicts a standard deviation to about 8 %.
constexpr int kPilotSide = 6;
/// Two samples per stratum.
constexpr int kPairs = kRayLanes / 2;
/// Rays beyond what the pilot asks for, so that most pixels end below the error asked for.
constexpr double kSpareRays = 1.2;
/// Differing pairs told beyond those found.
constexpr float kUnseen = 0.5F;
/// Streams of random numbers.
constexpr std::uint32_t kPilotStream = 1;
constexpr std::uint32_t kFinalStream = 2;

/// Sums over the pairs of one pixel; w is the irradiance weight, x = w * visible.
struct Sums {
    std::uint32_t seen = 0;
    std::uint32_t differing = 0;  ///< pairs of which one sample is visible
    double w = 0.0, x = 0.0;
    double xx = 0.0, xw = 0.0, ww = 0.0;  ///< of the differences within pairs
    double squares = 0.0;                 ///< of w itself
};

/// Sample coordinates of eight strata, two samples each: lanes 0 .. 7 hold the first ones, lanes 8 .. 15 the second
/// ones.
PENUMBRA_VECTOR_CLONES void place_pairs(int first, int columns, int rows, std::uint32_t key,
                                        SampleLanes& samples) noexcept {
    const float width = 1.0F / static_cast<float>(columns);
    const float height = 1.0F / static_cast<float>(rows);
    float shift_u;
    float shift_v;
    uniform_pair(key, ~0U, shift_u, shift_v);
    alignas(64) std::array<float, kPairs> column;
    alignas(64) std::array<float, kPairs> row;
    for (int i = 0; i < kPairs; ++i) {
        const int stratum = std::min(first + i, columns * rows - 1);
        const int whole_rows = stratum / columns;
        column[i] = static_cast<float>(stratum % columns);
        row[i] = static_cast<float>(whole_rows);
    }
    for (int i = 0; i < kRayLanes; ++i) {
        float a;
        float b;
        uniform_pair(key, static_cast<std::uint32_t>(2 * first + i), a, b);
        const float u = (column[i % kPairs] + a) * width + shift_u;
        const float v = (row[i % kPairs] + b) * height + shift_v;
        samples.u[i] = u >= 1.0F ? u - 1.0F : u;
        samples.v[i] = v >= 1.0F ? v - 1.0F : v;
    }
}

/// Casts side * side pairs of rays from one receiver. For a line light the strata are side * side intervals.
class PixelTracer {
public:
    PixelTracer(const RayScene& scene, const LightPoints& points, std::uint32_t seed)
        : batch_{scene}, points_{points}, seed_{seed} {}

    Sums trace(const Receiver& receiver, const glm::vec3& shading_normal, int side, std::uint32_t stream) noexcept {
        for (int i = 0; i < kRayLanes; ++i) {
            lanes_.px[i] = receiver.position_an.x;
            lanes_.py[i] = receiver.position_an.y;
            lanes_.pz[i] = receiver.position_an.z;
            lanes_.nx[i] = receiver.normal.x;
            lanes_.ny[i] = receiver.normal.y;
            lanes_.nz[i] = receiver.normal.z;
            lanes_.sx[i] = shading_normal.x;
            lanes_.sy[i] = shading_normal.y;
            lanes_.sz[i] = shading_normal.z;
            lanes_.offset[i] = receiver.offset;
        }
        const std::uint32_t key = sequence_key(receiver.pixel, sequence_base(seed_, stream));
        const int strata = side * side;
        const int columns = points_.one_dimensional() ? strata : side;
        Sums sums;
        int packets = 0;
        int first_of_batch = 0;
        for (int first = 0; first < strata; first += kPairs) {
            place_pairs(first, columns, strata / columns, key, samples_);
            points_.aim(lanes_, samples_, batch_.next(), &weight_[static_cast<std::size_t>(packets) * kRayLanes]);
            batch_.added(kRayLanes);
            ++packets;
            if (batch_.full() || first + kPairs >= strata) {
                batch_.trace();
                add(packets, strata - first_of_batch, sums);
                first_of_batch = first + kPairs;
                packets = 0;
            }
        }
        return sums;
    }

private:
    /// @param strata  how many of the batch's pairs count; the last packet's surplus ones repeat the last stratum
    void add(int packets, int strata, Sums& sums) const noexcept {
        for (int p = 0; p < packets; ++p) {
            for (int i = 0; i < kPairs && p * kPairs + i < strata; ++i) {
                const int a = p * kRayLanes + i;
                const int b = a + kPairs;
                const std::uint32_t seen_a = batch_.seen(a);
                const std::uint32_t seen_b = batch_.seen(b);
                const double wa = weight_[a];
                const double wb = weight_[b];
                const double xa = seen_a != 0 ? wa : 0.0;
                const double xb = seen_b != 0 ? wb : 0.0;
                sums.seen += seen_a + seen_b;
                sums.differing += seen_a ^ seen_b;
                sums.w += wa + wb;
                sums.squares += wa * wa + wb * wb;
                sums.x += xa + xb;
                sums.xx += (xa - xb) * (xa - xb);
                sums.xw += (xa - xb) * (wa - wb);
                sums.ww += (wa - wb) * (wa - wb);
            }
        }
    }

    RayBatch batch_;
    const LightPoints& points_;
    std::uint32_t seed_;
    ReceiverLanes lanes_{};
    SampleLanes samples_{};
    alignas(64) std::array<float, RayBatch::kCapacity> weight_{};
};

/// Strata per side that keep the standard deviation of a single stratum's feature at or below `error`.
int least_side(double error) noexcept {
    // sd = sqrt(1/8) / strata, see the header.
    return static_cast<int>(std::ceil(std::sqrt(std::sqrt(0.125) / error)));
}

/// Strata per side for `error`.
/// @param differing  pairs that differ among the pilot's strata, as a mean over pixels, so not whole
int wanted_side(double differing, double error, bool line) noexcept {
    constexpr double kStrata = kPilotSide * kPilotSide;
    const double asked = 4.0 * error * error;  // differing(n) / n^2 has to come down to this
    if (line) {
        // An edge crosses one of n intervals, however many.
        return static_cast<int>(std::ceil(std::sqrt(kSpareRays * std::sqrt(differing / asked))));
    }
    // A long edge crosses sqrt(n) of n strata; a sliver thinner than a stratum is met in proportion to n at first, and
    // once it is resolved it behaves like an edge that differs in about 3 pairs of the pilot.
    const double edge = std::pow(std::max(3.0, differing) / std::sqrt(kStrata) / asked, 2.0 / 3.0);
    const double tip = differing / kStrata / asked;
    return static_cast<int>(std::ceil(std::sqrt(kSpareRays * std::min(edge, tip))));
}

/// Differing pairs of the pilot in a square of pixels.
struct Around {
    int pixels = 0;
    double sum = 0.0;
    double highest = 0.0;
    /// One standard deviation above the mean that was counted: too few rays are worse than too many.
    [[nodiscard]] double mean() const noexcept { return (sum + std::sqrt(sum) + 0.5) / pixels; }
};

Around look_around(const View& view, const std::vector<std::uint8_t>& traced,
                   const std::vector<std::uint8_t>& differing, int x, int y, int radius) noexcept {
    Around around;
    for (int ny = std::max(0, y - radius); ny <= std::min(view.height - 1, y + radius); ++ny) {
        for (int nx = std::max(0, x - radius); nx <= std::min(view.width - 1, x + radius); ++nx) {
            const std::size_t i = static_cast<std::size_t>(ny) * static_cast<std::size_t>(view.width) + nx;
            if (traced[i] != 0) {
                ++around.pixels;
                around.sum += differing[i];
                around.highest = std::max(around.highest, static_cast<double>(differing[i]));
            }
        }
    }
    return around;
}

/// For every traced pixel the strata per side that its own pilot and those around it ask for, else 0. The mean over
/// 3 x 3 pixels steadies the prediction, that over 5 x 5 finds the faint ends of penumbrae where the pilots of nine
/// pixels see nothing. The pixel's own count rules where it stands out, and half a neighbour's where that stands out,
/// so that a penumbra narrower than a pixel is not missed beside its edge.
std::vector<std::uint16_t> plan_sides(const View& view, const std::vector<std::uint8_t>& traced,
                                      const std::vector<std::uint8_t>& differing, int least, int most, double error,
                                      bool line, bool& reached, Control& control) {
    std::vector<std::uint16_t> sides(view.size(), 0);
    std::atomic<bool> all_reached{true};
    parallel_for(
        view.height, 16,
        [&](std::int64_t begin, std::int64_t end) {
            for (int y = static_cast<int>(begin); y < end; ++y) {
                for (int x = 0; x < view.width; ++x) {
                    const std::size_t pixel = static_cast<std::size_t>(y) * static_cast<std::size_t>(view.width) + x;
                    if (traced[pixel] == 0) {
                        continue;
                    }
                    const Around near = look_around(view, traced, differing, x, y, 1);
                    const Around far = look_around(view, traced, differing, x, y, 2);
                    const double expected = std::max(
                        {near.mean(), far.mean(), 0.5 * near.highest, 0.7 * static_cast<double>(differing[pixel])});
                    const int wanted = std::max(least, wanted_side(expected, error, line));
                    if (wanted > most) {
                        all_reached = false;
                    }
                    sides[pixel] = static_cast<std::uint16_t>(std::clamp(wanted, 1, most));
                }
            }
        },
        control);
    reached = all_reached;
    return sides;
}

/// What a pixel found, until its neighbours' findings are in.
struct Found {
    float strata = 0.0F;                ///< 0: not traced
    float differing = 0.0F;             ///< pairs
    float irradiance_differing = 0.0F;  ///< squares of the pairs' weighted differences over the mean weight's square
    float concentration = 1.0F;         ///< mean square of the weights over their mean's square
};

/// Standard error of the mean of `own.strata` pairs, by the pixel's own count and that of its 3 x 3 neighbourhood.
///
/// The count of one pixel scatters, and now and then it is far too small: an edge along a row of strata makes all of
/// them agree by chance. A neighbour with n strata and d differing pairs suggests d sqrt(own.strata / n) here. The
/// larger of the own count and the mean that the neighbourhood suggests; `unseen` more, see the header.
template <float Found::*Differing>
float standard_error(const View& view, const std::vector<Found>& found, int x, int y, float unseen) noexcept {
    const Found& own = found[static_cast<std::size_t>(y) * static_cast<std::size_t>(view.width) + x];
    double differing = 0.0;
    double roots = 0.0;
    for (int ny = std::max(0, y - 1); ny <= std::min(view.height - 1, y + 1); ++ny) {
        for (int nx = std::max(0, x - 1); nx <= std::min(view.width - 1, x + 1); ++nx) {
            const Found& other = found[static_cast<std::size_t>(ny) * static_cast<std::size_t>(view.width) + nx];
            if (other.strata > 0.0F) {
                differing += other.*Differing;
                roots += std::sqrt(static_cast<double>(other.strata));
            }
        }
    }
    const double around = differing * std::sqrt(static_cast<double>(own.strata)) / roots;
    const double count = std::max(static_cast<double>(own.*Differing), around) + unseen;
    return static_cast<float>(std::sqrt(count) / (2.0 * own.strata));
}

/// Counts rays done against rays planned, over both phases.
class Progress {
public:
    Progress(Control& control, double share, double from) : control_{control}, share_{share}, from_{from} {}
    void plan(std::uint64_t rays) noexcept { planned_ = rays; }
    void add(std::uint64_t rays) noexcept {
        const std::uint64_t done = done_ += rays;
        control_.report(static_cast<float>(from_ + share_ * static_cast<double>(done) /
                                                       static_cast<double>(std::max<std::uint64_t>(1, planned_))));
    }

private:
    Control& control_;
    double share_, from_;
    std::uint64_t planned_ = 1;
    std::atomic<std::uint64_t> done_{0};
};

/// Runs one phase over all pixels with a side above 0; `store` gets each pixel's sums, from any thread.
template <class SideOf, class Store>
void trace_pixels(const RayScene& rays, const View& view, const LightPoints& points, const ReferenceOptions& options,
                  const std::vector<std::uint8_t>& traced, std::uint32_t stream, Progress& progress, Control& control,
                  const SideOf& side_of, const Store& store) {
    const Tiles tiles{rays, view};
    parallel_for(
        tiles.count(), 1,
        [&](std::int64_t begin, std::int64_t end) {
            PixelTracer tracer{rays, points, options.seed};
            TileReceivers receivers;
            for (std::int64_t tile = begin; tile < end; ++tile) {
                tiles.collect(traced, tile, receivers);
                std::uint64_t cast = 0;
                for (int i = 0; i < receivers.count(); ++i) {
                    control.check();  // a pixel takes some 10 ms at the very most
                    const Receiver receiver = receivers[i];
                    const int side = side_of(receiver.pixel);
                    store(receiver.pixel, side,
                          tracer.trace(receiver, view.shading_normal_ws[receiver.pixel], side, stream));
                    cast += 2U * static_cast<std::uint64_t>(side) * static_cast<std::uint64_t>(side);
                }
                progress.add(cast);
            }
        },
        control);
}

void check(const ReferenceOptions& options) {
    if (!(options.standard_error > 0.0 && options.standard_error < 1.0)) {
        throw InvalidSettings("reference: standard_error is " + std::to_string(options.standard_error) +
                              "; choose a number between 0 and 1, e.g. 0.002");
    }
    if (options.max_rays_per_pixel < 2) {
        throw InvalidSettings("reference: max_rays_per_pixel is " + std::to_string(options.max_rays_per_pixel) +
                              "; choose at least 2");
    }
}

}  // namespace

Reference trace_reference(const RayScene& rays, const Scene& scene, const View& view, const Light& light,
                          const ReferenceOptions& options, Control& control) {
    check(options);
    const auto start = std::chrono::steady_clock::now();
    Reference result;
    result.method = "ray traced";
    result.mask = light_mask(scene, view, light);
    result.area.assign(view.size(), 1.0F);
    result.irradiance.assign(view.size(), 1.0F);
    result.standard_error.assign(view.size(), 0.0F);
    result.irradiance_standard_error.assign(view.size(), 0.0F);
    const auto finish = [&] {
        result.time_ms = std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start).count();
        control.report(1.0F);
        return std::move(result);
    };

    std::vector<std::uint8_t> traced = result.mask;
    if (options.keep_everything) {
        for (std::size_t i = 0; i < view.size(); ++i) {
            traced[i] = view.hit(i) ? 1 : 0;
        }
    }
    const auto masked = static_cast<std::uint64_t>(std::count(result.mask.begin(), result.mask.end(), 1));
    const auto traced_pixels = static_cast<std::uint64_t>(std::count(traced.begin(), traced.end(), 1));
    result.pixels_skipped = view.size() - traced_pixels;
    if (rays.empty() || !light.casts_shadow) {
        return finish();
    }

    const LightPoints points{light, rays.frame()};
    if (points.single_point()) {
        // One ray tells all, and without error.
        Progress progress{control, 1.0, 0.0};
        progress.plan(2 * traced_pixels);
        trace_pixels(
            rays, view, points, options, traced, kFinalStream, progress, control, [](std::uint32_t) { return 1; },
            [&](std::uint32_t pixel, int, const Sums& sums) {
                if (result.mask[pixel] != 0) {
                    result.area[pixel] = sums.seen > 0 ? 1.0F : 0.0F;
                    result.irradiance[pixel] = sums.seen > 0 || sums.w <= 0.0 ? 1.0F : 0.0F;
                }
            });
        result.rays = 2 * traced_pixels;
        result.mean_rays_per_pixel = masked > 0 ? static_cast<double>(result.rays) / static_cast<double>(masked) : 0.0;
        return finish();
    }

    const int most = std::max(1, static_cast<int>(std::sqrt(options.max_rays_per_pixel / 2.0)));
    const int least = least_side(options.standard_error);
    constexpr int kPilotRays = 2 * kPilotSide * kPilotSide;
    std::vector<std::uint8_t> differing(view.size(), 0);
    const double pilot_share =
        static_cast<double>(kPilotRays) / (static_cast<double>(kPilotRays) + 4.0 * static_cast<double>(least) * least);
    Progress pilot_progress{control, pilot_share, 0.0};
    pilot_progress.plan(traced_pixels * kPilotRays);
    trace_pixels(
        rays, view, points, options, traced, kPilotStream, pilot_progress, control,
        [](std::uint32_t) { return kPilotSide; },
        [&](std::uint32_t pixel, int, const Sums& sums) {
            differing[pixel] = static_cast<std::uint8_t>(sums.differing);
        });

    std::vector<std::uint16_t> sides = plan_sides(view, traced, differing, least, most, options.standard_error,
                                                  points.one_dimensional(), result.reached, control);
    if (options.keep_everything) {
        const std::uint16_t highest = std::ranges::max(sides);
        std::ranges::transform(sides, sides.begin(), [&](std::uint16_t side) { return side > 0 ? highest : side; });
    }
    std::uint64_t planned = 0;
    for (const std::uint16_t side : sides) {
        planned += 2U * static_cast<std::uint64_t>(side) * side;
    }
    Progress progress{control, 1.0 - pilot_share, pilot_share};
    progress.plan(planned);
    std::vector<Found> found(view.size());
    trace_pixels(
        rays, view, points, options, traced, kFinalStream, progress, control,
        [&](std::uint32_t pixel) { return static_cast<int>(sides[pixel]); },
        [&](std::uint32_t pixel, int side, const Sums& sums) {
            if (result.mask[pixel] == 0) {
                return;
            }
            const double strata = static_cast<double>(side) * side;
            result.area[pixel] = static_cast<float>(sums.seen / (2.0 * strata));
            found[pixel].strata = static_cast<float>(strata);
            found[pixel].differing = static_cast<float>(sums.differing);
            if (!(sums.w > 0.0)) {
                // Nothing to shadow: 1. Unless no sample met what little of the light is above the horizon: then the
                // ratio may be any number from 0 to 1, and the standard error told is that of any.
                const glm::dvec3 position_ws = view.eye_ws + glm::dvec3(view.position_cr[pixel]);
                if (faces_light(light, position_ws, glm::dvec3(view.shading_normal_ws[pixel]))) {
                    found[pixel].concentration = static_cast<float>(0.36 * strata * strata / kUnseen);  // 0.3
                }
                return;
            }
            // The ratio's error is that of the mean of w (visible - ratio), over the mean of w.
            const double ratio = sums.x / sums.w;
            const double squares = std::max(0.0, sums.xx - 2.0 * ratio * sums.xw + ratio * ratio * sums.ww);
            const double mean_weight = sums.w / (2.0 * strata);
            result.irradiance[pixel] = static_cast<float>(ratio);
            found[pixel].irradiance_differing = static_cast<float>(squares / (mean_weight * mean_weight));
            found[pixel].concentration =
                static_cast<float>(sums.squares / (2.0 * strata) / (mean_weight * mean_weight));
        });
    parallel_for(
        view.height, 16,
        [&](std::int64_t begin, std::int64_t end) {
            for (int y = static_cast<int>(begin); y < end; ++y) {
                for (int x = 0; x < view.width; ++x) {
                    const std::size_t i = static_cast<std::size_t>(y) * static_cast<std::size_t>(view.width) + x;
                    if (found[i].strata > 0.0F) {
                        result.standard_error[i] = standard_error<&Found::differing>(view, found, x, y, kUnseen);
                        result.irradiance_standard_error[i] = standard_error<&Found::irradiance_differing>(
                            view, found, x, y, kUnseen * found[i].concentration);
                    }
                }
            }
        },
        control);
    result.rays = traced_pixels * kPilotRays + planned;
    result.mean_rays_per_pixel = masked > 0 ? static_cast<double>(result.rays) / static_cast<double>(masked) : 0.0;
    return finish();
}

}  // namespace penumbra
