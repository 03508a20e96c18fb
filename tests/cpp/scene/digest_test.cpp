#include "scene/digest.h"

#include <functional>
#include <set>

#include "scenes.h"

namespace penumbra {
namespace {

using test::instance_of;
using test::square_mesh;
using test::square_scene;

Mesh rich_mesh() {
    Mesh mesh = square_mesh();
    mesh.corner_normals_local.assign(6, glm::vec3{0, 0, 1});
    mesh.triangle_material = {0, 1};
    return mesh;
}

Scene rich_scene() {
    Scene scene = square_scene();
    scene.instances[0] = instance_of(rich_mesh());
    scene.lights[0].kind = LightKind::Polygon;
    scene.lights[0].corners_ws = {{0, 0, 1}, {1, 0, 1}, {0, 1, 1}};
    return scene;
}

TEST(Digest, IsTheKnownXxh3OfNoBytes) {
    EXPECT_EQ(Digest{}.hex(), "99aa06d3014798d86001c324468d497f");
}

TEST(Digest, TellsWhereOneTextEndsAndTheNextBegins) {
    Digest a;
    a.add("ab");
    a.add("c");
    Digest b;
    b.add("a");
    b.add("bc");
    EXPECT_NE(a.hex(), b.hex());
}

TEST(SceneDigest, IsTheSameInEveryProcess) {
    EXPECT_EQ(scene_digest(rich_scene()), "ad67e0356ea4b5896f4cf2a8aed1c738");
}

TEST(SceneDigest, DoesNotDependOnNamesOrOnSharing) {
    Scene scene = rich_scene();
    scene.instances.push_back(scene.instances[0]);
    const std::string before = scene_digest(scene);
    scene.instances[1] = instance_of(rich_mesh(), "a copy");
    scene.lights[0].name = "other";
    scene.camera.name = "other";
    EXPECT_EQ(scene_digest(scene), before);
}

TEST(SceneDigest, ChangesWithEveryMemberThatInfluencesImages) {
    const auto edit_mesh = [](Scene& scene, const std::function<void(Mesh&)>& edit) {
        Mesh mesh = rich_mesh();
        edit(mesh);
        scene.instances[0].mesh = std::make_shared<const Mesh>(mesh);
    };
    const std::vector<std::function<void(Scene&)>> edits{
        [](Scene&) {},
        [&](Scene& s) { edit_mesh(s, [](Mesh& m) { m.positions_local[3].z = 1e-7F; }); },
        [&](Scene& s) { edit_mesh(s, [](Mesh& m) { std::swap(m.triangles[0], m.triangles[1]); }); },
        [&](Scene& s) { edit_mesh(s, [](Mesh& m) { m.corner_normals_local[5].x = 0.1F; }); },
        [&](Scene& s) { edit_mesh(s, [](Mesh& m) { m.corner_normals_local.clear(); }); },
        [&](Scene& s) { edit_mesh(s, [](Mesh& m) { m.triangle_material[1] = 2; }); },
        [](Scene& s) { s.instances.push_back(s.instances[0]); },
        [](Scene& s) { s.instances[0].world_from_local[3].x = 1e-9; },
        [](Scene& s) { s.instances[0].albedo.push_back(s.instances[0].albedo[0]); },
        [](Scene& s) { s.instances[0].casts = false; },
        [](Scene& s) { s.instances[0].receives = false; },
        [](Scene& s) { s.instances[0].visible = false; },
        [](Scene& s) { s.lights.clear(); },
        [](Scene& s) { s.lights[0].kind = LightKind::Sun; },
        [](Scene& s) { s.lights[0].position_ws.x = 1; },
        [](Scene& s) { s.lights[0].direction_ws.x = 1; },
        [](Scene& s) { s.lights[0].half_u_ws.x = 1; },
        [](Scene& s) { s.lights[0].half_v_ws.x = 1; },
        [](Scene& s) { s.lights[0].corners_ws.pop_back(); },
        [](Scene& s) { s.lights[0].radius_m = 1; },
        [](Scene& s) { s.lights[0].sun_angle_rad = 1; },
        [](Scene& s) { s.lights[0].spot_angle_rad = 1; },
        [](Scene& s) { s.lights[0].spot_blend = 1; },
        [](Scene& s) { s.lights[0].spot_stretch.x = 2; },
        [](Scene& s) { s.lights[0].power_w.x = 1; },
        [](Scene& s) { s.lights[0].casts_shadow = false; },
        [](Scene& s) { s.camera.world_from_camera[3].z = 1; },
        [](Scene& s) { s.camera.orthographic = true; },
        [](Scene& s) { s.camera.tan_half_width = 1; },
        [](Scene& s) { s.camera.half_width_m = 1; },
        [](Scene& s) { s.camera.shift.x = 1; },
        [](Scene& s) { s.camera.pixel_aspect = 2; },
        [](Scene& s) { s.camera.near_m = 1; },
        [](Scene& s) { s.camera.far_m = 1; },
        [](Scene& s) { s.camera.width_px = 1; },
        [](Scene& s) { s.camera.height_px = 1; },
        [](Scene& s) { s.camera.pixel_offset.x = 0.25; },
    };
    std::set<std::string> digests;
    for (const auto& edit : edits) {
        Scene scene = rich_scene();
        edit(scene);
        digests.insert(scene_digest(scene));
    }
    EXPECT_EQ(digests.size(), edits.size());
}

}  // namespace
}  // namespace penumbra
