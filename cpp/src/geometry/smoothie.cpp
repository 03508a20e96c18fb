#include "geometry/smoothie.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "geometry/light_shape.h"

namespace penumbra {

namespace {

/// Beyond this half angle a sun's rim lies at no finite distance worth drawing.
constexpr double kWidestSun_rad = 1.4;

}  // namespace

double falloff(Falloff kind, double v) noexcept {
    v = std::clamp(v, 0.0, 1.0);
    switch (kind) {
        case Falloff::Linear:
            return v;
        case Falloff::Sinusoidal:
            return 0.5 - 0.5 * std::cos(std::numbers::pi * v);
        case Falloff::Cubic:
            return v * v * (3.0 - 2.0 * v);
        case Falloff::Disc: {
            const double x = 2.0 * v - 1.0;
            return 0.5 + (x * std::sqrt(std::max(0.0, 1.0 - x * x)) + std::asin(x)) / std::numbers::pi;
        }
    }
    return v;
}

double remapped_alpha(double alpha, double b_over_r) noexcept {
    return b_over_r >= 1.0 ? 1.0 : std::clamp(alpha / (1.0 - b_over_r), 0.0, 1.0);
}

double smoothie_width_m(double t_ip, double b_m, double r_m) noexcept {
    return t_ip * std::max(0.0, r_m - b_m);
}

LightExtent LightExtent::of(const Light& light, const glm::dmat3& ls_from_world) {
    LightExtent extent;
    const auto flat = [&](const glm::dvec3& axis_ws) { return glm::dvec2{ls_from_world * axis_ws}; };
    switch (light.kind) {
        case LightKind::Point:
        case LightKind::Spot:
        case LightKind::Sun:
            return disc_of(light);
        case LightKind::Rectangle:
        case LightKind::Line:
            extent.shape_ = Shape::Parallelogram;
            break;
        case LightKind::Ellipse:
            extent.shape_ = Shape::Ellipse;
            break;
        case LightKind::Polygon:
            extent.shape_ = Shape::Polygon;
            for (const glm::dvec3& corner : light.corners_ws) {
                extent.corners_.push_back(flat(corner - light.position_ws));
            }
            return extent;
    }
    extent.u_ = flat(light.half_u_ws);
    extent.v_ = flat(light.half_v_ws);
    return extent;
}

LightExtent LightExtent::disc_of(const Light& light) {
    LightExtent extent;
    switch (light.kind) {
        case LightKind::Point:
        case LightKind::Spot:
            extent.u_.x = light.radius_m;
            break;
        case LightKind::Sun:
            extent.u_.x = std::tan(std::min(0.5 * light.sun_angle_rad, kWidestSun_rad));
            break;
        default: {
            const double area = emitting_area(light);
            extent.u_.x = area > 0.0 ? std::sqrt(area / std::numbers::pi)
                                     : 2.0 / std::numbers::pi * glm::length(longest_half_axis(light));
        }
    }
    return extent;
}

double LightExtent::half_width(const glm::dvec2& outer_normal) const noexcept {
    const double along_u = glm::dot(u_, outer_normal);
    const double along_v = glm::dot(v_, outer_normal);
    switch (shape_) {
        case Shape::Disc:
            return u_.x;
        case Shape::Parallelogram:
            return std::abs(along_u) + std::abs(along_v);
        case Shape::Ellipse:
            return std::hypot(along_u, along_v);
        case Shape::Polygon: {
            double widest = 0.0;
            for (const glm::dvec2& corner : corners_) {
                widest = std::max(widest, -glm::dot(corner, outer_normal));
            }
            return widest;
        }
    }
    return 0.0;
}

double LightExtent::largest() const noexcept {
    double largest = 0.0;
    switch (shape_) {
        case Shape::Disc:
            return u_.x;
        case Shape::Parallelogram:
            return std::max(glm::length(u_ + v_), glm::length(u_ - v_));
        case Shape::Ellipse:
            return std::hypot(glm::length(u_), glm::length(v_));  // a bound
        case Shape::Polygon:
            for (const glm::dvec2& corner : corners_) {
                largest = std::max(largest, glm::length(corner));
            }
    }
    return largest;
}

}  // namespace penumbra
