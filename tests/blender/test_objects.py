"""What of a Blender scene reaches the core, and what is left out by name."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from blender_kit import Kit, Sent, bpy, core
from penumbra import bridge, scenes


def has_note(export: Any, *parts: str) -> bool:
    return any(all(part in note for part in parts) for note in export.notes)


def test_transforms_reach_the_core_in_world_space(kit: Kit, sent: Sent) -> None:
    parent = kit.cube("Parent", at=(1, 2, 3), turn=(0.1, 0.2, 0.3), scale=(2, 2, 2))
    child = kit.cube("Child", at=(0, 0, 5), scale=(-1, 0.5, 3))
    child.parent = parent
    kit.read()
    np.testing.assert_array_equal(sent["Child"].world_from_local, np.array(child.matrix_world, dtype=np.float64))
    assert np.linalg.det(sent["Child"].world_from_local[:3, :3]) < 0


def test_modifiers_are_applied(kit: Kit, sent: Sent) -> None:
    plane = kit.plane()
    array = plane.modifiers.new("Array", "ARRAY")
    array.count = 7
    assert kit.read().triangles == 14


def test_render_levels_of_a_modifier_count_not_the_viewports(kit: Kit, sent: Sent) -> None:
    plane = kit.plane()
    modifier = plane.modifiers.new("Subdivision", "SUBSURF")
    modifier.levels, modifier.render_levels = 0, 3
    assert kit.read().triangles == 2 * 8 * 8
    bpy.context.view_layer.update()
    assert bridge.read_scene(bpy.context.evaluated_depsgraph_get()).triangles == 2


def test_shape_keys_and_frames_are_evaluated(kit: Kit, sent: Sent) -> None:
    cube = kit.cube()
    cube.keyframe_insert("location", frame=1)
    cube.location = (10, 0, 0)
    cube.keyframe_insert("location", frame=11)
    export = kit.read(frame=11)
    assert export.frame == 11
    assert sent["Cube"].world_from_local[0, 3] == 10.0


def test_linked_duplicates_share_one_mesh(kit: Kit, sent: Sent) -> None:
    first = kit.cube("First")
    for k in range(4):
        kit.object(f"Copy {k}", first.data, at=(k, 0, 0))
    export = kit.read()
    assert (export.objects, export.meshes, export.triangles) == (5, 1, 60)
    assert len(sent.meshes) == 1


def test_objects_with_different_modifiers_do_not_share_a_mesh(kit: Kit, sent: Sent) -> None:
    first = kit.plane("First")
    kit.object("Second", first.data).modifiers.new("Array", "ARRAY").count = 3
    assert kit.read().triangles == 2 + 6


def collection_of(kit: Kit, *objects: Any) -> Any:
    collection = bpy.data.collections.new("Group")
    for obj in objects:
        kit.scene.collection.objects.unlink(obj)
        collection.objects.link(obj)
    return collection


def test_collection_instances_share_meshes_and_have_readable_names(kit: Kit, sent: Sent) -> None:
    group = collection_of(kit, kit.cube("Box", at=(0, 0, 1)), kit.plane("Leaf"))
    for k in range(3):
        empty = kit.object(f"Tree {k}", None, at=(10 * k, 0, 0), scale=(2, 2, 2))
        empty.instance_type, empty.instance_collection = "COLLECTION", group
    export = kit.read()
    assert (export.objects, export.meshes) == (6, 2)
    assert "Tree 1 / Box 1" in sent.names()
    np.testing.assert_allclose(sent["Tree 2 / Box 1"].world_from_local[:3, 3], (20, 0, 2))


def test_instances_on_vertices_are_counted_and_the_instancer_can_hide_itself(kit: Kit, sent: Sent) -> None:
    parent = kit.plane("Field")
    child = kit.cube("Stone", half=0.1)
    child.parent = parent
    parent.instance_type = "VERTS"
    parent.show_instancer_for_render = False
    kit.read()
    assert sorted(sent.names()) == [f"Field / Stone {k}" for k in range(1, 5)]


def test_particles_that_show_an_object_become_instances(kit: Kit, sent: Sent) -> None:
    ground = kit.plane("Ground", half=5)
    stone = kit.cube("Stone", half=0.1, at=(0, 0, -5))
    ground.modifiers.new("Particles", "PARTICLE_SYSTEM")
    settings = ground.particle_systems[0].settings
    settings.type, settings.count, settings.render_type = "HAIR", 20, "OBJECT"
    settings.instance_object = stone
    export = kit.read()
    assert export.meshes == 2
    assert sum("Ground / Stone" in name for name in sent.names()) == 20


def test_hair_is_left_out_by_name(kit: Kit, sent: Sent) -> None:
    ground = kit.plane("Ground")
    ground.modifiers.new("Particles", "PARTICLE_SYSTEM")
    ground.particle_systems[0].settings.type = "HAIR"
    assert has_note(kit.read(), "hair", '"Ground"')


def test_geometry_nodes_instances_share_their_mesh(kit: Kit, sent: Sent) -> None:
    grid = kit.plane("Field", half=3)
    tree = bpy.data.node_groups.new("Scatter", "GeometryNodeTree")
    tree.interface.new_socket("Geometry", in_out="INPUT", socket_type="NodeSocketGeometry")
    tree.interface.new_socket("Geometry", in_out="OUTPUT", socket_type="NodeSocketGeometry")
    start, end = tree.nodes.new("NodeGroupInput"), tree.nodes.new("NodeGroupOutput")
    cone = tree.nodes.new("GeometryNodeMeshCone")
    scatter = tree.nodes.new("GeometryNodeInstanceOnPoints")
    tree.links.new(start.outputs[0], scatter.inputs["Points"])
    tree.links.new(cone.outputs["Mesh"], scatter.inputs["Instance"])
    tree.links.new(scatter.outputs[0], end.inputs[0])
    grid.modifiers.new("Scatter", "NODES").node_group = tree
    export = kit.read()
    assert export.objects == 4
    assert len(sent.meshes) == 1


@pytest.mark.parametrize("kind", ["CURVE", "FONT", "META", "SURFACE"])
def test_what_becomes_a_mesh_is_sent(kit: Kit, sent: Sent, kind: str) -> None:
    if kind == "CURVE":
        bpy.ops.curve.primitive_bezier_circle_add()
        bpy.context.object.data.bevel_depth = 0.1
    elif kind == "FONT":
        bpy.ops.object.text_add()
        bpy.context.object.data.extrude = 0.1
    elif kind == "META":
        bpy.ops.object.metaball_add(type="BALL")
    else:
        bpy.ops.surface.primitive_nurbs_surface_sphere_add()
    export = kit.read()
    assert export.objects == 1
    assert export.triangles > 20


def test_two_curve_objects_of_one_curve_each_keep_their_shape(kit: Kit, sent: Sent) -> None:
    bpy.ops.curve.primitive_bezier_circle_add()
    first = bpy.context.object
    first.data.bevel_depth = 0.1
    second = kit.object("Second", first.data, at=(5, 0, 0))
    second.modifiers.new("Array", "ARRAY").count = 2
    kit.read()
    assert len(sent["Second"].mesh.triangles) == 2 * len(sent[first.name].mesh.triangles)


def test_instances_of_a_curve_are_read_once_per_object(kit: Kit, sent: Sent) -> None:
    bpy.ops.curve.primitive_bezier_circle_add()
    ring = bpy.context.object
    ring.data.bevel_depth = 0.1
    group = collection_of(kit, ring, kit.cube("Box"))
    for k in range(5):
        empty = kit.object(f"Place {k}", None, at=(5 * k, 0, 0))
        empty.instance_type, empty.instance_collection = "COLLECTION", group
    export = kit.read()
    assert (export.objects, export.meshes) == (10, 2)


def test_a_curve_without_thickness_is_skipped_silently(kit: Kit, sent: Sent) -> None:
    bpy.ops.curve.primitive_bezier_curve_add()
    export = kit.read()
    assert export.objects == 0
    assert not has_note(export, "BezierCurve")


def test_objects_hidden_in_render_do_not_cross(kit: Kit, sent: Sent) -> None:
    kit.cube("Shown")
    kit.cube("Hidden").hide_render = True
    kit.read()
    assert sent.names() == ["Shown"]


def test_objects_hidden_only_in_the_viewport_do_cross(kit: Kit, sent: Sent) -> None:
    kit.cube("Eye closed").hide_set(True)
    kit.cube("Screen off").hide_viewport = True
    kit.read()
    assert sorted(sent.names()) == ["Eye closed", "Screen off"]


@pytest.mark.parametrize("switch", ["hide_render", "exclude"])
def test_collections_switched_off_do_not_cross(kit: Kit, sent: Sent, switch: str) -> None:
    group = collection_of(kit, kit.cube("Inside"))
    kit.scene.collection.children.link(group)
    kit.cube("Outside")
    if switch == "hide_render":
        group.hide_render = True
    else:
        bpy.context.view_layer.layer_collection.children["Group"].exclude = True
    kit.read()
    assert sent.names() == ["Outside"]


@pytest.mark.parametrize("switch", ["holdout", "indirect_only"])
def test_collection_switches_of_the_view_layer_count(kit: Kit, sent: Sent, switch: str) -> None:
    group = collection_of(kit, kit.cube("Inside"))
    kit.scene.collection.children.link(group)
    setattr(bpy.context.view_layer.layer_collection.children["Group"], switch, True)
    kit.read()
    inside = sent["Inside"]
    assert inside.casts
    assert inside.visible == (switch == "holdout")
    assert inside.receives == (switch != "holdout")


def test_ray_visibility_becomes_visible_and_casts(kit: Kit, sent: Sent) -> None:
    kit.cube("Ghost").visible_camera = False
    kit.cube("Glass").visible_shadow = False
    nothing = kit.cube("Nothing")
    nothing.visible_camera = nothing.visible_shadow = False
    kit.read()
    assert sorted(sent.names()) == ["Ghost", "Glass"]
    assert (sent["Ghost"].visible, sent["Ghost"].casts) == (False, True)
    assert (sent["Glass"].visible, sent["Glass"].casts) == (True, False)


def test_an_instance_obeys_its_instancers_ray_visibility(kit: Kit, sent: Sent) -> None:
    group = collection_of(kit, kit.cube("Box"))
    empty = kit.object("Tree", None)
    empty.instance_type, empty.instance_collection = "COLLECTION", group
    empty.visible_shadow = False
    kit.read()
    assert not sent["Tree / Box 1"].casts


def test_holdouts_and_shadow_catchers_are_noted(kit: Kit, sent: Sent) -> None:
    kit.cube("Hole").is_holdout = True
    kit.plane("Catcher").is_shadow_catcher = True
    export = kit.read()
    assert not sent["Hole"].receives
    assert sent["Hole"].casts
    assert sent["Catcher"].receives
    assert has_note(export, "holdout", '"Hole"')
    assert has_note(export, "shadow catcher", '"Catcher"')


def test_a_scale_of_zero_leaves_the_object_out_by_name(kit: Kit, sent: Sent) -> None:
    kit.cube("Good")
    kit.cube("Squashed", scale=(1, 1, 0))
    kit.cube("Gone", scale=(0, 0, 0))
    export = kit.read()
    assert sent.names() == ["Good"]
    assert has_note(export, "flattens", '"Squashed"', '"Gone"')


def test_a_tiny_scale_is_no_zero(kit: Kit, sent: Sent) -> None:
    kit.cube("Tiny", scale=(1e-6, 1e-6, 1e-6))
    kit.cube("Sheet", scale=(100, 100, 1e-5))
    assert kit.read().objects == 2


def test_positions_that_are_not_numbers_leave_the_object_out_by_name(kit: Kit, sent: Sent) -> None:
    kit.cube("Good")
    broken = kit.cube("Broken")
    broken.data.vertices[3].co.y = float("nan")
    export = kit.read()
    assert sent.names() == ["Good"]
    assert has_note(export, "not numbers", '"Broken"')


def test_a_mesh_without_faces_is_left_out_by_name_and_an_empty_one_silently(kit: Kit, sent: Sent) -> None:
    kit.mesh("Points", [(0, 0, 0), (1, 1, 1)], [])
    kit.object("Void", bpy.data.meshes.new("Void"))
    export = kit.read()
    assert export.objects == 0
    assert has_note(export, "no faces", '"Points"')
    assert not has_note(export, "Void")


def test_volumes_are_left_out_by_name(kit: Kit, sent: Sent) -> None:
    kit.object("Smoke", bpy.data.volumes.new("Smoke"))
    assert has_note(kit.read(), "volume objects have no triangles", '"Smoke"')


def test_notes_count_and_say_nothing_twice(kit: Kit, sent: Sent) -> None:
    for k in range(9):
        kit.cube(f"Flat {k}", scale=(1, 0, 1))
    notes = [note for note in kit.read().notes if "flattens" in note]
    assert len(notes) == 1
    assert notes[0].endswith('"Flat 0", "Flat 1", "Flat 2", "Flat 3" and 5 more')


def test_a_mesh_in_edit_mode_is_read(kit: Kit, sent: Sent) -> None:
    cube = kit.cube()
    bpy.context.view_layer.objects.active = cube
    bpy.ops.object.mode_set(mode="EDIT")
    assert kit.read().triangles == 12
    bpy.ops.object.mode_set(mode="OBJECT")


def test_an_empty_scene_is_read_with_a_placed_camera_and_light(kit: Kit) -> None:
    export = kit.read()
    assert (export.objects, export.camera, export.lights) == (0, "placed camera", ["placed light"])


def test_the_export_names_its_size_and_counts(kit: Kit) -> None:
    kit.cube()
    kit.camera()
    kit.light("POINT")
    kit.scene.render.resolution_x, kit.scene.render.resolution_y = 100, 50
    export = kit.read()
    assert isinstance(export.scene, core.Scene)
    assert (export.size, export.camera, export.lights, export.triangles) == ((100, 50), "Camera", ["Light"], 12)
    assert export.scene.triangle_count == 12
    assert export.scene.instance_count == 1


# ----------------------------------------------------------------------------------------------------------- colours


def test_the_principled_base_colour_is_the_albedo(kit: Kit, sent: Sent) -> None:
    kit.cube().data.materials.append(kit.material("Red", "ShaderNodeBsdfPrincipled", Base_Color=(0.8, 0.1, 0.2, 1)))
    kit.read()
    np.testing.assert_allclose(sent["Cube"].albedo, [[0.8, 0.1, 0.2]], atol=1e-6)


def test_the_diffuse_colour_is_the_albedo(kit: Kit, sent: Sent) -> None:
    kit.cube().data.materials.append(kit.material("Red", "ShaderNodeBsdfDiffuse", Color=(0.1, 0.5, 0.2, 1)))
    kit.read()
    np.testing.assert_allclose(sent["Cube"].albedo, [[0.1, 0.5, 0.2]], atol=1e-6)


@pytest.mark.skipif(bpy.app.version >= (5, 0, 0), reason="materials always use nodes since 5.0")
def test_without_nodes_the_viewport_colour_is_the_albedo(kit: Kit, sent: Sent) -> None:
    material = bpy.data.materials.new("Plain")
    material.diffuse_color = (0.3, 0.4, 0.5, 1)
    material.use_nodes = False
    kit.cube().data.materials.append(material)
    kit.read()
    np.testing.assert_allclose(sent["Cube"].albedo, [[0.3, 0.4, 0.5]], atol=1e-6)


def test_a_colour_from_a_texture_is_replaced_and_noted(kit: Kit, sent: Sent) -> None:
    material = kit.material("Wood", "ShaderNodeBsdfPrincipled")
    material.diffuse_color = (0.2, 0.3, 0.1, 1)
    tree = material.node_tree
    texture = tree.nodes.new("ShaderNodeTexNoise")
    tree.links.new(texture.outputs["Color"], tree.nodes["Principled BSDF"].inputs["Base Color"])
    kit.cube().data.materials.append(material)
    assert has_note(kit.read(), "texture", '"Wood"')
    np.testing.assert_allclose(sent["Cube"].albedo, [[0.2, 0.3, 0.1]], atol=1e-6)


def test_a_mix_of_shaders_is_mixed(kit: Kit, sent: Sent) -> None:
    material = kit.material("Mix", "ShaderNodeMixShader", Fac=0.25)
    tree = material.node_tree
    mix = tree.nodes["Mix Shader"]
    for k, colour in enumerate(((1, 0, 0, 1), (0, 1, 0, 1))):
        diffuse = tree.nodes.new("ShaderNodeBsdfDiffuse")
        diffuse.inputs["Color"].default_value = colour
        tree.links.new(diffuse.outputs[0], mix.inputs[k + 1])
    kit.cube().data.materials.append(material)
    kit.read()
    np.testing.assert_allclose(sent["Cube"].albedo, [[0.75, 0.25, 0]], atol=1e-6)


def test_a_colour_inside_a_node_group_is_found(kit: Kit, sent: Sent) -> None:
    group = bpy.data.node_groups.new("Paint", "ShaderNodeTree")
    group.interface.new_socket("Shader", in_out="OUTPUT", socket_type="NodeSocketShader")
    end, diffuse = group.nodes.new("NodeGroupOutput"), group.nodes.new("ShaderNodeBsdfDiffuse")
    diffuse.inputs["Color"].default_value = (0.6, 0.1, 0.1, 1)
    group.links.new(diffuse.outputs[0], end.inputs[0])
    material = kit.material("Grouped", "ShaderNodeBsdfDiffuse")
    tree = material.node_tree
    node = tree.nodes.new("ShaderNodeGroup")
    node.node_tree = group
    output = next(n for n in tree.nodes if n.type == "OUTPUT_MATERIAL")
    tree.links.new(node.outputs[0], output.inputs["Surface"])
    kit.cube().data.materials.append(material)
    kit.read()
    np.testing.assert_allclose(sent["Cube"].albedo, [[0.6, 0.1, 0.1]], atol=1e-6)


def test_see_through_materials_are_noted(kit: Kit, sent: Sent) -> None:
    kit.cube().data.materials.append(kit.material("Window", "ShaderNodeBsdfGlass"))
    assert has_note(kit.read(), "taken as opaque", '"Window"')


def test_each_slot_has_its_colour_and_each_triangle_its_slot(kit: Kit, sent: Sent) -> None:
    cube = kit.cube()
    for k in range(3):
        colour = (0.1 * (k + 1), 0, 0, 1)
        cube.data.materials.append(kit.material(f"M{k}", "ShaderNodeBsdfDiffuse", Color=colour))
    cube.data.polygons[4].material_index = 2
    kit.read()
    np.testing.assert_allclose(sent["Cube"].albedo[:, 0], [0.1, 0.2, 0.3], atol=1e-6)
    assert sorted(sent["Cube"].mesh.triangle_material.tolist()) == [0] * 10 + [2] * 2


def test_a_material_linked_to_the_object_wins_over_the_meshs(kit: Kit, sent: Sent) -> None:
    first = kit.cube("First")
    first.data.materials.append(kit.material("Red", "ShaderNodeBsdfDiffuse", Color=(1, 0, 0, 1)))
    second = kit.object("Second", first.data)
    second.material_slots[0].link = "OBJECT"
    second.material_slots[0].material = kit.material("Blue", "ShaderNodeBsdfDiffuse", Color=(0, 0, 1, 1))
    kit.read()
    np.testing.assert_allclose(sent["First"].albedo, [[1, 0, 0]])
    np.testing.assert_allclose(sent["Second"].albedo, [[0, 0, 1]])
    assert len(sent.meshes) == 1


def test_an_empty_slot_is_grey(kit: Kit, sent: Sent) -> None:
    cube = kit.cube()
    cube.data.materials.append(None)
    kit.read()
    np.testing.assert_allclose(sent["Cube"].albedo, [[0.8, 0.8, 0.8]], atol=1e-6)


def test_the_render_settings_are_as_they_were(kit: Kit) -> None:
    kit.cube()
    render = kit.scene.render
    before = (render.engine, render.use_compositing, render.use_sequencer, kit.scene.camera)
    kit.read()
    assert (render.engine, render.use_compositing, render.use_sequencer, kit.scene.camera) == before
    assert not hasattr(bpy.types, "PENUMBRA_READER")


def test_an_error_of_the_core_reaches_the_caller(kit: Kit) -> None:
    def fail(_depsgraph: Any) -> None:
        raise core.InvalidScene("said by the core")

    with pytest.raises(core.InvalidScene, match="said by the core"):
        scenes.render_depsgraph(kit.scene, fail)


def test_an_unknown_view_layer_is_one_sentence(kit: Kit) -> None:
    with pytest.raises(scenes.SceneError, match='no view layer called "Other"'):
        kit.read(view_layer="Other")
