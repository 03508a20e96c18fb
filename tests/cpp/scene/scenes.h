#pragma once

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <memory>
#include <string>
#include <utility>

#include "penumbra/error.h"
#include "penumbra/scene.h"

namespace penumbra::test {

/// Two triangles: the square 0 .. 1 in the plane z = 0.
inline Mesh square_mesh() {
    Mesh mesh;
    mesh.name = "Square";
    mesh.positions_local = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}};
    mesh.triangles = {{0, 1, 2}, {0, 2, 3}};
    return mesh;
}

inline Instance instance_of(Mesh mesh, std::string name = "Floor") {
    Instance instance;
    instance.name = std::move(name);
    instance.mesh = std::make_shared<const Mesh>(std::move(mesh));
    return instance;
}

inline Scene square_scene() {
    Scene scene;
    scene.instances.push_back(instance_of(square_mesh()));
    Light lamp;
    lamp.name = "Lamp";
    lamp.position_ws = {0, 0, 3};
    scene.lights.push_back(lamp);
    scene.camera.name = "Camera";
    return scene;
}

inline Light light_of(LightKind kind) {
    Light light;
    light.name = "Lamp";
    light.kind = kind;
    return light;
}

inline Light polygon_light(std::vector<glm::dvec3> corners) {
    Light light = light_of(LightKind::Polygon);
    light.corners_ws = std::move(corners);
    return light;
}

/// Runs `action` and returns the sentence of the InvalidScene that it throws; empty if it throws nothing.
template <typename Action>
std::string refusal(Action&& action) {
    try {
        action();
    } catch (const InvalidScene& error) {
        return error.what();
    }
    return {};
}

inline void expect_near(const glm::dvec3& a, const glm::dvec3& b, double tolerance) {
    EXPECT_NEAR(a.x, b.x, tolerance);
    EXPECT_NEAR(a.y, b.y, tolerance);
    EXPECT_NEAR(a.z, b.z, tolerance);
}

}  // namespace penumbra::test
