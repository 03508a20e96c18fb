"""Blender's lights in the core's words: kind, size, direction, watts."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from blender_kit import Kit, bpy

Approx = pytest.approx


def the_light(kit: Kit, **wanted: Any) -> Any:
    lights = kit.read(**wanted).scene.lights
    assert len(lights) == 1
    return lights[0]


def has_note(export: Any, *parts: str) -> bool:
    return any(all(part in note for part in parts) for note in export.notes)


def test_a_point_light_keeps_place_radius_and_watts(kit: Kit) -> None:
    kit.light("POINT", at=(1, 2, 3), energy=80, shadow_soft_size=0.3, color=(1, 0.5, 0.25))
    light = the_light(kit)
    assert (light.kind, light.radius_m) == ("point", Approx(0.3))
    np.testing.assert_allclose(light.position_ws, (1, 2, 3))
    np.testing.assert_allclose(light.power_w, (80, 40, 20), rtol=1e-6)


def test_the_objects_scale_does_not_change_a_point_lights_radius(kit: Kit) -> None:
    kit.light("POINT", shadow_soft_size=0.3, scale=(5, 2, 9))
    assert the_light(kit).radius_m == Approx(0.3)


def test_a_scripted_point_light_has_no_radius(kit: Kit) -> None:
    kit.light("POINT")
    assert the_light(kit).radius_m == 0.0


def test_a_spot_keeps_its_cone(kit: Kit) -> None:
    kit.light("SPOT", turn=(math.pi / 2, 0, 0), spot_size=1.2, spot_blend=0.4, shadow_soft_size=0.1)
    light = the_light(kit)
    assert (light.kind, light.radius_m) == ("spot", Approx(0.1))
    assert (light.spot_angle_rad, light.spot_blend) == (Approx(1.2), Approx(0.4))
    np.testing.assert_allclose(light.direction_ws, (0, 1, 0), atol=1e-6)
    np.testing.assert_allclose(light.half_u_ws, (1, 0, 0), atol=1e-6)
    np.testing.assert_allclose(light.spot_stretch, (1, 1))


def test_a_scaled_spot_has_a_stretched_cone(kit: Kit) -> None:
    kit.light("SPOT", scale=(3, 1, 2))
    np.testing.assert_allclose(the_light(kit).spot_stretch, (1.5, 0.5))


def test_a_sun_keeps_its_angle_and_direction_whatever_its_scale(kit: Kit) -> None:
    kit.light("SUN", turn=(0, math.pi / 2, 0), angle=0.2, energy=3, scale=(4, 5, 6))
    light = the_light(kit)
    assert (light.kind, light.sun_angle_rad) == ("sun", Approx(0.2))
    np.testing.assert_allclose(light.direction_ws, (-1, 0, 0), atol=1e-6)
    np.testing.assert_allclose(light.power_w, (3, 3, 3))


@pytest.mark.parametrize(
    ("shape", "kind", "half_u", "half_v"),
    [
        ("SQUARE", "rectangle", 1.0, 1.0),
        ("RECTANGLE", "rectangle", 1.0, 0.25),
        ("DISK", "ellipse", 1.0, 1.0),
        ("ELLIPSE", "ellipse", 1.0, 0.25),
    ],
)
def test_area_shapes_have_their_half_axes(kit: Kit, shape: str, kind: str, half_u: float, half_v: float) -> None:
    kit.light("AREA", at=(0, 0, 4), shape=shape, size=2, size_y=0.5)
    light = the_light(kit)
    assert light.kind == kind
    np.testing.assert_allclose(light.half_u_ws, (half_u, 0, 0), atol=1e-7)
    np.testing.assert_allclose(light.half_v_ws, (0, half_v, 0), atol=1e-7)
    np.testing.assert_allclose(light.direction_ws, (0, 0, -1), atol=1e-7)
    np.testing.assert_allclose(light.position_ws, (0, 0, 4))


def test_the_objects_scale_multiplies_an_area_lights_size_but_not_its_watts(kit: Kit) -> None:
    kit.light("AREA", energy=7, shape="RECTANGLE", size=2, size_y=1, scale=(3, 5, 9))
    light = the_light(kit)
    np.testing.assert_allclose(light.half_u_ws, (3, 0, 0))
    np.testing.assert_allclose(light.half_v_ws, (0, 2.5, 0))
    np.testing.assert_allclose(light.power_w, (7, 7, 7))


@pytest.mark.parametrize(
    ("scale", "direction"),
    [((-1, 1, 1), -1), ((1, -2, 1), -1), ((-1, -1, 1), -1), ((1, 1, -1), 1), ((-3, 1, -1), 1), ((1, 1, 0), -1)],
)
def test_a_mirrored_area_light_shines_along_its_own_minus_z(kit: Kit, scale: Any, direction: float) -> None:
    kit.light("AREA", scale=scale)
    np.testing.assert_allclose(the_light(kit).direction_ws, (0, 0, direction), atol=1e-7)


def test_a_sheared_area_light_is_a_parallelogram_with_a_normal(kit: Kit) -> None:
    parent = kit.object("Parent", None, scale=(3, 1, 1))
    child = kit.light("AREA", turn=(0.3, 0.7, 0.4), size=2)
    child.parent = parent
    light = the_light(kit)
    u, v, n = (np.array(x) for x in (light.half_u_ws, light.half_v_ws, light.direction_ws))
    matrix = np.array(child.matrix_world)
    np.testing.assert_allclose(u, matrix[:3, 0], atol=1e-6)
    np.testing.assert_allclose(v, matrix[:3, 1], atol=1e-6)
    assert abs(u @ v) > 0.1
    assert abs(n @ u) < 1e-6 and abs(n @ v) < 1e-6
    assert n @ -matrix[:3, 2] > 0


def test_area_lights_without_width_or_size_are_legal(kit: Kit) -> None:
    kit.light("AREA", "Tube", size=2, scale=(1, 0, 1))
    kit.light("AREA", "Dot", size=0)
    export = kit.read()
    assert {light.name: light.kind for light in export.scene.lights} == {"Tube": "rectangle", "Dot": "rectangle"}


def test_a_narrow_spread_is_noted(kit: Kit) -> None:
    kit.light("AREA", "Softbox", spread=1.0)
    assert has_note(kit.read(), "spread is ignored", "Softbox")


def test_a_light_without_shadow_is_kept_and_noted(kit: Kit) -> None:
    kit.light("POINT", "Fill", use_shadow=False)
    export = kit.read()
    assert not export.scene.lights[0].casts_shadow
    assert has_note(export, "shadow is switched off", '"Fill"')


def test_lights_hidden_in_render_do_not_cross(kit: Kit) -> None:
    kit.light("POINT", "Off").hide_render = True
    kit.light("POINT", "On")
    assert kit.read().lights == ["On"]


def test_a_light_that_is_black_is_left_out_by_name(kit: Kit) -> None:
    kit.light("POINT", "On")
    kit.light("POINT", "Dark", energy=0)
    kit.light("POINT", "Black", color=(0, 0, 0))
    export = kit.read()
    assert export.lights == ["On"]
    assert has_note(export, "0", '"Dark"', '"Black"')


def test_a_negative_light_is_left_out_by_name(kit: Kit) -> None:
    kit.light("POINT", "On")
    kit.light("POINT", "Negative", energy=-5)
    export = kit.read()
    assert export.lights == ["On"]
    assert has_note(export, "negative", '"Negative"')


def test_a_light_that_misses_diffuse_surfaces_is_left_out_by_name(kit: Kit) -> None:
    kit.light("POINT", "On")
    kit.light("POINT", "Rim").visible_diffuse = False
    export = kit.read()
    assert export.lights == ["On"]
    assert has_note(export, "ray visibility", '"Rim"')


def test_a_spot_or_sun_without_direction_is_left_out_by_name(kit: Kit) -> None:
    kit.light("POINT", "On")
    kit.light("SUN", "Flat", scale=(1, 1, 0))
    kit.light("SPOT", "Thin", scale=(0, 1, 1))
    export = kit.read()
    assert export.lights == ["On"]
    assert has_note(export, "no direction", '"Flat"', '"Thin"')


def test_two_lights_of_one_datablock_have_two_names(kit: Kit) -> None:
    first = kit.light("POINT", "Lamp")
    kit.object("Lamp copy", first.data, at=(1, 0, 0))
    assert sorted(kit.read().lights) == ["Lamp", "Lamp copy"]


def test_lights_inside_collection_instances_shine_and_say_whose_they_are(kit: Kit) -> None:
    lamp = kit.light("POINT", "Bulb", at=(0, 0, 1))
    group = bpy.data.collections.new("Lantern")
    kit.scene.collection.objects.unlink(lamp)
    group.objects.link(lamp)
    for k in range(2):
        empty = kit.object(f"Post {k}", None, at=(10 * k, 0, 0))
        empty.instance_type, empty.instance_collection = "COLLECTION", group
    export = kit.read()
    assert export.lights == ["Post 0 / Bulb", "Post 1 / Bulb"]
    np.testing.assert_allclose(export.scene.lights[1].position_ws, (10, 0, 1))


def test_soft_falloff_is_noted_where_it_matters(kit: Kit) -> None:
    kit.light("POINT", "Hard", use_soft_falloff=True)
    assert not has_note(kit.read(), "soft falloff")
    kit.light("POINT", "Soft", use_soft_falloff=True, shadow_soft_size=0.2)
    assert has_note(kit.read(), "soft falloff", '"Soft"')


def test_emission_nodes_of_a_light_multiply(kit: Kit) -> None:
    data = kit.light("POINT", energy=10).data
    data.use_nodes = True
    node = next(n for n in data.node_tree.nodes if n.type == "EMISSION")
    node.inputs["Color"].default_value = (1, 0.5, 0, 1)
    node.inputs["Strength"].default_value = 3
    np.testing.assert_allclose(the_light(kit).power_w, (30, 15, 0), rtol=1e-6)


def test_other_nodes_of_a_light_are_noted(kit: Kit) -> None:
    data = kit.light("POINT", "Gobo", energy=10).data
    data.use_nodes = True
    tree = data.node_tree
    node = next(n for n in tree.nodes if n.type == "EMISSION")
    tree.links.new(tree.nodes.new("ShaderNodeTexChecker").outputs[0], node.inputs["Color"])
    export = kit.read()
    assert has_note(export, "nodes are not read", '"Gobo"')
    np.testing.assert_allclose(export.scene.lights[0].power_w, (10, 10, 10))


needs_4_5 = pytest.mark.skipif(bpy.app.version < (4, 5, 0), reason="Blender has these since 4.5")


@needs_4_5
def test_exposure_doubles_per_stop(kit: Kit) -> None:
    kit.light("POINT", energy=5, exposure=2.0)
    np.testing.assert_allclose(the_light(kit).power_w, (20, 20, 20))


@needs_4_5
def test_a_colour_temperature_multiplies_the_colour(kit: Kit) -> None:
    data = kit.light("POINT", energy=1, color=(0.5, 1, 1)).data
    data.use_temperature, data.temperature = True, 3000
    tint = np.array(data.temperature_color)
    np.testing.assert_allclose(the_light(kit).power_w, tint * (0.5, 1, 1), rtol=1e-6)


@needs_4_5
@pytest.mark.parametrize(
    ("kind", "settings", "factor"),
    [
        ("AREA", {"size": 2.0}, 4.0 * 6.0),
        ("AREA", {"size": 2.0, "shape": "DISK"}, math.pi * 6.0),
        ("AREA", {"size": 2.0, "size_y": 1.0, "shape": "ELLIPSE"}, math.pi / 2 * 6.0),
        ("POINT", {"shadow_soft_size": 0.1}, 4 * math.pi * 0.01),
        ("SPOT", {"shadow_soft_size": 0.1}, 4 * math.pi * 0.01),
        ("POINT", {}, 4.0),
        ("SUN", {"angle": 0.5}, math.pi * math.sin(0.25) ** 2),
        ("SUN", {"angle": 0.0}, 1.0),
    ],
)
def test_without_normalising_the_watts_grow_with_the_lights_area(
    kit: Kit, kind: str, settings: Any, factor: float
) -> None:
    kit.light(kind, energy=1, normalize=False, scale=(2, 3, 1), **settings)
    assert the_light(kit).power_w[0] == Approx(factor)


def test_world_light_is_noted_unless_it_is_black(kit: Kit) -> None:
    kit.scene.world = bpy.data.worlds.new("Sky")
    if bpy.app.version < (5, 0, 0):
        kit.scene.world.use_nodes = True
    kit.light("POINT")
    background = kit.scene.world.node_tree.nodes["Background"]
    background.inputs["Color"].default_value = (0.1, 0.2, 0.4, 1)
    background.inputs["Strength"].default_value = 2
    export = kit.read()
    assert has_note(export, "world's light casts no shadow", '"Sky"')
    assert export.world == Approx((0.2, 0.4, 0.8))
    background.inputs["Strength"].default_value = 0
    assert not has_note(kit.read(), "world's light")
    sky = kit.scene.world.node_tree.nodes.new("ShaderNodeTexSky")
    kit.scene.world.node_tree.links.new(sky.outputs[0], background.inputs["Color"])
    background.inputs["Strength"].default_value = 1
    export = kit.read()
    assert has_note(export, "world's light comes from nodes", '"Sky"')
    assert export.world == (0, 0, 0)


def test_without_a_light_one_is_placed_and_noted(kit: Kit) -> None:
    kit.cube(half=3, at=(100, 0, 0))
    export = kit.read()
    assert export.lights == ["placed light"]
    assert has_note(export, "no light")
    light = export.scene.lights[0]
    to_centre = np.array((100, 0, 0)) - np.array(light.position_ws)
    np.testing.assert_allclose(np.array(light.direction_ws), to_centre / np.linalg.norm(to_centre), atol=1e-9)


def test_placed_things_are_the_same_each_time(kit: Kit) -> None:
    kit.cube(half=3, at=(1, 7, 0))
    first, second = kit.read().scene, kit.read().scene
    np.testing.assert_array_equal(first.camera.world_from_camera, second.camera.world_from_camera)
    assert first.lights[0].position_ws == second.lights[0].position_ws


# ------------------------------------------------------------------------------------------------- glowing flat meshes


def glowing(kit: Kit, points: Any, faces: Any, strength: float = 2.0, **place: Any) -> Any:
    obj = kit.mesh("Panel", points, faces, **place)
    obj.data.materials.append(kit.material("Glow", "ShaderNodeEmission", Color=(1, 0.5, 0, 1), Strength=strength))
    return obj


SQUARE = [(-1, -1, 0), (1, -1, 0), (1, 1, 0), (-1, 1, 0)]


def polygon_area(corners: Any) -> Any:
    corners = np.array(corners)
    return 0.5 * np.cross(corners, np.roll(corners, -1, axis=0)).sum(axis=0)


def test_a_glowing_square_is_a_polygon_light_and_no_object(kit: Kit) -> None:
    glowing(kit, SQUARE, [(0, 1, 2, 3)], at=(0, 0, 5), scale=(2, 1, 1))
    export = kit.read()
    assert (export.objects, export.lights) == (0, ["Panel"])
    light = export.scene.lights[0]
    assert light.kind == "polygon"
    assert len(light.corners_ws) == 4
    np.testing.assert_allclose(polygon_area(light.corners_ws), (0, 0, 8), atol=1e-6)
    np.testing.assert_allclose(light.direction_ws, (0, 0, 1), atol=1e-6)
    np.testing.assert_allclose(light.power_w, math.pi * 8 * 2 * np.array((1, 0.5, 0)), rtol=1e-6)
    assert has_note(export, "glowing flat mesh", '"Panel"')


@pytest.mark.parametrize("scale", [(-1, 1, 1), (1, 1, -1), (-1, -2, -1), (3, -1, 1)])
def test_a_mirrored_glowing_square_shines_where_blenders_normal_points(kit: Kit, scale: Any) -> None:
    obj = glowing(kit, SQUARE, [(0, 1, 2, 3)], turn=(0.3, 0.2, 0.1), scale=scale)
    bpy.context.view_layer.update()
    normal = obj.matrix_world.to_3x3().inverted_safe().transposed() @ obj.data.polygons[0].normal
    light = the_light(kit)
    np.testing.assert_allclose(light.direction_ws, normal.normalized(), atol=1e-6)
    area = polygon_area(np.array(light.corners_ws) - light.position_ws)
    np.testing.assert_allclose(area / np.linalg.norm(area), light.direction_ws, atol=1e-6)


def test_a_glowing_grid_loses_its_inner_points(kit: Kit) -> None:
    bpy.ops.mesh.primitive_grid_add(x_subdivisions=8, y_subdivisions=5)
    bpy.context.object.data.materials.append(kit.material("Glow", "ShaderNodeEmission"))
    assert len(the_light(kit).corners_ws) == 4


@pytest.mark.parametrize("corners", [3, 5, 8])
def test_up_to_eight_corners_make_a_light(kit: Kit, corners: int) -> None:
    angles = np.arange(corners) * 2 * math.pi / corners
    glowing(kit, np.column_stack((np.cos(angles), np.sin(angles), 0 * angles)), [range(corners)])
    assert len(the_light(kit).corners_ws) == corners


@pytest.mark.parametrize(
    ("points", "faces", "why"),
    [
        ([(math.cos(a), math.sin(a), 0) for a in np.arange(9) * 2 * math.pi / 9], [range(9)], "more than 8 corners"),
        ([(0, 0, 0), (2, 0, 0), (2, 2, 0), (1.9, 0.1, 0)], [(0, 1, 2, 3)], "not convex"),
        ([(0, 0, 0), (1, 0, 0), (1, 1, 0.2), (0, 1, 0)], [(0, 1, 2, 3)], "not flat"),
        ([*SQUARE, *((x, y, 1) for x, y, _ in SQUARE)], [(0, 1, 2, 3), (4, 5, 6, 7)], "not flat"),
        ([*SQUARE, (3, 0, 0), (4, 0, 0), (4, 1, 0)], [(0, 1, 2, 3), (4, 5, 6)], "not convex"),
    ],
)
def test_other_glowing_meshes_stay_surfaces_and_say_why(kit: Kit, points: Any, faces: Any, why: str) -> None:
    glowing(kit, points, faces)
    export = kit.read()
    assert export.objects == 1
    assert export.lights == ["placed light"]
    assert has_note(export, why, '"Panel"')


def test_a_partly_glowing_mesh_stays_a_surface(kit: Kit) -> None:
    obj = glowing(kit, [*SQUARE, (3, -1, 0), (3, 1, 0)], [(0, 1, 2, 3), (1, 4, 5, 2)])
    obj.data.materials.append(kit.material("Matt", "ShaderNodeBsdfDiffuse"))
    obj.data.polygons[1].material_index = 1
    export = kit.read()
    assert export.objects == 1
    assert has_note(export, "only part of it glows", '"Panel"')


def test_principled_emission_makes_a_light_and_its_default_does_not(kit: Kit) -> None:
    glow = kit.material("Lamp", "ShaderNodeBsdfPrincipled", Emission_Color=(1, 1, 1, 1), Emission_Strength=4)
    kit.mesh("Panel", SQUARE, [(0, 1, 2, 3)]).data.materials.append(glow)
    kit.mesh("Wall", SQUARE, [(0, 1, 2, 3)], at=(0, 0, -3)).data.materials.append(
        kit.material("Plain", "ShaderNodeBsdfPrincipled")
    )
    export = kit.read()
    assert (export.lights, export.objects) == (["Panel"], 1)
    assert export.scene.lights[0].power_w[0] == Approx(math.pi * 4 * 4)


def test_emission_from_a_texture_stays_a_surface(kit: Kit) -> None:
    obj = glowing(kit, SQUARE, [(0, 1, 2, 3)])
    tree = obj.data.materials[0].node_tree
    tree.links.new(tree.nodes.new("ShaderNodeTexNoise").outputs[0], tree.nodes["Emission"].inputs["Strength"])
    assert has_note(kit.read(), "nodes that are not read", '"Panel"')
