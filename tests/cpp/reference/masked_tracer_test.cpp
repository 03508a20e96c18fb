#include "reference/masked_tracer.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <set>

#include "base/parallel.h"
#include "reference/pilot_rays.h"
#include "reference/scrambled_net.h"
#include "reference/shared_fit.h"
#include "reference/strata_board.h"
#include "test_scenes.h"

namespace penumbra {
namespace {

using test::Point;

std::vector<float> trace(const Scene& scene, const Light& light, const View& view, const MaskedTraceOptions& options,
                         MaskedTraceCounts* counts = nullptr) {
    Control control;
    const RayScene rays{scene, control};
    const std::vector<std::uint8_t> listed(view.size(), 1);
    std::vector<float> visibility(view.size(), 1.0F);
    const MaskedTraceCounts done = trace_masked(rays, view, light, listed, options, visibility, control);
    if (counts != nullptr) {
        *counts = done;
    }
    return visibility;
}

/// Blocker at height 1 that covers x < 0, over a floor that is no caster.
Scene half_plane() {
    Scene scene;
    scene.instances = {test::place(test::square(10)),
                       test::place(test::quad({-50, -50, 1}, {0, -50, 1}, {0, 50, 1}, {-50, 50, 1}))};
    scene.instances[0].casts = false;
    return scene;
}

constexpr int kWidth = 48;

/// A row of pixels across the penumbra of half_plane() under a light of half width 0.5 at height 2: V = x + 1/2.
View ramp(int rows) {
    std::vector<Point> points;
    for (int y = 0; y < rows; ++y) {
        for (int x = 0; x < kWidth; ++x) {
            points.push_back({{-1.0 + 2.0 * (x + 0.5) / kWidth, 0.01 * y, 0.0}});
        }
    }
    return test::view_of(points, kWidth);
}

double ramp_v(std::size_t pixel) {
    return std::clamp(-0.5 + 2.0 * (static_cast<double>(pixel % kWidth) + 0.5) / kWidth, 0.0, 1.0);
}

double rms_on_ramp(const std::vector<float>& v) {
    double sum = 0.0;
    for (std::size_t i = 0; i < v.size(); ++i) {
        sum += (v[i] - ramp_v(i)) * (v[i] - ramp_v(i));
    }
    return std::sqrt(sum / static_cast<double>(v.size()));
}

// --- points ----------------------------------------------------------------------------------------------------

TEST(ScrambledNet, HasOnePointInEveryBoxOfAreaOneOverN) {
    for (const std::uint32_t key : {0U, 0xFFFFFFFFU, 0x3C6EF372U}) {
        for (int bits = 0; bits <= 10; ++bits) {
            const ScrambledNet net{bits, key};
            for (int wide = 0; wide <= bits; ++wide) {
                std::set<std::pair<std::uint32_t, std::uint32_t>> boxes;
                for (std::uint32_t k = 0; k < (1U << bits); ++k) {
                    const ScrambledNet::Cell at = net.point(k);
                    boxes.emplace(at.u >> wide, at.v >> (bits - wide));
                }
                EXPECT_EQ(boxes.size(), 1U << bits) << bits << " " << wide;
            }
        }
    }
}

TEST(ScrambledNet, NamesThePointsOfASquare) {
    const ScrambledNet net{9, 0x9E3779B9U};
    for (std::uint32_t i = 0; i < 8; ++i) {
        for (std::uint32_t j = 0; j < 8; ++j) {
            for (std::uint32_t p = 0; p < 8; ++p) {
                const ScrambledNet::Cell at = net.point(net.first_in(i, j, 3) + (p << 3U));
                EXPECT_EQ(at.u >> 6U, i);
                EXPECT_EQ(at.v >> 6U, j);
            }
        }
    }
}

/// Whether points [first, last) of the net, taken in parts, lie one in each box whose area is 1 over their number.
bool is_net(const ScrambledNet& net, int bits, int part_bits, std::uint32_t first, std::uint32_t last) {
    const int own = std::countr_zero(last - first);
    for (int wide = 0; wide <= own; ++wide) {
        std::set<std::pair<std::uint32_t, std::uint32_t>> boxes;
        for (std::uint32_t m = first; m < last; ++m) {
            const ScrambledNet::Cell at = net.point(net.in_parts(m, part_bits));
            boxes.emplace(at.u >> (bits - own + wide), at.v >> (bits - wide));
        }
        if (boxes.size() != last - first) {
            return false;
        }
    }
    return true;
}

TEST(ScrambledNet, InPartsIsTheSameNetAndEachPartIsOne) {
    for (const std::uint32_t key : {0U, 0x3C6EF372U}) {
        for (int bits = 1; bits <= 10; ++bits) {
            const ScrambledNet net{bits, key};
            for (int part_bits = 0; part_bits <= bits; ++part_bits) {
                const std::uint32_t part = 1U << (bits - part_bits);
                std::set<std::uint32_t> numbers;
                for (std::uint32_t m = 0; m < (1U << bits); ++m) {
                    numbers.insert(net.in_parts(m, part_bits));
                }
                EXPECT_EQ(numbers.size(), 1U << bits);
                EXPECT_EQ(*numbers.rbegin(), (1U << bits) - 1U);
                for (std::uint32_t first = 0; first < (1U << bits); first += part) {
                    EXPECT_TRUE(is_net(net, bits, part_bits, first, first + part)) << bits << " " << part_bits;
                }
            }
        }
    }
}

TEST(ScrambledNet, TheFirstFourPointsOfSixteenOfSixtyFourAreANetAsWell) {
    EXPECT_TRUE(is_net(ScrambledNet{6, 0x9E3779B9U}, 6, 2, 0, 4));
}

TEST(StrataBoard, DisagreesOnlyWhereSeenAndUnseenAreNeighbours) {
    const Board left_half = 0x0F0F0F0F0F0F0F0FULL;
    EXPECT_EQ(disagreeing(left_half, left_half, false), 0x1818181818181818ULL);
    EXPECT_EQ(disagreeing(~Board{0}, ~Board{0}, false), 0U);
    EXPECT_EQ(disagreeing(0, 0, false), 0U);
    EXPECT_EQ(disagreeing(0, ~Board{0}, false), ~Board{0});
    EXPECT_EQ(disagreeing(0xFFULL, 0xFFULL, true), 0x180ULL);
    // Nothing runs over from the end of one row to the beginning of the next.
    EXPECT_EQ(disagreeing(1ULL << 7U, 1ULL << 7U, false), (1ULL << 7U) | (1ULL << 6U) | (1ULL << 15U));
}

// --- V ---------------------------------------------------------------------------------------------------------

TEST(MaskedTracer, IsRightOnAverageForEveryNumberOfRays) {
    const Scene scene = half_plane();
    const View view = ramp(16);
    for (const bool line : {false, true}) {
        const Light light = line ? test::line({0, 0, 2}, {0.5, 0, 0}) : test::rectangle({0, 0, 2}, 0.5, 0.25);
        for (const int rays : {1, 5, 16, 17, 64, 100, 128, 256, 1000}) {
            std::vector<double> mean(kWidth, 0.0);
            constexpr int kSeeds = 16;
            for (std::uint32_t seed = 1; seed <= kSeeds; ++seed) {
                const std::vector<float> v = trace(scene, light, view, {.rays = rays, .first_rays = 16, .seed = seed});
                for (std::size_t i = 0; i < v.size(); ++i) {
                    mean[i % kWidth] += v[i] / (16.0 * kSeeds);
                }
            }
            // 256 estimates each, of which a single ray has a standard deviation of 1/2 at most.
            const double five_errors = 5.0 * 0.5 / std::sqrt(256.0 * std::min(rays, 16));
            for (std::size_t x = 0; x < kWidth; ++x) {
                EXPECT_NEAR(mean[x], ramp_v(x), five_errors) << "rays " << rays << " x " << x << " line " << line;
            }
        }
    }
}

TEST(MaskedTracer, OfFewPixelsAThinWireIsNotMissedOnAverage) {
    // A wire of 1 % of the light's width, seen by one pixel only: nothing around tells of it.
    Scene scene;
    scene.instances = {test::place(test::square(10)),
                       test::place(test::quad({0.1F, -5, 1}, {0.105F, -5, 1}, {0.105F, 5, 1}, {0.1F, 5, 1}))};
    scene.instances[0].casts = false;
    const Light light = test::rectangle({0, 0, 2}, 0.5, 0.5);
    std::vector<Point> points(81, Point{{5.0, 0, 0}});
    points[40] = {{0.0, 0, 0}};
    const View view = test::view_of(points, 9);
    double mean = 0.0;
    constexpr int kSeeds = 1000;
    for (std::uint32_t seed = 1; seed <= kSeeds; ++seed) {
        mean += trace(scene, light, view, {.rays = 256, .first_rays = 16, .seed = seed})[40] / kSeeds;
    }
    EXPECT_NEAR(mean, 0.99, 5.0 * std::sqrt(0.01 / 16.0 / kSeeds));
}

TEST(MaskedTracer, SpendsFewRaysWhereNothingChanges) {
    MaskedTraceCounts counts;
    const View view = ramp(16);
    trace(half_plane(), test::rectangle({0, 0, 2}, 0.5, 0.25), view, {.rays = 1024}, &counts);
    EXPECT_EQ(counts.pixels, view.size());
    EXPECT_LT(counts.full_pixels, view.size() * 5 / 8);  // half of them are in the penumbra
    // In the penumbra 64 and, of 64 strata, the columns at and beside the edge: three or four of eight.
    EXPECT_LT(counts.rays, view.size() * 16 + counts.full_pixels * (64 + 1024 / 2));
}

TEST(MaskedTracer, ErrorFallsAtLeastAsJitteredSamplesDo) {
    const View view = ramp(64);
    const Scene scene = half_plane();
    const Light light = test::rectangle({0, 0, 2}, 0.5, 0.25);
    double before = 1.0;
    for (const int rays : {16, 64, 256, 1024}) {
        const std::vector<float> v = trace(scene, light, view, {.rays = rays, .first_rays = 16});
        const double rms = rms_on_ramp(v);
        EXPECT_LT(rms, 0.41 * std::pow(rays, -0.75)) << rays;
        EXPECT_LT(rms, 0.6 * before);
        before = rms;
    }
}

TEST(SharedFit, IsExactWhereVIsLinearAlsoAtTheEndOfASurface) {
    View view = ramp(9);
    std::vector<float> v(view.size());
    for (std::size_t i = 0; i < v.size(); ++i) {
        v[i] = 0.1F + 0.01F * static_cast<float>(i % kWidth) + 0.02F * static_cast<float>(i / kWidth);
    }
    for (const std::size_t pixel : {std::size_t{0}, std::size_t{4 * kWidth + 20}, std::size_t{9 * kWidth - 1}}) {
        const SharedFit fit = fit_around(view, v, pixel, 2);
        EXPECT_NEAR(fit.visibility, v[pixel], 1e-5F);
        EXPECT_NEAR(fit.slope, std::hypot(0.01F, 0.02F), 1e-5F);
        EXPECT_NEAR(fit.scatter, 0.0F, 1e-3F);
    }
}

TEST(SharedFit, TakesNothingFromOtherSurfacesNorFromWhatIsUnknown) {
    View view = ramp(9);
    std::vector<float> v(view.size(), 0.5F);
    const std::size_t pixel = 4 * kWidth + 20;
    view.instance[pixel + 1] = 1;
    v[pixel + 1] = 1.0F;
    view.triangle[pixel - 1] = 7;
    view.normal_ws[pixel - 1] = {1, 0, 0};
    v[pixel - 1] = 1.0F;
    v[pixel + 2] = -1.0F;
    EXPECT_NEAR(fit_around(view, v, pixel, 2).visibility, 0.5F, 1e-6F);
    view.normal_ws[pixel - 1] = view.normal_ws[pixel];  // another triangle of the same plane
    EXPECT_GT(fit_around(view, v, pixel, 2).visibility, 0.51F);
}

TEST(SharedFit, SaysWhenTooFewPixelsCanTell) {
    const View row = ramp(1);
    const std::vector<float> v(row.size(), 0.25F);
    const SharedFit fit = fit_around(row, v, 20, 4);
    EXPECT_EQ(fit.visibility, 0.25F);
    EXPECT_TRUE(std::isinf(fit.scatter));
}

TEST(SharedFit, SeesAThinLineByItsScatterAndAnEdgeByItsSlope) {
    const View view = ramp(9);
    const std::size_t pixel = 4 * kWidth + 20;
    std::vector<float> line(view.size(), 1.0F);
    std::vector<float> edge(view.size(), 1.0F);
    for (std::size_t y = 0; y < 9; ++y) {
        line[y * kWidth + 20] = 0.0F;
        std::fill_n(edge.begin() + static_cast<std::ptrdiff_t>(y * kWidth), 20, 0.0F);
    }
    EXPECT_LT(fit_around(view, line, pixel, 2).slope, 1e-6F);
    EXPECT_GT(fit_around(view, line, pixel, 2).scatter, 0.4F);         // 0.4 sqrt(25 / 22)
    EXPECT_NEAR(fit_around(view, edge, pixel, 2).slope, 0.3F, 1e-5F);  // (1 + 2 + 2 + 1) 5 / 50 / 2
}

TEST(MaskedTracer, SharedFirstRaysLeaveAThirdOfTheErrorOnAWidePenumbra) {
    const View view = ramp(64);
    const Light light = test::rectangle({0, 0, 2}, 0.5, 0.25);
    const std::vector<float> alone = trace(half_plane(), light, view, {.rays = 4, .first_rays = 4});
    const std::vector<float> shared = trace(half_plane(), light, view, {.rays = 4, .first_rays = 4, .share = 2});
    EXPECT_LT(rms_on_ramp(shared), rms_on_ramp(alone) / 3.0);
}

TEST(MaskedTracer, AHardEdgeIsNotBlurredBySharing) {
    // A light of a hundredth of the ramp's pixels: every row goes from 0 to 1 in one step.
    const View view = ramp(64);
    const Light light = test::rectangle({0, 0, 2}, 0.002, 0.002);
    const std::vector<float> v = trace(half_plane(), light, view, {.rays = 64, .first_rays = 16, .share = 2});
    for (std::size_t i = 0; i < v.size(); ++i) {
        const double x = ramp_v(i) - 0.5;  // of the edge, in metres, where the ramp is not clamped
        if (std::abs(x) > 0.01) {
            EXPECT_EQ(v[i], x > 0.0 ? 1.0F : 0.0F) << i;
        }
    }
}

TEST(MaskedTracer, ANetThatIsGoneOnFromErrsAsOneThatIsCastAtOnce) {
    // A penumbra of four pixels: the plane does not fit, so the pixels in it go on.
    const View view = ramp(256);
    const Light light = test::rectangle({0, 0, 2}, 0.08, 0.25);
    const auto v_at = [](std::size_t i) { return std::clamp(0.5 + (ramp_v(i) - 0.5) / 0.16, 0.0, 1.0); };
    const auto rms = [&](const MaskedTraceOptions& options, MaskedTraceCounts& counts) {
        const std::vector<float> v = trace(half_plane(), light, view, options, &counts);
        double sum = 0.0;
        int inside = 0;
        for (std::size_t i = 0; i < v.size(); ++i) {
            if (v_at(i) > 0.02 && v_at(i) < 0.98) {
                sum += (v[i] - v_at(i)) * (v[i] - v_at(i));
                ++inside;
            }
        }
        EXPECT_GT(inside, 500);
        return std::sqrt(sum / inside);
    };
    MaskedTraceCounts gone_on;
    MaskedTraceCounts at_once;
    const double first = rms({.rays = 64, .first_rays = 16, .share = 1}, gone_on);
    const double all = rms({.rays = 64, .first_rays = 64}, at_once);
    EXPECT_LT(first, 1.1 * all);
    // 4 of all, 12 more near the penumbra, 48 more in it; of 48 columns eight and four.
    EXPECT_LT(gone_on.rays, at_once.rays / 4);
}

TEST(MaskedTracer, WhereThePixelsAroundAgreeFourRaysAreEnoughToShare) {
    const View view = ramp(64);
    MaskedTraceCounts counts;
    trace(half_plane(), test::rectangle({0, 0, 2}, 0.002, 0.002), view, {.rays = 64, .first_rays = 64, .share = 1},
          &counts);
    // Of 48 columns only the two or four beside the edge go on.
    EXPECT_LE(counts.rays, view.size() * 4 + 64 * 4 * 60);
    EXPECT_GE(counts.rays, view.size() * 4 + 64 * 2 * 60);
}

TEST(MaskedTracer, MoreFirstRaysThanRaysAreAsManyAsRays) {
    const View view = ramp(32);
    const Light light = test::rectangle({0, 0, 2}, 0.25, 0.25);
    for (const int rays : {4, 16}) {
        EXPECT_EQ(trace(half_plane(), light, view, {.rays = rays, .first_rays = 64, .share = 1}),
                  trace(half_plane(), light, view, {.rays = rays, .first_rays = rays, .share = 1}));
    }
}

TEST(MaskedTracer, SharingServesEveryNumberOfRays) {
    // Powers of two go on from what they have, others cast anew: the error falls with both.
    const View view = ramp(64);
    const Light light = test::rectangle({0, 0, 2}, 0.5, 0.25);
    for (const auto& [rays, first] : {std::pair{4, 4}, {12, 5}, {16, 4}, {24, 16}, {64, 16}, {100, 10}, {256, 16}}) {
        MaskedTraceCounts counts;
        const std::vector<float> v =
            trace(half_plane(), light, view, {.rays = rays, .first_rays = first, .share = 1}, &counts);
        EXPECT_LT(rms_on_ramp(v), 0.41 * std::pow(first, -0.75)) << rays << " " << first;
        for (const float x : v) {
            EXPECT_TRUE(x >= 0.0F && x <= 1.0F);
        }
        EXPECT_LE(counts.rays, view.size() * static_cast<std::size_t>(rays + first));
    }
}

std::vector<std::uint8_t> open_pixels(const View& view, std::span<const std::uint8_t> listed, const Light& light,
                                      std::vector<float>& visibility) {
    Control control;
    const Scene scene = half_plane();
    const RayScene rays{scene, control};
    std::vector<std::uint8_t> open(view.size());
    find_penumbrae(rays, view, light, listed, 1, open, visibility, control);
    return open;
}

TEST(PilotRays, HoldAllOfAPenumbraAndLittleElse) {
    const View view = ramp(64);
    std::vector<float> visibility(view.size(), -1.0F);
    const std::vector<std::uint8_t> listed(view.size(), 1);
    const auto open = open_pixels(view, listed, test::rectangle({0, 0, 2}, 0.5, 0.25), visibility);
    int in_ends = 0;
    int missed = 0;
    for (std::size_t i = 0; i < view.size(); ++i) {
        const double v = -0.5 + 2.0 * (static_cast<double>(i % kWidth) + 0.5) / kWidth;  // not clamped
        const double window = 2.0 * kPilotRadius / kWidth;
        if (v < -window || v > 1.0 + window) {
            EXPECT_EQ(open[i], 0) << v;
            EXPECT_EQ(visibility[i], v > 0.5 ? 1.0F : 0.0F);
        }
        // One column of strata is surely seen and one surely hidden, and each window has pixels of both.
        if (v > 0.25 && v < 0.75) {
            EXPECT_EQ(open[i], 1) << v;
        }
        // Nearer to the ends a window has six pixels or more that can tell, at 1 - 4 V in the worst case: by chance.
        in_ends += (v > 0.1 && v <= 0.25) || (v >= 0.75 && v < 0.9) ? 1 : 0;
        missed += ((v > 0.1 && v <= 0.25) || (v >= 0.75 && v < 0.9)) && open[i] == 0 ? 1 : 0;
    }
    EXPECT_GT(in_ends, 300);
    EXPECT_LT(missed, 0.05 * in_ends);  // 0.6^6
}

TEST(PilotRays, LookAtListedPixelsAlone) {
    const View view = ramp(8);
    std::vector<float> visibility(view.size(), -1.0F);
    std::vector<std::uint8_t> listed(view.size(), 0);
    for (std::size_t i = 0; i < view.size(); ++i) {
        listed[i] = ramp_v(i) == 1.0 ? 1 : 0;  // the dark and the half dark ones are not asked
    }
    const auto open = open_pixels(view, listed, test::rectangle({0, 0, 2}, 0.5, 0.25), visibility);
    for (std::size_t i = 0; i < view.size(); ++i) {
        EXPECT_EQ(open[i], 0);
        EXPECT_EQ(visibility[i], listed[i] != 0 ? 1.0F : -1.0F);
    }
}

TEST(PilotRays, DoNotDependOnTheNumberOfThreads) {
    const View view = ramp(32);
    const std::vector<std::uint8_t> listed(view.size(), 1);
    const Light light = test::rectangle({0, 0, 2}, 0.5, 0.25);
    std::vector<float> one(view.size());
    std::vector<float> five(view.size());
    set_thread_count(1);
    const auto open_one = open_pixels(view, listed, light, one);
    set_thread_count(5);
    const auto open_five = open_pixels(view, listed, light, five);
    set_thread_count(0);
    EXPECT_EQ(one, five);
    EXPECT_EQ(open_one, open_five);
}

TEST(MaskedTracer, LeavesAloneWhatIsNotListed) {
    Control control;
    const Scene scene = half_plane();
    const RayScene rays{scene, control};
    const View view = ramp(8);
    std::vector<std::uint8_t> listed(view.size(), 0);
    std::vector<float> visibility(view.size(), -1.0F);
    listed[kWidth / 2] = 1;
    const MaskedTraceCounts counts =
        trace_masked(rays, view, test::rectangle({0, 0, 2}, 0.5, 0.25), listed, {.rays = 256}, visibility, control);
    EXPECT_EQ(counts.pixels, 1U);
    for (std::size_t i = 0; i < view.size(); ++i) {
        EXPECT_EQ(visibility[i] == -1.0F, i != kWidth / 2);
    }
}

TEST(MaskedTracer, DoesNotDependOnTheNumberOfThreads) {
    const View view = ramp(32);
    const Light light = test::rectangle({0, 0, 2}, 0.5, 0.25);
    set_thread_count(1);
    const std::vector<float> one = trace(half_plane(), light, view, {.rays = 256});
    set_thread_count(5);
    const std::vector<float> five = trace(half_plane(), light, view, {.rays = 256});
    set_thread_count(0);
    EXPECT_EQ(one, five);
}

}  // namespace
}  // namespace penumbra
