#include "geometry/irradiance.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <vector>

#include "geometry/contour.h"
#include "geometry/light_shape.h"

namespace penumbra {

namespace {

constexpr double kPi = std::numbers::pi;

/// Any two unit vectors that make a right-handed frame with the unit vector z [Duff2017].
void make_frame(const glm::dvec3& z, glm::dvec3& x, glm::dvec3& y) {
    const double sign = std::copysign(1.0, z.z);
    const double a = -1.0 / (sign + z.z);
    const double b = z.x * z.y * a;
    x = {1.0 + sign * z.x * z.x * a, sign * b, -sign * z.x};
    y = {b, sign + z.y * z.y * a, -z.y};
}

/// Part above the horizon of the cone x = a cos t, y = b sin t, z = 1, where the horizon cuts it.
///
/// Lambert's contour over the arc above the horizon and the chord that closes it. With r = (a cos t, b sin t, 1) the
/// arc's integrand n . (r x r') / (2 |r|^2) has elementary integrals in t, sin t and cos t. For small cones the
/// constant term n . (z x r') is left out of arc and chord alike, as Contour does, and each term keeps its digits.
/// @param n unit normal of the receiver in the cone's frame; |n.z| < hypot(a n.x, b n.y)
double cut_cone_irradiance(double a, double b, const glm::dvec3& n) {
    const double reach = std::hypot(a * n.x, b * n.y);
    const double middle = std::atan2(b * n.y, a * n.x);
    const double width = std::acos(std::clamp(-n.z / reach, -1.0, 1.0));
    const std::array<double, 2> t{middle - width, middle + width};
    const double a2 = a * a;
    const double b2 = b * b;
    const double big_a = 1.0 + a2;
    const double big_b = 1.0 + b2;
    const double root = std::sqrt(big_b / big_a);
    const double root_less_one = (b2 - a2) / (big_a * (root + 1.0));
    const double radius = std::max(a, b);
    const Contour contour{{0.0, 0.0, 1.0}, n, radius};
    const bool small = contour.leaves_out_constant();

    double integral_1 = 2.0 * width;  // becomes sqrt(big_a big_b) times that of 1 / |r|^2
    double integral_cos = 0.0;        // of cos t / |r|^2; small: of cos t (1 - 1 / |r|^2)
    double integral_sin = 0.0;        // the same with sin t
    std::array<glm::dvec3, 2> end{};
    for (std::size_t k = 0; k < 2; ++k) {
        const double sign = k == 0 ? -1.0 : 1.0;
        const double s = std::sin(t[k]);
        const double c = std::cos(t[k]);
        const double r2 = 1.0 + a2 * c * c + b2 * s * s;
        integral_1 += sign * std::atan(root_less_one * s * c / (c * c + root * s * s));
        const double less_s = atan_ratio_less_one((b2 - a2) * s * s / big_a, r2 / big_a);
        const double less_c = atan_ratio_less_one((a2 - b2) * c * c / big_b, r2 / big_b);
        integral_cos += sign * s * (small ? a2 - less_s : 1.0 + less_s) / big_a;
        integral_sin -= sign * c * (small ? b2 - less_c : 1.0 + less_c) / big_b;
        end[k] = {a * c, b * s, 0.0};
    }
    const double direction = small ? 1.0 : -1.0;
    const double arc = n.z * a * b * integral_1 / std::sqrt(big_a * big_b) +
                       direction * (n.x * b * integral_cos + n.y * a * integral_sin);
    // The chord lies in the horizon, so n stands on it: the plain form needs its angle alone, which stays sound for a
    // cone as wide as a hemisphere.
    const glm::dvec3 last = end[1] + glm::dvec3{0.0, 0.0, 1.0};
    const glm::dvec3 first = end[0] + glm::dvec3{0.0, 0.0, 1.0};
    const double chord = small ? contour.edge(end[1], end[0])
                               : 0.5 * std::atan2(glm::length(glm::cross(last, first)), glm::dot(last, first));
    return std::max(0.0, 0.5 * arc + chord);
}

/// The largest root of x^2/(a^2 + m) + y^2/(b^2 + m) + h^2/m = 1: the squared third semi-axis of the quadric confocal
/// with the ellipse through the receiver, and minus the negative eigenvalue of the cone's polar form. All terms are
/// positive, so it keeps its digits where an eigenvalue solver would not.
double confocal_root(double a2, double b2, double x2, double y2, double h2) {
    // For equal axes it is a quadratic; the larger axis bounds the root from below, the smaller one from above.
    const auto equal_axes = [&](double axis2) {
        const double p = x2 + y2 + h2 - axis2;
        const double q = std::sqrt(p * p + 4.0 * axis2 * h2);
        return p >= 0.0 ? 0.5 * (p + q) : 2.0 * axis2 * h2 / (q - p);
    };
    double low = equal_axes(std::max(a2, b2));
    double high = std::max(low, equal_axes(std::min(a2, b2)));
    double m = low;
    for (int i = 0; i < 200 && high > low; ++i) {
        const double fa = x2 / (a2 + m);
        const double fb = y2 / (b2 + m);
        const double fh = h2 / m;
        const double f = fa + fb + fh - 1.0;
        (f > 0.0 ? low : high) = m;
        // One step towards the root of A + B / m with the same value and slope: exact where h^2/m dominates.
        const double slope_m = fa * m / (a2 + m) + fb * m / (b2 + m) + fh;  // minus m f'
        double next = slope_m > f ? m * slope_m / (slope_m - f) : high;
        if (!(next > low && next < high)) {
            next = high > 4.0 * low ? std::sqrt(low) * std::sqrt(high) : 0.5 * (low + high);
        }
        if (std::abs(next - m) <= 1e-16 * m || next == m) {
            break;
        }
        m = next;
    }
    return m;
}

}  // namespace

double polygon_irradiance(const glm::dvec3& towards_centre, std::span<const glm::dvec3> offsets,
                          const glm::dvec3& normal) {
    double radius = 0.0;
    glm::dvec3 area{0.0};
    for (std::size_t i = 0; i < offsets.size(); ++i) {
        radius = std::max(radius, glm::length(offsets[i]));
        area += glm::cross(offsets[i], offsets[(i + 1) % offsets.size()]);
    }
    const Contour contour{towards_centre, normal, radius};
    const double centre_height = glm::dot(normal, towards_centre);
    double sum = 0.0;
    bool open = false;
    glm::dvec3 left{0.0};     // where the contour went below the horizon
    glm::dvec3 entered{0.0};  // and where it came back
    for (std::size_t i = 0; i < offsets.size(); ++i) {
        const glm::dvec3& from = offsets[i];
        const glm::dvec3& to = offsets[(i + 1) % offsets.size()];
        const double at_from = centre_height + glm::dot(normal, from);
        const double at_to = centre_height + glm::dot(normal, to);
        if (at_from >= 0.0 && at_to >= 0.0) {
            sum += contour.edge(from, to);
            continue;
        }
        if (at_from < 0.0 && at_to < 0.0) {
            continue;
        }
        const glm::dvec3 cut = from + (to - from) * (at_from / (at_from - at_to));
        open = true;
        if (at_from >= 0.0) {
            sum += contour.edge(from, cut);
            left = cut;
        } else {
            sum += contour.edge(cut, to);
            entered = cut;
        }
    }
    if (open) {
        sum += contour.edge(left, entered);
    }
    return std::max(0.0, glm::dot(area, towards_centre) >= 0.0 ? sum : -sum);
}

double ellipse_irradiance(const glm::dvec3& towards_centre, glm::dvec3 u, glm::dvec3 v, const glm::dvec3& normal) {
    principal_axes(u, v);
    const double a = glm::length(u);
    const double b = glm::length(v);
    if (!(a > 0.0 && b > 0.0)) {
        return 0.0;
    }
    const glm::dvec3 axis_u = u / a;
    const glm::dvec3 axis_v = v / b;
    glm::dvec3 axis_w = glm::cross(axis_u, axis_v);
    double h = glm::dot(axis_w, towards_centre);
    if (h < 0.0) {
        axis_w = -axis_w;
        h = -h;
    }
    const double middle = glm::dot(normal, towards_centre);
    const double reach = std::hypot(glm::dot(normal, u), glm::dot(normal, v));
    if (!(h > 0.0) || middle <= -reach) {
        return 0.0;
    }
    const double x = glm::dot(axis_u, towards_centre);
    const double y = glm::dot(axis_v, towards_centre);
    const double m = confocal_root(a * a, b * b, x * x, y * y, h * h);
    // The cone's axis is the normal of the confocal quadric at the receiver.
    const glm::dvec3 along = axis_u * (x / (a * a + m)) + axis_v * (y / (b * b + m)) + axis_w * (h / m);
    const double along2 = glm::dot(along, along);
    const double whole = kPi * a * b * h / (m * std::sqrt((a * a + m) * (b * b + m)) * along2);
    if (middle >= reach) {
        return std::max(0.0, whole * glm::dot(normal, along));
    }
    // Cut by the horizon: the cone's other axes, from its polar form u u^T + v v^T - c c^T across the first axis.
    const glm::dvec3 z = along / std::sqrt(along2);
    glm::dvec3 e1;
    glm::dvec3 e2;
    make_frame(z, e1, e2);
    const auto form = [&](const glm::dvec3& p, const glm::dvec3& q) {
        return glm::dot(u, p) * glm::dot(u, q) + glm::dot(v, p) * glm::dot(v, q) -
               glm::dot(towards_centre, p) * glm::dot(towards_centre, q);
    };
    const double d11 = form(e1, e1);
    const double d12 = form(e1, e2);
    const double d22 = form(e2, e2);
    const double turn = 0.5 * std::atan2(2.0 * d12, d11 - d22);
    const glm::dvec3 x_axis = std::cos(turn) * e1 + std::sin(turn) * e2;
    const glm::dvec3 y_axis = std::cos(turn) * e2 - std::sin(turn) * e1;
    const double largest = 0.5 * (d11 + d22 + std::hypot(d11 - d22, 2.0 * d12));
    if (!(largest > 0.0)) {
        return 0.0;
    }
    const double wide = std::sqrt(largest / m);
    const double narrow = a * b * h / (m * std::sqrt(largest));  // by the determinant: no difference of large numbers
    const glm::dvec3 n{glm::dot(normal, x_axis), glm::dot(normal, y_axis), glm::dot(normal, z)};
    const double edge = std::hypot(wide * n.x, narrow * n.y);
    if (n.z >= edge) {
        return whole * glm::dot(normal, along);
    }
    return n.z <= -edge ? 0.0 : cut_cone_irradiance(wide, narrow, n);
}

double cone_irradiance(double sine, double cosine, const glm::dvec3& axis, const glm::dvec3& normal) {
    const double up = glm::dot(axis, normal);
    if (up >= sine) {
        return kPi * sine * sine * up;
    }
    if (up <= -sine || sine <= 0.0) {
        return 0.0;
    }
    const double tangent = sine / std::max(cosine, 1e-18);
    const double across = glm::length(glm::cross(axis, normal));
    if (std::abs(up) >= tangent * across) {
        return up > 0.0 ? kPi * sine * sine * up : 0.0;
    }
    return cut_cone_irradiance(tangent, tangent, {across, 0.0, up});
}

double line_irradiance(const glm::dvec3& towards_centre, const glm::dvec3& half, const glm::dvec3& normal,
                       const glm::dvec3* facing) {
    // Above the horizon: t in [low, high] of centre + t half.
    const double middle = glm::dot(normal, towards_centre);
    const double slope = glm::dot(normal, half);
    double low = -1.0;
    double high = 1.0;
    if (middle < std::abs(slope)) {
        if (middle <= -std::abs(slope)) {
            return 0.0;
        }
        (slope > 0.0 ? low : high) = -middle / slope;
    }
    const double half_length = glm::length(half);
    if (!(half_length > 0.0)) {
        return 0.0;
    }
    const glm::dvec3 along = half / half_length;
    const double foot = glm::dot(along, towards_centre);
    const glm::dvec3 perpendicular = towards_centre - foot * along;
    const double h2 = glm::dot(perpendicular, perpendicular);
    const double l0 = foot + low * half_length;
    const double l1 = foot + high * half_length;
    const double r0 = h2 + l0 * l0;
    const double r1 = h2 + l1 * l1;
    if (!(h2 > 1e-24 * glm::dot(towards_centre, towards_centre))) {
        return 0.0;  // on the line, or looking along it
    }
    const double h = std::sqrt(h2);
    const double length = (high - low) * half_length;
    // Integral of h (n . r) / |r|^4 along the line, by the angle from the foot of the perpendicular.
    const double angle = std::atan2(h * length, h2 + l0 * l1);
    const double per_r2 = length / (r0 * r1);
    const double across = glm::dot(normal, perpendicular) / h;
    const double sum =
        0.5 * (across * (angle / h + per_r2 * (h2 - l0 * l1)) + glm::dot(normal, along) * per_r2 * h * (l0 + l1));
    const double shine = facing == nullptr ? 1.0 : -glm::dot(*facing, perpendicular) / h;
    return std::max(0.0, sum) * std::max(0.0, shine);
}

double irradiance_per_radiance(const Light& light, const glm::dvec3& p_ws, const glm::dvec3& n_ws) {
    const LightForm form = form_of(light);
    const glm::dvec3 to = light.position_ws - p_ws;
    const double distance2 = glm::dot(to, to);
    const bool area = form == LightForm::FacingPoint || form == LightForm::FacingLine || form == LightForm::Ellipse ||
                      form == LightForm::Polygon;
    if (area && !(glm::dot(light.direction_ws, to) < 0.0)) {
        return 0.0;  // behind the light or in its plane
    }
    switch (form) {
        case LightForm::None:
            return 0.0;
        case LightForm::Point:
        case LightForm::FacingPoint: {
            if (!(distance2 > 0.0)) {
                return 0.0;
            }
            const double distance = std::sqrt(distance2);
            const double shine = form == LightForm::Point ? 1.0 : -glm::dot(light.direction_ws, to) / distance;
            return std::max(0.0, glm::dot(n_ws, to) / distance) * shine / distance2;
        }
        case LightForm::Sphere: {
            const double distance = std::sqrt(distance2);
            const double radius = light.radius_m;
            if (distance <= radius) {
                return kPi;
            }
            const double cosine = std::sqrt((distance - radius) * (distance + radius)) / distance;
            return cone_irradiance(radius / distance, cosine, to / distance, n_ws);
        }
        case LightForm::Direction:
            return std::max(0.0, -glm::dot(n_ws, light.direction_ws));
        case LightForm::Sun:
            return cone_irradiance(std::sin(0.5 * light.sun_angle_rad), std::cos(0.5 * light.sun_angle_rad),
                                   -light.direction_ws, n_ws);
        case LightForm::Line:
            return line_irradiance(to, light.half_u_ws, n_ws);
        case LightForm::FacingLine:
            return line_irradiance(to, longest_half_axis(light), n_ws, &light.direction_ws);
        case LightForm::Ellipse:
            return ellipse_irradiance(to, light.half_u_ws, light.half_v_ws, n_ws);
        case LightForm::Polygon:
            if (light.kind == LightKind::Rectangle) {
                const glm::dvec3& u = light.half_u_ws;
                const glm::dvec3& v = light.half_v_ws;
                return polygon_irradiance(to, std::array{-u - v, u - v, u + v, v - u}, n_ws);
            }
            std::array<glm::dvec3, 8> offsets{};
            const std::size_t count = std::min(light.corners_ws.size(), offsets.size());
            for (std::size_t i = 0; i < count; ++i) {
                offsets[i] = light.corners_ws[i] - light.position_ws;
            }
            return polygon_irradiance(to, {offsets.data(), count}, n_ws);
    }
    return 0.0;
}

}  // namespace penumbra
