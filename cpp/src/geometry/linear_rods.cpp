#include "geometry/linear_rods.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "geometry/light_shape.h"

namespace penumbra {

namespace {

using Polygon2 = std::vector<glm::dvec2>;

/// A flat shape: the point (s, t) lies at centre + s u + t v.
struct FlatShape {
    glm::dvec3 centre_ws{0.0}, u_ws{0.0}, v_ws{0.0};
    Polygon2 outline;  ///< convex, counter-clockwise in (s, t)
};

/// Area and first and second moments of a convex polygon.
struct Moments {
    double area = 0.0;
    glm::dvec2 mean{0.0};
    double s_variance = 0.0, t_variance = 0.0, covariance = 0.0;
};

Moments moments_of(const Polygon2& polygon) {
    Moments m;
    double ss = 0.0;
    double tt = 0.0;
    double st = 0.0;
    for (std::size_t i = 2; i < polygon.size(); ++i) {
        const glm::dvec2 a = polygon[0];
        const glm::dvec2 b = polygon[i - 1];
        const glm::dvec2 c = polygon[i];
        const double area = 0.5 * ((b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x));
        const glm::dvec2 sum = a + b + c;
        m.area += area;
        m.mean += area / 3.0 * sum;
        // Means of squares over a triangle: (a^2 + b^2 + c^2 + (a + b + c)^2) / 12.
        ss += area / 12.0 * (a.x * a.x + b.x * b.x + c.x * c.x + sum.x * sum.x);
        tt += area / 12.0 * (a.y * a.y + b.y * b.y + c.y * c.y + sum.y * sum.y);
        st += area / 12.0 * (a.x * a.y + b.x * b.y + c.x * c.y + sum.x * sum.y);
    }
    if (!(m.area > 0.0)) {
        return m;
    }
    m.mean /= m.area;
    m.s_variance = std::max(0.0, ss / m.area - m.mean.x * m.mean.x);
    m.t_variance = std::max(0.0, tt / m.area - m.mean.y * m.mean.y);
    m.covariance = st / m.area - m.mean.x * m.mean.y;
    return m;
}

/// What of the polygon lies at t >= low (side = 1) or t <= low (side = -1).
Polygon2 cut(const Polygon2& polygon, double level, double side) {
    Polygon2 kept;
    for (std::size_t i = 0; i < polygon.size(); ++i) {
        const glm::dvec2 a = polygon[i];
        const glm::dvec2 b = polygon[(i + 1) % polygon.size()];
        const double from = side * (a.y - level);
        const double to = side * (b.y - level);
        if (from >= 0.0) {
            kept.push_back(a);
        }
        if ((from > 0.0 && to < 0.0) || (from < 0.0 && to > 0.0)) {
            kept.push_back(a + (b - a) * (from / (from - to)));
        }
    }
    return kept;
}

/// The t below which the share `share` of the area lies.
double level_of_share(const Polygon2& polygon, double area, double share) {
    double low = polygon[0].y;
    double high = low;
    for (const glm::dvec2& p : polygon) {
        low = std::min(low, p.y);
        high = std::max(high, p.y);
    }
    for (int i = 0; i < 60; ++i) {
        const double middle = 0.5 * (low + high);
        (moments_of(cut(polygon, middle, -1.0)).area < share * area ? low : high) = middle;
    }
    return 0.5 * (low + high);
}

std::vector<LinearRod> strips_of(const FlatShape& shape, int count) {
    std::vector<LinearRod> rods;
    const double area = moments_of(shape.outline).area;
    double below = -std::numeric_limits<double>::infinity();
    for (int i = 0; i < count; ++i) {
        Polygon2 strip = i > 0 ? cut(shape.outline, below, 1.0) : shape.outline;
        if (i + 1 < count) {
            below = level_of_share(shape.outline, area, (i + 1.0) / count);
            strip = cut(strip, below, -1.0);
        }
        const Moments m = moments_of(strip);
        rods.push_back({shape.centre_ws + m.mean.x * shape.u_ws + m.mean.y * shape.v_ws,
                        std::sqrt(3.0 * m.s_variance) * shape.u_ws, 1.0 / count});
    }
    return rods;
}

Polygon2 unit_square() {
    return {{-1, -1}, {1, -1}, {1, 1}, {-1, 1}};
}

/// The unit disc as a regular polygon of equal area: its moments are the disc's to 1e-4.
Polygon2 unit_disc() {
    constexpr int kCorners = 256;
    const double step = 2.0 * std::numbers::pi / kCorners;
    const double radius = std::sqrt(step / std::sin(step));
    Polygon2 corners;
    for (int i = 0; i < kCorners; ++i) {
        corners.emplace_back(radius * std::cos(i * step), radius * std::sin(i * step));
    }
    return corners;
}

/// Unit vector perpendicular to `axis`, any.
glm::dvec3 perpendicular_to(const glm::dvec3& axis) {
    const glm::dvec3 a = glm::abs(axis);
    const glm::dvec3 helper = a.x <= a.y && a.x <= a.z ? glm::dvec3{1, 0, 0}
                              : a.y <= a.z             ? glm::dvec3{0, 1, 0}
                                                       : glm::dvec3{0, 0, 1};
    return glm::normalize(glm::cross(helper, axis));
}

/// Across the light's direction and across what stands upright on the lit surfaces: shadows of such casters lie along
/// the light's direction, and their penumbrae across it.
FlatShape round_shape(const glm::dvec3& centre_ws, const glm::dvec3& axis_ws, double radius,
                      const glm::dvec3& first_ws) {
    const glm::dvec3 across = first_ws - glm::dot(first_ws, axis_ws) * axis_ws;
    const double length = glm::length(across);
    FlatShape shape;
    shape.centre_ws = centre_ws;
    shape.u_ws = radius * (length > 1e-6 ? across / length : perpendicular_to(axis_ws));
    shape.v_ws = glm::cross(axis_ws, shape.u_ws);
    shape.outline = unit_disc();
    return shape;
}

FlatShape sphere_outline(const Light& light, const RodSurroundings& surroundings) {
    const double distance = glm::length(surroundings.towards_ws);
    const glm::dvec3 axis_ws = distance > 0.0 ? surroundings.towards_ws / distance : light.direction_ws;
    // The circle in which the tangents from the lit place touch the sphere; inside the sphere its great circle.
    const double ratio = distance > light.radius_m ? light.radius_m / distance : 0.0;
    const glm::dvec3 first_ws =
        light.kind == LightKind::Spot ? light.half_u_ws : glm::cross(axis_ws, surroundings.upright_ws);
    return round_shape(light.position_ws + ratio * light.radius_m * axis_ws, axis_ws,
                       light.radius_m * std::sqrt(1.0 - ratio * ratio), first_ws);
}

/// A convex polygon in coordinates along its longest axis and across it.
FlatShape polygon_shape(const Light& light) {
    FlatShape shape;
    shape.centre_ws = light.position_ws;
    const glm::dvec3 first = perpendicular_to(light.direction_ws);
    const glm::dvec3 second = glm::cross(light.direction_ws, first);
    for (const glm::dvec3& corner : light.corners_ws) {
        const glm::dvec3 offset = corner - light.position_ws;
        shape.outline.emplace_back(glm::dot(offset, first), glm::dot(offset, second));
    }
    double doubled = 0.0;
    for (std::size_t i = 0; i < shape.outline.size(); ++i) {
        const glm::dvec2 a = shape.outline[i];
        const glm::dvec2 b = shape.outline[(i + 1) % shape.outline.size()];
        doubled += a.x * b.y - a.y * b.x;
    }
    if (doubled < 0.0) {
        std::ranges::reverse(shape.outline);
    }
    const Moments m = moments_of(shape.outline);
    const double turn = 0.5 * std::atan2(2.0 * m.covariance, m.s_variance - m.t_variance);
    const double c = std::cos(turn);
    const double s = std::sin(turn);
    for (glm::dvec2& p : shape.outline) {
        p = {c * p.x + s * p.y, c * p.y - s * p.x};
    }
    shape.u_ws = c * first + s * second;
    shape.v_ws = c * second - s * first;
    return shape;
}

std::vector<LinearRod> sides_of(const std::vector<glm::dvec3>& corners, bool equal) {
    std::vector<LinearRod> rods;
    double length = 0.0;
    for (std::size_t i = 0; i < corners.size(); ++i) {
        const glm::dvec3& a = corners[i];
        const glm::dvec3& b = corners[(i + 1) % corners.size()];
        rods.push_back({0.5 * (a + b), 0.5 * (b - a), glm::length(b - a)});
        length += rods.back().weight;
    }
    for (LinearRod& rod : rods) {
        rod.weight = equal ? 1.0 / static_cast<double>(corners.size()) : rod.weight / length;
    }
    return rods;
}

/// Square lights get four strips, long ones fewer.
int strips_by_proportion(double along, double across) {
    return std::clamp(static_cast<int>(std::ceil(4.0 * across / along - 1e-6)), 1, 4);
}

}  // namespace

std::vector<LinearRod> linear_rods(const Light& light, RodLayout layout, int strips,
                                   const RodSurroundings& surroundings) {
    const bool sun = light.kind == LightKind::Sun;
    const LinearRod point{sun ? light.direction_ws : light.position_ws, glm::dvec3{0.0}, 1.0};
    if (has_no_extent(light)) {
        return {point};
    }
    const int round_strips = std::max(1, strips);
    switch (light.kind) {
        case LightKind::Line:
            return {{light.position_ws, light.half_u_ws, 1.0}};
        case LightKind::Point:
        case LightKind::Spot:
            return strips_of(sphere_outline(light, surroundings), round_strips);
        case LightKind::Sun: {
            const double slope = std::tan(0.5 * std::min(light.sun_angle_rad, 3.1));
            const FlatShape disc = round_shape(light.direction_ws, light.direction_ws, slope,
                                               glm::cross(light.direction_ws, surroundings.upright_ws));
            return strips_of(disc, round_strips);
        }
        case LightKind::Ellipse: {
            if (!(emitting_area(light) > 0.0)) {
                break;
            }
            FlatShape shape{light.position_ws, light.half_u_ws, light.half_v_ws, unit_disc()};
            // A disc keeps its own axes: rounding must not choose between equal ones.
            const double u2 = glm::dot(shape.u_ws, shape.u_ws);
            const double v2 = glm::dot(shape.v_ws, shape.v_ws);
            if (std::abs(glm::dot(shape.u_ws, shape.v_ws)) + std::abs(u2 - v2) > 1e-6 * (u2 + v2)) {
                principal_axes(shape.u_ws, shape.v_ws);
            }
            return strips_of(shape, round_strips);
        }
        case LightKind::Rectangle: {
            if (!(emitting_area(light) > 0.0)) {
                break;
            }
            FlatShape shape{light.position_ws, light.half_u_ws, light.half_v_ws, unit_square()};
            double along = glm::length(shape.u_ws);
            double across = glm::length(shape.v_ws);
            if (layout == RodLayout::Sides) {
                const glm::dvec3& c = shape.centre_ws;
                return sides_of({c - shape.u_ws - shape.v_ws, c + shape.u_ws - shape.v_ws, c + shape.u_ws + shape.v_ws,
                                 c - shape.u_ws + shape.v_ws},
                                false);
            }
            if (along < across) {
                std::swap(along, across);
                std::swap(shape.u_ws, shape.v_ws);
            }
            return strips_of(shape, strips > 0 ? strips : strips_by_proportion(along, across));
        }
        case LightKind::Polygon: {
            if (!(emitting_area(light) > 0.0)) {
                break;
            }
            const bool triangle = light.corners_ws.size() == 3;
            if (layout == RodLayout::Sides || (layout == RodLayout::Auto && triangle)) {
                return sides_of(light.corners_ws, triangle);
            }
            const FlatShape shape = polygon_shape(light);
            const Moments m = moments_of(shape.outline);
            return strips_of(
                shape, strips > 0 ? strips : strips_by_proportion(std::sqrt(m.s_variance), std::sqrt(m.t_variance)));
        }
    }
    // An area light of no width.
    return {{light.position_ws, longest_half_axis(light), 1.0}};
}

}  // namespace penumbra
