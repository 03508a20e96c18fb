#include "techniques/plateaus/plane_block.h"

#include <algorithm>
#include <cmath>

#include "geometry/cone_base.h"
#include "geometry/light_shape.h"

namespace penumbra {

namespace {

constexpr double kLowestCosine = 0.01;  ///< of the zenith angle: lower lights are left to the depth map

double half_angle(const Light& sun) {
    return 0.5 * std::min(sun.sun_angle_rad, 3.1);
}

/// Any two unit vectors that make a right-handed frame with `w`.
void frame_around(const glm::dvec3& w, glm::dvec3& u, glm::dvec3& v) {
    const glm::dvec3 helper = std::abs(w.z) < 0.9 ? glm::dvec3{0, 0, 1} : glm::dvec3{0, 1, 0};
    u = glm::normalize(glm::cross(helper, w));
    v = glm::cross(w, u);
}

glm::dvec3 turned(const PlanarReceiver& plane, const glm::dvec3& v_ws) {
    return {glm::dot(v_ws, plane.axis_x), glm::dot(v_ws, plane.axis_y), glm::dot(v_ws, plane.normal)};
}

/// The light's plane and shape in plane coordinates.
struct Shape {
    glm::dvec3 u{1, 0, 0}, v{0, 1, 0};
    plateau::RoundedBox box;
    std::vector<glm::dvec2> corners;
    double ball_m = 0.0;
};

Shape shape_of(const PlanarReceiver& plane, const Light& light, const PlateauOptions& options) {
    Shape shape;
    const plateau::PlaneLight at = light_on(plane, light);
    const double disc = disc_radius(light);
    shape.u = {disc, 0, 0};
    shape.v = {0, disc, 0};
    if (!options.own_shape) {
        return shape;
    }
    switch (light.kind) {
        case LightKind::Point:
        case LightKind::Spot:
            shape.ball_m = light.radius_m;
            break;
        case LightKind::Sun:
            frame_around(glm::dvec3{at}, shape.u, shape.v);
            shape.u *= disc;
            shape.v *= disc;
            break;
        case LightKind::Rectangle:
            shape.u = turned(plane, light.half_u_ws);
            shape.v = turned(plane, light.half_v_ws);
            shape.box = {glm::dvec2{1.0 - options.corner_radius}, options.corner_radius};
            break;
        case LightKind::Ellipse:
            shape.u = turned(plane, light.half_u_ws);
            shape.v = turned(plane, light.half_v_ws);
            break;
        case LightKind::Line:
            shape.u = turned(plane, light.half_u_ws);
            shape.box = {{1.0, 0.0}, options.lozenge_radius};
            break;
        case LightKind::Polygon: {
            frame_around(turned(plane, light.direction_ws), shape.u, shape.v);
            double reach = 0.0;
            for (const glm::dvec3& c : light.corners_ws) {
                reach = std::max(reach, glm::length(c - light.position_ws));
            }
            double area = 0.0;
            for (const glm::dvec3& c : light.corners_ws) {
                const glm::dvec3 offset = turned(plane, c - light.position_ws);
                shape.corners.emplace_back(glm::dot(offset, shape.u) / reach, glm::dot(offset, shape.v) / reach);
            }
            for (std::size_t i = 0; i < shape.corners.size(); ++i) {
                const glm::dvec2& a = shape.corners[i];
                const glm::dvec2& b = shape.corners[(i + 1) % shape.corners.size()];
                area += a.x * b.y - a.y * b.x;
            }
            if (area < 0.0) {
                std::ranges::reverse(shape.corners);
            }
            shape.u *= reach;
            shape.v *= reach;
            break;
        }
    }
    // A light without width gets its second axis where receivers see it: across the line of sight.
    if (light.kind != LightKind::Polygon && light.kind != LightKind::Sun && shape.ball_m == 0.0) {
        const double u = glm::length(shape.u);
        const double v = glm::length(shape.v);
        if (u < 1e-6 * v) {
            std::swap(shape.u, shape.v);
            std::swap(shape.box.core.x, shape.box.core.y);
        }
        if (std::min(u, v) < 1e-6 * std::max(u, v)) {
            shape.box = {{1.0, 0.0}, options.lozenge_radius};
            const glm::dvec3 across = glm::cross(glm::dvec3{at}, shape.u);
            shape.v = glm::length(across) > 0.0 ? glm::normalize(across) : glm::dvec3{0, 1, 0};
            shape.v *= glm::length(shape.u);
        }
    }
    // Right-handed as the light sees the plane, so that the outer side of an edge is on the right in both.
    if (glm::cross(shape.u, shape.v).z < 0.0) {
        shape.v = -shape.v;
        for (glm::dvec2& c : shape.corners) {
            c.y = -c.y;
        }
        std::ranges::reverse(shape.corners);
    }
    return shape;
}

bool flat(const glm::dvec3& u, const glm::dvec3& v) {
    return std::abs(u.z) <= 1e-9 * glm::length(u) && std::abs(v.z) <= 1e-9 * glm::length(v);
}

}  // namespace

PlateauLight plateau_light(const Light& light, const PlateauOptions& options) {
    using Gauge = PlateauLight::Gauge;
    using Frame = PlateauLight::Frame;
    if (!options.own_shape) {
        return {Gauge::Disc, Frame::Parallel};
    }
    switch (light.kind) {
        case LightKind::Point:
        case LightKind::Spot:
            return {Gauge::Disc, Frame::Ball};
        case LightKind::Sun:
            return {Gauge::Disc, Frame::Tilted};
        case LightKind::Ellipse:
            return {emitting_area(light) > 0.0 ? Gauge::Disc : Gauge::RoundedBox, Frame::Tilted};
        case LightKind::Rectangle:
        case LightKind::Line:
            return {Gauge::RoundedBox, Frame::Tilted};
        case LightKind::Polygon:
            return {emitting_area(light) > 0.0 ? Gauge::Polygon : Gauge::Disc,
                    emitting_area(light) > 0.0 ? Frame::Tilted : Frame::Parallel};
    }
    return {};
}

plateau::PlaneLight light_on(const PlanarReceiver& plane, const Light& light) {
    if (light.kind == LightKind::Sun) {
        return {turned(plane, -light.direction_ws), 0.0};
    }
    return {turned(plane, light.position_ws - plane.origin_ws), 1.0};
}

bool light_serves(const PlanarReceiver& plane, const Light& light) {
    const plateau::PlaneLight at = light_on(plane, light);
    const double cosine = at.z / glm::length(glm::dvec3{at});
    if (!(cosine > kLowestCosine)) {
        return false;
    }
    switch (light.kind) {
        case LightKind::Point:
        case LightKind::Spot:
            return at.z > 1.05 * light.radius_m;
        case LightKind::Sun:
            return cosine > 1.05 * std::sin(half_angle(light));
        default:
            return true;
    }
}

gpu::PlateauPlane make_plateau_plane(const PlanarReceiver& plane, const Light& light, const PlateauOptions& options,
                                     const glm::dvec3& origin_ws, const glm::dvec2& heights) {
    gpu::PlateauPlane block{};
    const glm::dvec3 from_plane = origin_ws - plane.origin_ws;
    const auto row = [&](const glm::dvec3& axis) {
        return glm::vec4{glm::vec3{axis}, static_cast<float>(glm::dot(axis, from_plane))};
    };
    block.x_from_rel = row(plane.axis_x);
    block.y_from_rel = row(plane.axis_y);
    block.h_from_rel = row(plane.normal);
    const plateau::PlaneLight at = light_on(plane, light);
    block.light = glm::vec4{at};

    Shape shape = shape_of(plane, light, options);
    const double disc = disc_radius(light);
    double linear = 0.0;
    if (options.linear_radius) {
        // sigma = linear h; from the light: the circle that matches at small heights, k = R / H.
        linear = options.k > 0.0 && disc > 0.0 ? options.k / disc : 1.0 / at.z;
        linear = light.kind == LightKind::Sun && options.k <= 0.0 ? 1.0 : linear;
    }
    shape.u *= options.match;
    shape.v *= options.match;
    shape.ball_m *= options.match;
    const glm::dvec3 normal = glm::cross(shape.u, shape.v);
    const double area2 = glm::dot(normal, normal);
    const glm::dvec3 dual_u = area2 > 0.0 ? glm::cross(shape.v, normal) / area2 : glm::dvec3{0.0};
    const glm::dvec3 dual_v = area2 > 0.0 ? glm::cross(normal, shape.u) / area2 : glm::dvec3{0.0};
    block.half_u = glm::vec4{glm::vec3{shape.u}, static_cast<float>(shape.box.core.x)};
    block.half_v = glm::vec4{glm::vec3{shape.v}, static_cast<float>(shape.box.core.y)};
    block.dual_u = glm::vec4{glm::vec3{dual_u}, static_cast<float>(shape.box.radius)};
    block.dual_v = glm::vec4{glm::vec3{dual_v}, static_cast<float>(shape.ball_m)};
    block.normal = glm::vec4{area2 > 0.0 ? glm::vec3{normal / std::sqrt(area2)} : glm::vec3{0, 0, 1}, 0.0F};
    if (flat(shape.u, shape.v)) {
        block.normal = {0.0F, 0.0F, 1.0F, 0.0F};
    }
    block.heights = {static_cast<float>(heights.x), static_cast<float>(heights.y), static_cast<float>(linear), 0.0F};
    block.size.z = static_cast<int>(shape.corners.size());
    for (std::size_t i = 0; i < shape.corners.size() && i < PENUMBRA_MAX_PLATEAU_CORNERS; ++i) {
        block.corner[i] = glm::vec4{glm::vec2{shape.corners[i]}, 0.0F, 0.0F};
    }
    return block;
}

}  // namespace penumbra
