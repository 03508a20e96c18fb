#pragma once

#include <cmath>
#include <glm/glm.hpp>
#include <glm/gtc/matrix_transform.hpp>
#include <memory>
#include <utility>
#include <vector>

#include "penumbra/scene.h"
#include "penumbra/view.h"
#include "support/scenes.h"

// Small scenes and Views made by hand: receivers are points given in float64, not what a camera happens to see.

namespace penumbra::test {

using scenes::kPi;
using scenes::point_light;

inline std::shared_ptr<Mesh> make_mesh(std::vector<glm::vec3> positions, std::vector<glm::uvec3> triangles) {
    return scenes::mesh("mesh", std::move(positions), std::move(triangles));
}

/// Parallelogram of two triangles, as four corners in order.
inline std::shared_ptr<Mesh> quad(glm::vec3 a, glm::vec3 b, glm::vec3 c, glm::vec3 d) {
    return make_mesh({a, b, c, d}, {{0, 1, 2}, {0, 2, 3}});
}

/// Square in z = 0 about the origin.
inline std::shared_ptr<Mesh> square(float half) {
    return quad({-half, -half, 0}, {half, -half, 0}, {half, half, 0}, {-half, half, 0});
}

/// Regular polygon in z = 0 about the origin.
inline std::shared_ptr<Mesh> disc(float radius, int sides) {
    std::vector<glm::vec3> positions{{0, 0, 0}};
    std::vector<glm::uvec3> triangles;
    for (int i = 0; i < sides; ++i) {
        const double angle = 2.0 * kPi * i / sides;
        positions.emplace_back(radius * std::cos(angle), radius * std::sin(angle), 0.0);
        triangles.emplace_back(0, i + 1, (i + 1) % sides + 1);
    }
    return make_mesh(std::move(positions), std::move(triangles));
}

inline std::shared_ptr<Mesh> cube(float half) {
    return scenes::box(glm::vec3{-half}, glm::vec3{half});
}

/// Latitude-longitude sphere, closed.
inline std::shared_ptr<Mesh> sphere(float radius, int rings, int segments) {
    std::vector<glm::vec3> p{{0, 0, radius}};
    for (int r = 1; r < rings; ++r) {
        const double polar = kPi * r / rings;
        for (int s = 0; s < segments; ++s) {
            const double around = 2.0 * kPi * s / segments;
            p.emplace_back(radius * std::sin(polar) * std::cos(around), radius * std::sin(polar) * std::sin(around),
                           radius * std::cos(polar));
        }
    }
    p.emplace_back(0, 0, -radius);
    std::vector<glm::uvec3> t;
    const auto at = [&](int r, int s) { return static_cast<unsigned>(1 + (r - 1) * segments + s % segments); };
    const auto last = static_cast<unsigned>(p.size() - 1);
    for (int s = 0; s < segments; ++s) {
        t.emplace_back(0, at(1, s), at(1, s + 1));
        for (int r = 1; r + 1 < rings; ++r) {
            t.emplace_back(at(r, s), at(r + 1, s), at(r + 1, s + 1));
            t.emplace_back(at(r, s), at(r + 1, s + 1), at(r, s + 1));
        }
        t.emplace_back(last, at(rings - 1, s + 1), at(rings - 1, s));
    }
    return make_mesh(std::move(p), std::move(t));
}

inline Instance place(std::shared_ptr<const Mesh> mesh, const glm::dmat4& world_from_local = glm::dmat4{1.0}) {
    Instance instance = scenes::place(std::move(mesh), "instance");
    instance.world_from_local = world_from_local;
    return instance;
}

inline glm::dmat4 moved(const glm::dvec3& by) {
    return glm::translate(glm::dmat4{1.0}, by);
}

/// Rectangle that shines down.
inline Light rectangle(const glm::dvec3& at, double half_u, double half_v) {
    return scenes::rectangle_light(at, 2.0 * half_u, 2.0 * half_v);
}

inline Light ellipse(const glm::dvec3& at, double half_u, double half_v) {
    Light light = rectangle(at, half_u, half_v);
    light.name = "ellipse";
    light.kind = LightKind::Ellipse;
    return light;
}

inline Light line(const glm::dvec3& at, const glm::dvec3& half) {
    Light light;
    light.name = "line";
    light.kind = LightKind::Line;
    light.position_ws = at;
    light.half_u_ws = half;
    return light;
}

inline Light sun(const glm::dvec3& direction, double angle) {
    return scenes::sun_light(direction, angle);
}

/// Convex polygon that shines down; corners counter-clockwise seen from below.
inline Light polygon(const std::vector<glm::dvec3>& corners) {
    Light light;
    light.name = "polygon";
    light.kind = LightKind::Polygon;
    light.corners_ws = corners;
    light.position_ws = glm::dvec3{0.0};
    for (const glm::dvec3& corner : corners) {
        light.position_ws += corner / static_cast<double>(corners.size());
    }
    light.direction_ws = {0, 0, -1};
    return light;
}

/// A View of single points with normals, all on one triangle of instance 0; one row unless a width is given.
struct Point {
    glm::dvec3 position_ws;
    glm::dvec3 normal_ws{0, 0, 1};
    int instance = 0;
    int triangle = 0;
};
inline View view_of(const std::vector<Point>& points, int width = 0) {
    View view;
    view.width = width > 0 ? width : static_cast<int>(points.size());
    view.height = static_cast<int>(points.size()) / view.width;
    for (const Point& point : points) {
        view.eye_ws += point.position_ws / static_cast<double>(points.size());
    }
    for (const Point& point : points) {
        view.position_cr.emplace_back(point.position_ws - view.eye_ws);
        view.normal_ws.emplace_back(point.normal_ws);
        view.shading_normal_ws.emplace_back(point.normal_ws);
        view.albedo.emplace_back(0.8F);
        view.instance.push_back(point.instance);
        view.triangle.push_back(point.triangle);
    }
    return view;
}

/// Regular grid of points on z = 0, x fastest, both ends included.
inline std::vector<Point> floor_points(glm::dvec2 low, glm::dvec2 high, int across, int down) {
    std::vector<Point> points;
    for (int y = 0; y < down; ++y) {
        for (int x = 0; x < across; ++x) {
            const double s = across > 1 ? static_cast<double>(x) / (across - 1) : 0.5;
            const double t = down > 1 ? static_cast<double>(y) / (down - 1) : 0.5;
            points.push_back({{low.x + (high.x - low.x) * s, low.y + (high.y - low.y) * t, 0.0}});
        }
    }
    return points;
}

/// Random points on the triangles of an instance, `per_triangle` each, normals from the winding (outwards where the
/// mesh is closed and counter-clockwise, mirrored transforms included).
inline std::vector<Point> surface_points(const Scene& scene, int instance_index, int per_triangle) {
    const Instance& instance = scene.instances[static_cast<std::size_t>(instance_index)];
    const glm::dmat4& m = instance.world_from_local;
    const double handedness = glm::determinant(glm::dmat3(m)) < 0.0 ? -1.0 : 1.0;
    std::vector<Point> points;
    std::uint64_t state = 12345;
    const auto random = [&] {
        state = state * 6364136223846793005ULL + 1442695040888963407ULL;
        return static_cast<double>(state >> 11) * 0x1p-53;
    };
    for (std::size_t t = 0; t < instance.mesh->triangles.size(); ++t) {
        const glm::uvec3 index = instance.mesh->triangles[t];
        const auto corner = [&](unsigned i) {
            return glm::dvec3(m * glm::dvec4(glm::dvec3(instance.mesh->positions_local[i]), 1.0));
        };
        const glm::dvec3 a = corner(index.x);
        const glm::dvec3 b = corner(index.y);
        const glm::dvec3 c = corner(index.z);
        const glm::dvec3 normal = glm::normalize(glm::cross(b - a, c - a)) * handedness;
        for (int i = 0; i < per_triangle; ++i) {
            double u = random();
            double v = random();
            if (u + v > 1.0) {
                u = 1.0 - u;
                v = 1.0 - v;
            }
            points.push_back({a + (b - a) * u + (c - a) * v, normal, instance_index, static_cast<int>(t)});
        }
    }
    return points;
}

/// A scene and its points, scaled, turned and moved together: `by` is a similarity.
inline void transform(const glm::dmat4& by, Scene& scene, Light& light, std::vector<Point>& points) {
    const glm::dmat3 linear{by};
    const double scale = std::cbrt(std::abs(glm::determinant(linear)));
    const auto point = [&](const glm::dvec3& p) { return glm::dvec3(by * glm::dvec4(p, 1.0)); };
    for (Instance& instance : scene.instances) {
        instance.world_from_local = by * instance.world_from_local;
    }
    light.position_ws = point(light.position_ws);
    light.direction_ws = glm::normalize(linear * light.direction_ws);
    light.half_u_ws = linear * light.half_u_ws / (light.kind == LightKind::Spot ? scale : 1.0);
    light.half_v_ws = linear * light.half_v_ws;
    for (glm::dvec3& corner : light.corners_ws) {
        corner = point(corner);
    }
    light.radius_m *= scale;
    for (Point& p : points) {
        p.position_ws = point(p.position_ws);
        p.normal_ws = glm::normalize(linear * p.normal_ws);
    }
}

}  // namespace penumbra::test
