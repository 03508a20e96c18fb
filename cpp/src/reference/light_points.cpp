#include "reference/light_points.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>

#include "reference/vector_clones.h"

namespace penumbra {
namespace {

constexpr float kRounding = std::numeric_limits<float>::epsilon();
/// Area lights are aimed at this many roundings of their coordinates in front of their surface: a mesh that shares the
/// light's place (the emissive panel itself) must not hide it. The same reasoning as for kOffsetRoundings.
constexpr float kEndRoundings = 16.0F;
/// Spheres and lines have no front: their rays stop at this share of the way.
constexpr float kShareOfWay = 1.0F - 8.0F * kRounding;

struct Vec {
    float x, y, z;
};

PENUMBRA_INLINE float dot(const Vec& a, const Vec& b) noexcept {
    return a.x * b.x + a.y * b.y + a.z * b.z;
}

/// Any two unit vectors across the unit vector z, without a branch [Duff2017].
PENUMBRA_INLINE void across(const Vec& z, Vec& t, Vec& b) noexcept {
    const float sign = std::copysign(1.0F, z.z);
    const float p = -1.0F / (sign + z.z);
    const float q = z.x * z.y * p;
    t = {1.0F + sign * z.x * z.x * p, sign * q, -sign * z.x};
    b = {q, sign + z.y * z.y * p, -z.y};
}

/// Unit square to unit disc, equal areas, squares of the grid stay compact [Shirley1997]. The angle is at most a
/// quarter of a half turn, so short Taylor series are exact to float32; they vectorise where sin and cos do not.
/// @returns the square of the distance from the middle
PENUMBRA_INLINE float concentric(float u, float v, float& x, float& y) noexcept {
    const float a = 2.0F * u - 1.0F;
    const float b = 2.0F * v - 1.0F;
    const bool wide = std::abs(a) > std::abs(b);
    const float r = wide ? a : b;
    const float other = wide ? b : a;
    const float angle = (std::numbers::pi_v<float> / 4.0F) * other / (r == 0.0F ? 1.0F : r);
    const float t = angle * angle;
    const float sine =
        angle * (1.0F - t * (1.0F / 6.0F - t * (1.0F / 120.0F - t * (1.0F / 5040.0F - t * (1.0F / 362880.0F)))));
    const float cosine = 1.0F - t * (0.5F - t * (1.0F / 24.0F - t * (1.0F / 720.0F - t * (1.0F / 40320.0F))));
    x = r * (wide ? cosine : sine);
    y = r * (wide ? sine : cosine);
    return r * r;
}

}  // namespace

LightPoints::LightPoints(const Light& light, const AnchorFrame& frame)
    : light_{light}, frame_{frame}, kind_{light.kind}, single_point_{has_no_extent(light)} {
    const glm::dvec3 centre = frame.point(light.position_ws);
    const glm::dvec3 u = frame.vector(light.half_u_ws);
    const glm::dvec3 v = frame.vector(light.half_v_ws);
    // Only flat lights have a front to be aimed at.
    const auto in_front = [&](const glm::dvec3& point, const glm::dvec3& extent) {
        const glm::dvec3 reach = glm::abs(point) + extent;
        const double size = std::max({reach.x, reach.y, reach.z});
        return glm::vec3(point + light.direction_ws * (size * kEndRoundings * kRounding));
    };
    direction_ = glm::vec3(light.direction_ws);
    half_u_an_ = glm::vec3(u);
    half_v_an_ = glm::vec3(v);
    switch (kind_) {
        case LightKind::Point:
        case LightKind::Spot: {
            centre_an_ = glm::vec3(centre);
            const double radius = light.radius_m / frame.unit_m;
            radius_squared_an_ = static_cast<float>(radius * radius);
            break;
        }
        case LightKind::Sun: {
            // 2 sin^2 of a quarter of the angle: exact for small suns.
            const double s = std::sin(0.25 * light.sun_angle_rad);
            one_minus_cosine_ = static_cast<float>(2.0 * s * s);
            Vec t{};
            Vec b{};
            across({-direction_.x, -direction_.y, -direction_.z}, t, b);
            tangent_ = {t.x, t.y, t.z};
            bitangent_ = {b.x, b.y, b.z};
            break;
        }
        case LightKind::Rectangle:
        case LightKind::Ellipse:
            centre_an_ = in_front(centre, glm::abs(u) + glm::abs(v));
            one_dimensional_ = kind_ == LightKind::Rectangle && (u == glm::dvec3(0.0) || v == glm::dvec3(0.0));
            if (one_dimensional_ && u == glm::dvec3(0.0)) {
                half_u_an_ = glm::vec3(v);
                half_v_an_ = glm::vec3(0.0F);
            }
            break;
        case LightKind::Line:
            centre_an_ = glm::vec3(centre);
            one_dimensional_ = true;
            break;
        case LightKind::Polygon: {
            const glm::dvec3 first = light.corners_ws.front();
            glm::dvec3 extent{0.0};
            for (const glm::dvec3& corner : light.corners_ws) {
                extent = glm::max(extent, glm::abs(frame.vector(corner - first)));
            }
            centre_an_ = in_front(frame.point(first), extent);
            fan_count_ = std::min(kMaxFan, static_cast<int>(light.corners_ws.size()) - 2);
            std::array<double, kMaxFan> areas{};
            double total = 0.0;
            for (int i = 0; i < fan_count_; ++i) {
                const glm::dvec3 a = frame.vector(light.corners_ws[i + 1] - first);
                const glm::dvec3 b = frame.vector(light.corners_ws[i + 2] - first);
                fan_a_an_[i] = glm::vec3(a);
                fan_b_an_[i] = glm::vec3(b);
                areas[i] = glm::length(glm::cross(a, b));
                total += areas[i];
            }
            double begin = 0.0;
            for (int i = 0; i < fan_count_; ++i) {
                const double share = total > 0.0 ? areas[i] / total : 1.0 / fan_count_;
                fan_begin_[i] = static_cast<float>(begin);
                fan_per_share_[i] = share > 0.0 ? static_cast<float>(1.0 / share) : 0.0F;
                begin += share;
            }
            break;
        }
    }
}

double LightPoints::scale(const glm::dvec3& position_ws) const noexcept {
    constexpr double kPi = std::numbers::pi;
    const Light& light = light_;
    switch (kind_) {
        case LightKind::Point:
        case LightKind::Spot: {
            const glm::dvec3 to_centre = light.position_ws - position_ws;
            const double s = light.radius_m * light.radius_m / glm::dot(to_centre, to_centre);
            return s < 1.0 ? 2.0 * kPi * s / (1.0 + std::sqrt(1.0 - s)) : 4.0 * kPi;
        }
        case LightKind::Sun: {
            const double s = std::sin(0.25 * light.sun_angle_rad);
            return 4.0 * kPi * s * s;
        }
        case LightKind::Rectangle:
            return 4.0 * glm::length(glm::cross(light.half_u_ws, light.half_v_ws));
        case LightKind::Ellipse:
            return kPi * glm::length(glm::cross(light.half_u_ws, light.half_v_ws));
        case LightKind::Line:
            return 2.0 * glm::length(light.half_u_ws);
        case LightKind::Polygon: {
            glm::dvec3 twice{0.0};
            for (std::size_t i = 2; i < light.corners_ws.size(); ++i) {
                twice += glm::cross(light.corners_ws[i - 1] - light.corners_ws[0],
                                    light.corners_ws[i] - light.corners_ws[0]);
            }
            return 0.5 * glm::length(twice);
        }
    }
    return 0.0;
}

// Every case below is one branch-free loop over the lanes, so that the compiler makes vector code of it.
template <bool Weighted>
PENUMBRA_INLINE void LightPoints::aim_lanes(const ReceiverLanes& receivers, const SampleLanes& samples, RayPacket& rays,
                                            [[maybe_unused]] float* weight) const noexcept {
    const ReceiverLanes& r = receivers;
    alignas(64) std::array<float, kRayLanes> dx;
    alignas(64) std::array<float, kRayLanes> dy;
    alignas(64) std::array<float, kRayLanes> dz;
    alignas(64) std::array<float, kRayLanes> end{};

    switch (kind_) {
        case LightKind::Point:
        case LightKind::Spot:
            for (int i = 0; i < kRayLanes; ++i) {
                const Vec to_centre{centre_an_.x - r.px[i], centre_an_.y - r.py[i], centre_an_.z - r.pz[i]};
                const float d2 = dot(to_centre, to_centre);
                const float d = std::sqrt(d2);
                const bool inside = d2 < radius_squared_an_;
                // From 1 / d^2, which need not wait for the root as everything below would have to.
                const bool apart = d2 > std::numeric_limits<float>::min();
                const float per_d2 = 1.0F / (apart ? d2 : 1.0F);
                const float per_d = d * per_d2;
                const Vec z{to_centre.x * per_d, to_centre.y * per_d, apart ? to_centre.z * per_d : 1.0F};
                Vec t;
                Vec b;
                across(z, t, b);
                float x;
                float y;
                const float rho2 = concentric(samples.u[i], samples.v[i], x, y);
                // k = 1 - cosine of the cone's half angle, 2 for all directions; cancels nothing for small spheres.
                const float s = std::min(1.0F, radius_squared_an_ * per_d2);
                const float k = inside ? 2.0F : s / (1.0F + std::sqrt(1.0F - s));
                const float cosine = 1.0F - rho2 * k;
                const float across_squared = std::max(0.0F, k * (2.0F - rho2 * k));  // sine^2 / rho^2
                const float across_scale = std::sqrt(across_squared);
                x *= across_scale;
                y *= across_scale;
                dx[i] = z.x * cosine + t.x * x + b.x * y;
                dy[i] = z.y * cosine + t.y * x + b.y * y;
                dz[i] = z.z * cosine + t.z * x + b.z * y;
                const float half_chord = std::sqrt(std::max(0.0F, radius_squared_an_ - d2 * (rho2 * across_squared)));
                end[i] = std::max(0.0F, d * cosine + (inside ? half_chord : -half_chord)) * kShareOfWay;
            }
            break;
        case LightKind::Sun:
            for (int i = 0; i < kRayLanes; ++i) {
                float x;
                float y;
                const float rho2 = concentric(samples.u[i], samples.v[i], x, y);
                const float cosine = 1.0F - rho2 * one_minus_cosine_;
                const float across_scale =
                    std::sqrt(std::max(0.0F, one_minus_cosine_ * (2.0F - rho2 * one_minus_cosine_)));
                x *= across_scale;
                y *= across_scale;
                dx[i] = -direction_.x * cosine + tangent_.x * x + bitangent_.x * y;
                dy[i] = -direction_.y * cosine + tangent_.y * x + bitangent_.y * y;
                dz[i] = -direction_.z * cosine + tangent_.z * x + bitangent_.z * y;
                end[i] = std::numeric_limits<float>::infinity();
            }
            break;
        case LightKind::Rectangle:
        case LightKind::Line: {
            const float share = kind_ == LightKind::Line ? kShareOfWay : 1.0F;
            for (int i = 0; i < kRayLanes; ++i) {
                const float x = 2.0F * samples.u[i] - 1.0F;
                const float y = 2.0F * samples.v[i] - 1.0F;
                dx[i] = centre_an_.x + x * half_u_an_.x + y * half_v_an_.x - r.px[i];
                dy[i] = centre_an_.y + x * half_u_an_.y + y * half_v_an_.y - r.py[i];
                dz[i] = centre_an_.z + x * half_u_an_.z + y * half_v_an_.z - r.pz[i];
                end[i] = share;
            }
            break;
        }
        case LightKind::Ellipse:
            for (int i = 0; i < kRayLanes; ++i) {
                float x;
                float y;
                concentric(samples.u[i], samples.v[i], x, y);
                dx[i] = centre_an_.x + x * half_u_an_.x + y * half_v_an_.x - r.px[i];
                dy[i] = centre_an_.y + x * half_u_an_.y + y * half_v_an_.y - r.py[i];
                dz[i] = centre_an_.z + x * half_u_an_.z + y * half_v_an_.z - r.pz[i];
                end[i] = 1.0F;
            }
            break;
        case LightKind::Polygon:
            for (int i = 0; i < kRayLanes; ++i) {
                dx[i] = dy[i] = dz[i] = 0.0F;
                end[i] = 1.0F;
            }
            for (int f = 0; f < fan_count_; ++f) {
                const glm::vec3 a = fan_a_an_[f];
                const glm::vec3 b = fan_b_an_[f];
                for (int i = 0; i < kRayLanes; ++i) {
                    // u sweeps around the first corner, v goes outwards: continuous across the seams of the fan.
                    const bool mine = samples.u[i] >= fan_begin_[f];  // a later triangle overwrites an earlier one
                    const float share = (samples.u[i] - fan_begin_[f]) * fan_per_share_[f];
                    const float outwards = std::sqrt(samples.v[i]);
                    const float along_b = outwards * std::min(1.0F, std::max(0.0F, share));
                    const float along_a = outwards - along_b;
                    dx[i] = mine ? along_a * a.x + along_b * b.x : dx[i];
                    dy[i] = mine ? along_a * a.y + along_b * b.y : dy[i];
                    dz[i] = mine ? along_a * a.z + along_b * b.z : dz[i];
                }
            }
            for (int i = 0; i < kRayLanes; ++i) {
                dx[i] += centre_an_.x - r.px[i];
                dy[i] += centre_an_.y - r.py[i];
                dz[i] += centre_an_.z - r.pz[i];
            }
            break;
    }

    if constexpr (Weighted) {
        switch (kind_) {
            case LightKind::Point:
            case LightKind::Spot:
            case LightKind::Sun:
                for (int i = 0; i < kRayLanes; ++i) {
                    weight[i] = std::max(0.0F, r.sx[i] * dx[i] + r.sy[i] * dy[i] + r.sz[i] * dz[i]);
                }
                break;
            case LightKind::Rectangle:
            case LightKind::Ellipse:
            case LightKind::Polygon:
                for (int i = 0; i < kRayLanes; ++i) {
                    const float d2 = dx[i] * dx[i] + dy[i] * dy[i] + dz[i] * dz[i];
                    const float here = std::max(0.0F, r.sx[i] * dx[i] + r.sy[i] * dy[i] + r.sz[i] * dz[i]);
                    const float there =
                        std::max(0.0F, -(direction_.x * dx[i] + direction_.y * dy[i] + direction_.z * dz[i]));
                    weight[i] = d2 > 0.0F ? (here / d2) * (there / d2) : 0.0F;
                }
                break;
            case LightKind::Line: {
                const float length = glm::length(half_u_an_);
                const glm::vec3 axis = length > 0.0F ? half_u_an_ / length : glm::vec3(0.0F);
                for (int i = 0; i < kRayLanes; ++i) {
                    const float d2 = dx[i] * dx[i] + dy[i] * dy[i] + dz[i] * dz[i];
                    const float here = std::max(0.0F, r.sx[i] * dx[i] + r.sy[i] * dy[i] + r.sz[i] * dz[i]);
                    const Vec c{dy[i] * axis.z - dz[i] * axis.y, dz[i] * axis.x - dx[i] * axis.z,
                                dx[i] * axis.y - dy[i] * axis.x};
                    // A line without length is a point: it has no sine.
                    const float sine = length > 0.0F ? std::sqrt(dot(c, c)) : std::sqrt(d2);
                    weight[i] = d2 > 0.0F ? (here / d2) * (sine / d2) : 0.0F;
                }
                break;
            }
        }
    }

    // Directions stay exact to the end point for lights of finite distance; a parallel shift is as good for the rest.
    const float towards_target = end[0] <= 1.0F && kind_ != LightKind::Point && kind_ != LightKind::Spot ? 1.0F : 0.0F;
    for (int i = 0; i < kRayLanes; ++i) {
        const float above = r.nx[i] * dx[i] + r.ny[i] * dy[i] + r.nz[i] * dz[i];
        const float step = above >= 0.0F ? r.offset[i] : -r.offset[i];
        const float sx = step * r.nx[i];
        const float sy = step * r.ny[i];
        const float sz = step * r.nz[i];
        rays.org_x[i] = r.px[i] + sx;
        rays.org_y[i] = r.py[i] + sy;
        rays.org_z[i] = r.pz[i] + sz;
        rays.dir_x[i] = dx[i] - towards_target * sx;
        rays.dir_y[i] = dy[i] - towards_target * sy;
        rays.dir_z[i] = dz[i] - towards_target * sz;
        rays.tnear[i] = 0.0F;
        rays.tfar[i] = end[i];
    }
}

PENUMBRA_VECTOR_CLONES void LightPoints::aim(const ReceiverLanes& receivers, const SampleLanes& samples,
                                             RayPacket& rays) const noexcept {
    aim_lanes<false>(receivers, samples, rays, nullptr);
}

PENUMBRA_VECTOR_CLONES void LightPoints::aim(const ReceiverLanes& receivers, const SampleLanes& samples,
                                             RayPacket& rays, float* weight) const noexcept {
    aim_lanes<true>(receivers, samples, rays, weight);
}

}  // namespace penumbra
