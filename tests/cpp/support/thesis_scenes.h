#pragma once

#include <random>

#include "support/scenes.h"

/// Scenes in the spirit of those that the hybrid's thesis reports on [Chan2004]: as many triangles, the same reasons to
/// be hard, made anew from fixed seeds.
namespace penumbra::scenes {

/// Appends `part`, moved by `matrix`, to `whole`.
inline void append(Mesh& whole, const Mesh& part, const glm::dmat4& matrix) {
    const auto first = static_cast<std::uint32_t>(whole.positions_local.size());
    for (const glm::vec3& p : part.positions_local) {
        whole.positions_local.emplace_back(matrix * glm::dvec4{glm::dvec3{p}, 1.0});
    }
    for (const glm::uvec3& t : part.triangles) {
        whole.triangles.push_back(t + first);
    }
}

/// Closed frustum of `sides` sides between two points, normals outwards.
inline Mesh branch(const glm::dvec3& from, const glm::dvec3& to, double from_radius, double to_radius, unsigned sides) {
    const glm::dvec3 along = glm::normalize(to - from);
    const glm::dvec3 u =
        glm::normalize(glm::cross(along, std::abs(along.z) < 0.9 ? glm::dvec3{0, 0, 1} : glm::dvec3{1, 0, 0}));
    const glm::dvec3 v = glm::cross(along, u);
    Mesh made;
    for (unsigned i = 0; i < sides; ++i) {
        const double angle = 2.0 * kPi * i / sides;
        const glm::dvec3 out = std::cos(angle) * u + std::sin(angle) * v;
        made.positions_local.emplace_back(from + from_radius * out);
        made.positions_local.emplace_back(to + to_radius * out);
    }
    for (unsigned i = 0; i < sides; ++i) {
        const unsigned a = 2 * i, b = 2 * ((i + 1) % sides);
        made.triangles.emplace_back(a, b, b + 1);
        made.triangles.emplace_back(a, b + 1, a + 1);
        if (i > 0 && i + 1 < sides) {
            made.triangles.emplace_back(0, b, a);
            made.triangles.emplace_back(1, a + 1, b + 1);
        }
    }
    return made;
}

/// Looks from `eye` towards `at`, z up.
inline Camera camera_towards(const glm::dvec3& eye, const glm::dvec3& at, int width_px, int height_px) {
    Camera camera;
    camera.name = "towards";
    const glm::dvec3 back = glm::normalize(eye - at);
    const glm::dvec3 right = glm::normalize(glm::cross(glm::dvec3{0, 0, 1}, back));
    camera.world_from_camera = glm::dmat4{glm::dmat3{right, glm::cross(back, right), back}};
    camera.world_from_camera[3] = glm::dvec4{eye, 1.0};
    camera.tan_half_width = 0.5;
    camera.width_px = width_px;
    camera.height_px = height_px;
    return camera;
}

inline Scene on_ground(const std::shared_ptr<Mesh>& mesh, const glm::dvec3& light, const glm::dvec3& eye,
                       const glm::dvec3& at) {
    Scene scene;
    scene.instances.push_back(place(sheet(-6, 6, -6, 6), "ground"));
    scene.instances.push_back(place(mesh, mesh->name));
    scene.lights.push_back(point_light(light, 0.0));
    scene.camera = camera_towards(eye, at, 1024, 768);
    return scene;
}

/// 1000 cubes in the air, 12 000 triangles: overlapping edges.
inline Scene cubes() {
    std::mt19937 random{11};
    std::uniform_real_distribution<double> unit{0.0, 1.0};
    auto whole = std::make_shared<Mesh>();
    whole->name = "cubes";
    const auto cube = box(glm::vec3{-0.5F}, glm::vec3{0.5F});
    for (int i = 0; i < 1000; ++i) {
        const double size = 0.06 + 0.12 * unit(random);
        glm::dmat4 matrix{glm::dmat3{size}};
        const double angle = 2.0 * kPi * unit(random);
        matrix[0] = {size * std::cos(angle), size * std::sin(angle), 0, 0};
        matrix[1] = {-size * std::sin(angle), size * std::cos(angle), 0, 0};
        matrix[3] = {4.0 * unit(random) - 2.0, 4.0 * unit(random) - 2.0, 0.2 + 2.2 * unit(random), 1.0};
        append(*whole, *cube, matrix);
    }
    return on_ground(whole, {1.5, -1.0, 6.0}, {2.0, -6.5, 4.0}, {0, 0, 0.8});
}

/// A crumpled ball behind bars, about 12 000 triangles: shadows of bars upon shadows of wrinkles.
inline Scene cage() {
    auto whole = sphere(52, false);
    whole->name = "cage";
    std::mt19937 random{12};
    std::uniform_real_distribution<float> factor{0.85F, 1.15F};
    for (glm::vec3& p : whole->positions_local) {
        p = (std::abs(p.z) > 0.9999F ? 1.0F : factor(random)) * p + glm::vec3{0, 0, 1.5F};
    }
    for (int i = 0; i < 40; ++i) {
        const double angle = 2.0 * kPi * i / 40.0;
        const glm::dvec3 foot{1.7 * std::cos(angle), 1.7 * std::sin(angle), 0.0};
        append(*whole, branch(foot, foot + glm::dvec3{0, 0, 3.2}, 0.04, 0.04, 6), glm::dmat4{1.0});
    }
    for (int i = 0; i < 9; ++i) {  // and over the top
        const double x = -1.6 + 0.4 * i;
        const double y = std::sqrt(1.7 * 1.7 - x * x);
        append(*whole, branch({x, -y, 3.2}, {x, y, 3.2}, 0.04, 0.04, 6), glm::dmat4{1.0});
    }
    return on_ground(whole, {2.5, -2.0, 6.5}, {1.5, -7.0, 3.5}, {0, 0, 1.2});
}

/// Branches down to twigs of two millimetres, 40 000 triangles: what a coarse map misses.
inline Scene tree() {
    struct Twig {
        glm::dvec3 at, along;
        double length, radius;
    };
    auto whole = std::make_shared<Mesh>();
    whole->name = "tree";
    std::mt19937 random{13};
    std::uniform_real_distribution<double> unit{-1.0, 1.0};
    std::vector<Twig> open{{{0, 0, 0}, {0, 0, 1}, 1.0, 0.12}};
    constexpr unsigned kSides = 5;
    for (std::size_t next = 0; next < open.size() && whole->triangles.size() + 16 <= 40000; ++next) {
        const Twig twig = open[next];
        const glm::dvec3 end = twig.at + twig.length * twig.along;
        append(*whole, branch(twig.at, end, twig.radius, 0.65 * twig.radius, kSides), glm::dmat4{1.0});
        for (int child = 0; child < 3; ++child) {
            const glm::dvec3 off{unit(random), unit(random), 0.6 * unit(random) + 0.25};
            open.push_back({end, glm::normalize(twig.along + 0.9 * off), twig.length * (0.68 + 0.08 * unit(random)),
                            std::max(0.002, 0.62 * twig.radius)});
        }
    }
    return on_ground(whole, {3.0, -2.5, 7.0}, {1.0, -6.0, 3.0}, {0.3, 0.3, 0.9});
}

}  // namespace penumbra::scenes
