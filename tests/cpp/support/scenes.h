#pragma once

#include <cmath>
#include <glm/glm.hpp>
#include <memory>
#include <string>
#include <vector>

#include "penumbra/scene.h"

/// Small scenes with known answers, for tests of every folder.
namespace penumbra::scenes {

inline constexpr double kPi = 3.14159265358979323846;

inline std::shared_ptr<Mesh> mesh(std::string name, std::vector<glm::vec3> positions,
                                  std::vector<glm::uvec3> triangles) {
    auto made = std::make_shared<Mesh>();
    made->name = std::move(name);
    made->positions_local = std::move(positions);
    made->triangles = std::move(triangles);
    return made;
}

/// Rectangle [x0, x1] x [y0, y1] in the plane z = 0, facing +z.
inline std::shared_ptr<Mesh> sheet(double x0, double x1, double y0, double y1) {
    return mesh("sheet", {{x0, y0, 0}, {x1, y0, 0}, {x1, y1, 0}, {x0, y1, 0}}, {{0, 1, 2}, {0, 2, 3}});
}

/// Axis-aligned box, normals outwards.
inline std::shared_ptr<Mesh> box(const glm::vec3& low, const glm::vec3& high) {
    std::vector<glm::vec3> p;
    for (unsigned i = 0; i < 8; ++i) {
        p.emplace_back((i & 1U) != 0 ? high.x : low.x, (i & 2U) != 0 ? high.y : low.y, (i & 4U) != 0 ? high.z : low.z);
    }
    return mesh("box", std::move(p),
                {{0, 2, 1},
                 {1, 2, 3},
                 {4, 5, 6},
                 {5, 7, 6},
                 {0, 1, 4},
                 {1, 5, 4},
                 {2, 6, 3},
                 {3, 6, 7},
                 {0, 4, 2},
                 {2, 4, 6},
                 {1, 3, 5},
                 {3, 7, 5}});
}

/// Sphere of radius 1 in latitude and longitude, normals outwards; smooth if asked.
inline std::shared_ptr<Mesh> sphere(int rings, bool smooth) {
    const int segments = 2 * rings;
    auto made = std::make_shared<Mesh>();
    made->name = "sphere";
    for (int j = 0; j <= rings; ++j) {
        for (int i = 0; i < segments; ++i) {
            const double theta = kPi * j / rings, phi = 2.0 * kPi * i / segments;
            const double around = j < rings ? std::sin(theta) : 0.0;  // sin(pi) is not 0: the pole would not be welded
            made->positions_local.emplace_back(around * std::cos(phi), around * std::sin(phi), std::cos(theta));
        }
    }
    const auto at = [&](int j, int i) { return static_cast<unsigned>(j * segments + i % segments); };
    for (int j = 0; j < rings; ++j) {
        for (int i = 0; i < segments; ++i) {
            if (j > 0) {
                made->triangles.emplace_back(at(j, i), at(j + 1, i), at(j, i + 1));
            }
            if (j + 1 < rings) {
                made->triangles.emplace_back(at(j + 1, i), at(j + 1, i + 1), at(j, i + 1));
            }
        }
    }
    if (smooth) {
        for (const glm::uvec3& t : made->triangles) {
            for (int k = 0; k < 3; ++k) {
                made->corner_normals_local.push_back(made->positions_local[t[k]]);
            }
        }
    }
    return made;
}

inline Instance place(std::shared_ptr<const Mesh> what, const std::string& name, const glm::dvec3& at = {}) {
    Instance instance;
    instance.name = name;
    instance.mesh = std::move(what);
    instance.world_from_local[3] = glm::dvec4{at, 1.0};
    return instance;
}

/// Orthographic camera above the plane z = 0, looking straight down; x right, y up; sees [-half, half] across.
inline Camera camera_from_above(double half_width_m, int width_px, int height_px, double height_m = 50.0) {
    Camera camera;
    camera.name = "above";
    camera.orthographic = true;
    camera.half_width_m = half_width_m;
    camera.world_from_camera[3] = glm::dvec4{0.0, 0.0, height_m, 1.0};
    camera.width_px = width_px;
    camera.height_px = height_px;
    camera.near_m = 0.01 * height_m;
    camera.far_m = 2.0 * height_m;
    return camera;
}

inline Light rectangle_light(const glm::dvec3& centre, double size_x_m, double size_y_m) {
    Light light;
    light.name = "key";
    light.kind = LightKind::Rectangle;
    light.position_ws = centre;
    light.half_u_ws = {0.5 * size_x_m, 0.0, 0.0};
    light.half_v_ws = {0.0, -0.5 * size_y_m, 0.0};
    light.direction_ws = {0.0, 0.0, -1.0};
    return light;
}

inline Light point_light(const glm::dvec3& centre, double radius_m) {
    Light light;
    light.name = "lamp";
    light.kind = LightKind::Point;
    light.position_ws = centre;
    light.radius_m = radius_m;
    return light;
}

inline Light sun_light(const glm::dvec3& direction, double angle_rad) {
    Light light;
    light.name = "sun";
    light.kind = LightKind::Sun;
    light.direction_ws = glm::normalize(direction);
    light.sun_angle_rad = angle_rad;
    light.power_w = glm::dvec3{1.0};
    return light;
}

/// A half plane x < edge_x at `height_m` over the ground, seen from above through it: the sheet itself is not visible
/// to the camera. Light plane at z = light_z. The hard edge on the ground is at edge_x * light_z / (light_z -
/// height_m).
inline Scene straight_edge(const Light& light, double height_m, double edge_x = 0.0, int size_px = 128,
                           double view_half_m = 2.0) {
    Scene scene;
    scene.instances.push_back(place(sheet(-50, 50, -50, 50), "ground"));
    Instance blocker = place(sheet(edge_x - 20.0, edge_x, -40, 40), "blocker", {0.0, 0.0, height_m});
    blocker.visible = false;
    blocker.receives = false;
    scene.instances.push_back(blocker);
    scene.lights.push_back(light);
    scene.camera = camera_from_above(view_half_m, size_px, size_px / 8);
    return scene;
}

/// World x of pixel column `x` in a view from camera_from_above().
inline double column_x(const Camera& camera, int x) {
    return camera.half_width_m * (2.0 * (x + 0.5) / camera.width_px - 1.0);
}

/// The same scene, scaled about the origin, then turned, then moved.
inline Scene transformed(Scene scene, double scale, const glm::dmat3& turn, const glm::dvec3& move) {
    glm::dmat4 matrix{scale * turn};
    matrix[3] = glm::dvec4{move, 1.0};
    for (Instance& instance : scene.instances) {
        instance.world_from_local = matrix * instance.world_from_local;
    }
    for (Light& light : scene.lights) {
        light.position_ws = glm::dvec3{matrix * glm::dvec4{light.position_ws, 1.0}};
        light.direction_ws = turn * light.direction_ws;
        if (light.kind == LightKind::Spot) {
            light.half_u_ws = turn * light.half_u_ws;
            light.half_v_ws = turn * light.half_v_ws;
        } else {
            light.half_u_ws = scale * (turn * light.half_u_ws);
            light.half_v_ws = scale * (turn * light.half_v_ws);
        }
        for (glm::dvec3& corner : light.corners_ws) {
            corner = glm::dvec3{matrix * glm::dvec4{corner, 1.0}};
        }
        light.radius_m *= scale;
    }
    Camera& camera = scene.camera;
    const glm::dvec3 eye = glm::dvec3{matrix * camera.world_from_camera[3]};
    camera.world_from_camera = glm::dmat4{turn * glm::dmat3{camera.world_from_camera}};
    camera.world_from_camera[3] = glm::dvec4{eye, 1.0};
    camera.half_width_m *= scale;
    camera.near_m *= scale;
    camera.far_m *= scale;
    return scene;
}

inline glm::dmat3 odd_turn() {
    const double a = 0.7321, b = -1.1234, c = 2.3456;
    const glm::dmat3 x{{1, 0, 0}, {0, std::cos(a), std::sin(a)}, {0, -std::sin(a), std::cos(a)}};
    const glm::dmat3 y{{std::cos(b), 0, -std::sin(b)}, {0, 1, 0}, {std::sin(b), 0, std::cos(b)}};
    const glm::dmat3 z{{std::cos(c), std::sin(c), 0}, {-std::sin(c), std::cos(c), 0}, {0, 0, 1}};
    return x * y * z;
}

}  // namespace penumbra::scenes
