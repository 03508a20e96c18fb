#include "geometry/plateau.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

namespace penumbra::plateau {

namespace {

constexpr double kPi = std::numbers::pi;
constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr int kMostCells = 32;

double cross(const glm::dvec2& a, const glm::dvec2& b) noexcept {
    return a.x * b.y - a.y * b.x;
}

/// Right of the direction e as the light sees the plane.
glm::dvec2 right_of(const glm::dvec2& e) noexcept {
    return {e.y, -e.x};
}

/// Support point of a shape in a direction.
glm::dvec2 support(const RoundedBox& shape, const glm::dvec2& n) noexcept {
    const double length = glm::length(n);
    return shape.core * glm::sign(n) + (length > 0.0 ? shape.radius / length * n : glm::dvec2{0.0});
}
glm::dvec2 support(std::span<const glm::dvec2> corners, const glm::dvec2& n) noexcept {
    return *std::ranges::max_element(
        corners, [&](const glm::dvec2& a, const glm::dvec2& b) { return glm::dot(a, n) < glm::dot(b, n); });
}

/// The growing shape touches the line through a and b in its support point against the line's normal; if that lies
/// between the ends, it is the answer, else the nearer end is.
template <class Shape>
double segment_gauge(const Shape& shape, glm::dvec3 a, glm::dvec3 b) noexcept {
    const double top = std::max(a.z, b.z);
    if (!(top > 0.0)) {
        return kInfinity;
    }
    const double behind = 1e-9 * top;
    if (a.z < behind) {
        a = glm::mix(a, b, (behind - a.z) / (b.z - a.z));
    }
    if (b.z < behind) {
        b = glm::mix(a, b, (a.z - behind) / (a.z - b.z));
    }
    double least = kInfinity;
    if (a.z > 0.0) {
        least = std::min(least, gauge(shape, glm::dvec2{a} / a.z));
    }
    if (b.z > 0.0) {
        least = std::min(least, gauge(shape, glm::dvec2{b} / b.z));
    }
    const glm::dvec3 line = glm::cross(a, b);
    const glm::dvec2 n = (line.z > 0.0 ? -1.0 : 1.0) * glm::dvec2{line};
    if (!(glm::dot(n, n) > 0.0)) {
        return least;
    }
    const glm::dvec2 corner = support(shape, n);
    const double reach = glm::dot(corner, n);
    if (!(reach > 0.0)) {
        return least;
    }
    const double lambda = std::abs(line.z) / reach;
    // Homogeneous parameter of the touching point: T x (a + t (b - a)) = 0 in each coordinate; the larger one decides.
    const glm::dvec3 touch{lambda * corner, 1.0};
    const glm::dvec3 from = glm::cross(touch, a);
    const glm::dvec3 to = glm::cross(touch, b);
    return glm::dot(from, to) <= 0.0 ? std::min(least, lambda) : least;
}

}  // namespace

glm::dvec2 project(const glm::dvec3& vertex, const PlaneLight& light) noexcept {
    const glm::dvec2 v{vertex};
    return v + (light.w * v - glm::dvec2{light}) * (vertex.z / (light.z - light.w * vertex.z));
}

double image_scale(double height_m, const PlaneLight& light) noexcept {
    return height_m / (light.z - light.w * height_m);
}

double disc_cut(double xi) noexcept {
    const double x = std::clamp(xi, -1.0, 1.0);
    return 0.5 + (x * std::sqrt(1.0 - x * x) + std::asin(x)) / kPi;
}

double square_cut(double xi, const glm::dvec2& normal) noexcept {
    const glm::dvec2 n = glm::abs(normal) / (std::abs(normal.x) + std::abs(normal.y));
    // Convolution of two boxes of half widths n.x and n.y; its integral up to x, from the symmetric side.
    const double low = std::min(n.x, n.y);
    const double high = std::max(n.x, n.y);
    const double x = std::clamp(xi, -1.0, 1.0);
    const double rest = 1.0 - std::abs(x);
    const double outside = rest < 2.0 * low ? rest * rest / (8.0 * low * high) : (rest - low) / (2.0 * high);
    return x < 0.0 ? outside : 1.0 - outside;
}

double polygon_cut(double xi, const glm::dvec2& normal, std::span<const glm::dvec2> corners) noexcept {
    double reach = 0.0;
    for (const glm::dvec2& c : corners) {
        reach = std::max(reach, glm::dot(c, normal));
    }
    double kept = 0.0;
    double whole = 0.0;
    for (std::size_t i = 0; i < corners.size(); ++i) {
        glm::dvec2 a = corners[i];
        glm::dvec2 b = corners[(i + 1) % corners.size()];
        whole += cross(a, b);
        const double da = glm::dot(a, normal) - xi * reach;
        const double db = glm::dot(b, normal) - xi * reach;
        // Relative to a point of the cut, so that the cut itself adds nothing.
        const glm::dvec2 on = normal * (xi * reach / glm::dot(normal, normal));
        if (da > 0.0 && db > 0.0) {
            continue;
        }
        if (da > 0.0) {
            a += (b - a) * (da / (da - db));
        } else if (db > 0.0) {
            b = a + (b - a) * (da / (da - db));
        }
        kept += cross(a - on, b - on);
    }
    return std::clamp(kept / whole, 0.0, 1.0);
}

double falloff(Falloff kind, double lambda) noexcept {
    const double t = std::clamp(lambda, 0.0, 1.0);
    switch (kind) {
        case Falloff::Linear:
            return t;
        case Falloff::Sine:
            return 0.5 * (1.0 - std::cos(kPi * t));
        case Falloff::Smoothstep:
            return t * t * (3.0 - 2.0 * t);
        case Falloff::Disc:
            return lambda > 0.0 ? disc_cut(t) : 0.0;
        case Falloff::DiscFull:
            return disc_cut(2.0 * t - 1.0);
    }
    return t;
}

std::optional<Tangent> outer_tangent(const Circles& circles) noexcept {
    const glm::dvec2 d = circles.s1 - circles.s0;
    const double d2 = glm::dot(d, d);
    const double dr = circles.r0 - circles.r1;
    if (d2 <= dr * dr * (1.0 + 1e-6)) {
        return std::nullopt;
    }
    const double length = std::sqrt(d2);
    const glm::dvec2 e = d / length;
    const double g = dr / length;
    const double a = std::sqrt(std::max(0.0, (length - dr) * (length + dr))) / length;
    const glm::dvec2 n = g * e + a * right_of(e);
    return Tangent{circles.s0 + circles.r0 * n, circles.s1 + circles.r1 * n, n};
}

double envelope(const glm::dvec2& p, const Circles& circles) noexcept {
    // Least |s + t d| / (r + t e) over t in [0, 1]: the derivative is linear in t, and nothing is divided by a radius.
    const glm::dvec2 s = circles.s0 - p;
    const glm::dvec2 d = circles.s1 - circles.s0;
    const double r = circles.r0;
    const double e = circles.r1 - circles.r0;
    const double numerator = e * glm::dot(s, s) - r * glm::dot(s, d);
    const double denominator = r * glm::dot(d, d) - e * glm::dot(s, d);
    // A maximum or none: the larger circle holds the smaller one.
    const double t = denominator > 0.0 ? std::clamp(numerator / denominator, 0.0, 1.0) : (e > 0.0 ? 1.0 : 0.0);
    const double distance = glm::length(s + t * d);
    const double radius = r + t * e;
    return radius > 0.0 ? distance / radius : (distance > 0.0 ? kInfinity : 0.0);
}

double bilinear(const glm::dvec2& p, const Circles& circles) noexcept {
    const glm::dvec2 d = circles.s1 - circles.s0;
    const double length = glm::length(d);
    const double dr = circles.r0 - circles.r1;
    if (length * length <= dr * dr * (1.0 + 1e-6)) {
        return kInfinity;
    }
    const glm::dvec2 e = d / length;
    const double g = dr / length;
    const double a = std::sqrt(std::max(0.0, (length - dr) * (length + dr))) / length;
    const double x = glm::dot(p - circles.s0, e);
    const double y = glm::dot(p - circles.s0, right_of(e));
    const double bottom = (circles.r0 - g * x) * a + g * g * y;
    if (!(y >= 0.0 && bottom > 0.0)) {
        return kInfinity;
    }
    const double lambda = y / bottom;
    const double u = (x - lambda * g * circles.r0) / (1.0 - lambda * g * g) / length;
    return u >= 0.0 && u <= 1.0 && lambda <= 1.0 ? lambda : kInfinity;
}

double cell_error(double r0, double r1, int n) noexcept {
    const double low = std::min(r0, r1);
    const double step = (std::max(r0, r1) - low) / n;
    const double a = std::sqrt(low);
    const double b = std::sqrt(low + step);
    return b > 0.0 ? (b - a) / (a + b) / n : 0.0;
}

int cells_needed(double r0, double r1) noexcept {
    int n = 1;
    while (n < kMostCells && cell_error(r0, r1, n) >= 1.0 / 255.0) {
        ++n;
    }
    return n;
}

double envelope_gap(double g) noexcept {
    const double g2 = g * g;
    if (g2 >= 1.0) {
        return 1.0;
    }
    const auto gap = [&](double tau) {
        return tau / (std::sqrt(1.0 - g2) + g2 * tau) - tau / std::sqrt(1.0 + g2 * tau * tau);
    };
    // tau = y / R runs to where the sheet ends, 1 / a; a y / R is what the patch divides by, so the first term has it.
    const double end = 1.0 / std::sqrt(1.0 - g2);
    double largest = 0.0;
    for (int i = 0; i <= 4096; ++i) {
        largest = std::max(largest, gap(end * i / 4096.0));
    }
    return largest;
}

double gauge(const RoundedBox& shape, const glm::dvec2& x) noexcept {
    const glm::dvec2 q = glm::abs(x);
    const glm::dvec2 reach = shape.core + glm::dvec2{shape.radius};
    const double side_x = reach.x > 0.0 ? q.x / reach.x : (q.x > 0.0 ? kInfinity : 0.0);
    const double side_y = reach.y > 0.0 ? q.y / reach.y : (q.y > 0.0 ? kInfinity : 0.0);
    if (q.y <= side_x * shape.core.y) {
        return side_x;
    }
    if (q.x <= side_y * shape.core.x) {
        return side_y;
    }
    // On the rounded corner: |q - lambda core| = lambda radius.
    const double q2 = glm::dot(q, q);
    const double along = glm::dot(q, shape.core);
    const double quadratic = glm::dot(shape.core, shape.core) - shape.radius * shape.radius;
    const double root = along + std::sqrt(std::max(0.0, along * along - quadratic * q2));
    return root > 0.0 ? q2 / root : kInfinity;
}

double gauge(std::span<const glm::dvec2> corners, const glm::dvec2& x) noexcept {
    double largest = 0.0;
    for (std::size_t i = 0; i < corners.size(); ++i) {
        const glm::dvec2 n = right_of(corners[(i + 1) % corners.size()] - corners[i]);
        largest = std::max(largest, glm::dot(n, x) / glm::dot(n, corners[i]));
    }
    return largest;
}

double gauge(const RoundedBox& shape, const glm::dvec3& a, const glm::dvec3& b) noexcept {
    return segment_gauge(shape, a, b);
}
double gauge(std::span<const glm::dvec2> corners, const glm::dvec3& a, const glm::dvec3& b) noexcept {
    return segment_gauge(corners, a, b);
}

std::optional<Ellipse> ball_image(double height_m, double zenith_rad, double alpha_rad) noexcept {
    const double cosine = std::cos(zenith_rad);
    const double sine = std::sin(alpha_rad);
    const double q = cosine * cosine - sine * sine;
    if (!(q > 0.0 && cosine > 0.0)) {
        return std::nullopt;
    }
    return Ellipse{height_m * sine * std::cos(alpha_rad) / q, height_m * sine / std::sqrt(q),
                   height_m * std::tan(zenith_rad) * sine * sine / q};
}

std::optional<Tangent> outer_tangent(const glm::dvec2& c0, const glm::dmat2& q0, const glm::dvec2& c1,
                                     const glm::dmat2& q1) noexcept {
    const glm::dvec2 d = c1 - c0;
    const double length = glm::length(d);
    if (!(length > 0.0)) {
        return std::nullopt;
    }
    const glm::dvec2 e = d / length;
    const auto normal_at = [&](double phi) { return std::cos(phi) * e + std::sin(phi) * right_of(e); };
    const auto reach = [](const glm::dmat2& q, const glm::dvec2& n) {
        return std::sqrt(std::max(0.0, glm::dot(n, q * n)));
    };
    const auto value = [&](double phi) {
        const glm::dvec2 n = normal_at(phi);
        return glm::dot(n, d) + reach(q1, n) - reach(q0, n);
    };
    double low = 0.0;
    double high = kPi;
    if (!(value(low) > 0.0 && value(high) < 0.0)) {
        return std::nullopt;
    }
    for (int i = 0; i < 100; ++i) {
        const double middle = 0.5 * (low + high);
        (value(middle) > 0.0 ? low : high) = middle;
    }
    const glm::dvec2 n = normal_at(0.5 * (low + high));
    const auto touch = [&](const glm::dvec2& c, const glm::dmat2& q) {
        const double r = reach(q, n);
        return r > 0.0 ? c + q * n / r : c;
    };
    return Tangent{touch(c0, q0), touch(c1, q1), n};
}

Sector visible_sector(double sector_rad, double g_a, double g_b, double r, double d_a, double d_b) noexcept {
    const auto from_edge = [](double g) { return std::abs(g) < 1.0 ? std::acos(std::abs(g)) : 0.0; };
    const Sector sector{from_edge(g_a), sector_rad - from_edge(g_b)};
    // An empty sector proves that the cone is hidden only where the neighbours are lower and far enough.
    const bool proved = g_a >= 0.0 && g_b >= 0.0 && d_a >= r && d_b >= r;
    return sector.empty() && !proved ? Sector{0.0, sector_rad} : sector;
}

glm::dvec2 patch(const Circles& circles, const Tangent& tangent, double u, double v) noexcept {
    return (1.0 - v) * ((1.0 - u) * circles.s0 + u * circles.s1) + v * ((1.0 - u) * tangent.t0 + u * tangent.t1);
}

double lens(double s, double a, double b) noexcept {
    if (s >= a + b) {
        return 0.0;
    }
    const double small = std::min(a, b);
    if (s <= std::abs(a - b)) {
        return kPi * small * small;
    }
    const auto angle = [](double c) { return std::acos(std::clamp(c, -1.0, 1.0)); };
    const double root = (a + b - s) * (s + a - b) * (s - a + b) * (s + a + b);
    return a * a * angle((s * s + a * a - b * b) / (2.0 * s * a)) +
           b * b * angle((s * s + b * b - a * a) / (2.0 * s * b)) - 0.5 * std::sqrt(std::max(0.0, root));
}

}  // namespace penumbra::plateau
