"""A core.Scene that follows Blender's: after every change it equals the one that is read from scratch."""

from __future__ import annotations

from typing import Any

import bpy
import pytest
from blender_kit import Kit
from penumbra import bridge
from penumbra.sync import SceneSync


class Follower:
    """A sync, and the updates of Blender's depsgraph that a viewport engine would be told of."""

    def __init__(self) -> None:
        self.sync = SceneSync()
        self.export = self.sync.update(self.depsgraph())

    @staticmethod
    def depsgraph() -> Any:
        return bpy.context.evaluated_depsgraph_get()

    def follow(self, *, full: bool) -> bridge.SceneExport:
        """One update; `full` says whether everything had to be read."""
        before = self.sync.full_reads
        caught: list[Exception] = []

        def update(_scene: Any, depsgraph: Any) -> None:
            try:
                self.export = self.sync.update(depsgraph)
            except Exception as error:
                caught.append(error)

        # Blender forgets what it updated once the handlers have heard of it.
        bpy.app.handlers.depsgraph_update_post.append(update)
        try:
            bpy.context.view_layer.update()
        finally:
            bpy.app.handlers.depsgraph_update_post.remove(update)
        if caught:
            raise caught[0]
        assert (self.sync.full_reads > before) == full
        fresh = bridge.read_scene(self.depsgraph())
        assert self.export.scene.digest() == fresh.scene.digest()
        assert self.export.lights == fresh.lights
        return self.export


def furnished(kit: Kit) -> Follower:
    kit.plane("Floor", half=5)
    kit.cube("Box", at=(0, 0, 2))
    child = kit.cube("Child", half=0.2, at=(0, 0, 2))
    child.parent = bpy.data.objects["Box"]
    kit.light("POINT", name="Key", energy=50, at=(1, 1, 4), shadow_soft_size=0.2)
    kit.light("AREA", name="Fill", energy=20, at=(-1, 1, 4))
    kit.camera()
    return Follower()


def test_nothing_changed_costs_nothing(kit: Kit) -> None:
    follower = furnished(kit)
    scene = follower.export.scene
    assert follower.follow(full=False).scene is scene


def test_a_moved_object_and_its_children_cost_their_matrices(kit: Kit) -> None:
    follower = furnished(kit)
    before = follower.export.scene.digest()
    box = bpy.data.objects["Box"]
    box.location.x, box.rotation_euler.z = 1.5, 0.4
    assert follower.follow(full=False).scene.digest() != before


def test_a_moved_or_changed_light_keeps_the_rest(kit: Kit) -> None:
    follower = furnished(kit)
    bpy.data.objects["Key"].location.x = 2
    follower.follow(full=False)
    bpy.data.lights["Fill"].energy = 33
    bpy.data.lights["Fill"].size = 0.7
    follower.follow(full=False)


def test_nodes_of_a_light_are_the_lights_and_those_of_a_material_are_not(kit: Kit) -> None:
    follower = furnished(kit)
    light = bpy.data.lights["Key"]
    if bpy.app.version < (5, 1, 0):
        light.use_nodes = True
    follower.export = follower.sync.update(follower.depsgraph())
    bpy.context.view_layer.update()
    emission = next(node for node in light.node_tree.nodes if node.type == "EMISSION")
    before = follower.export.scene.digest()
    emission.inputs["Color"].default_value = (1.0, 0.5, 0.25, 1.0)
    assert follower.follow(full=False).scene.digest() != before
    bpy.data.objects["Box"].data.materials.append(kit.material("Red", "ShaderNodeBsdfDiffuse", Color=(1, 0, 0, 1)))
    follower.follow(full=True)
    light.energy = 77
    bpy.data.materials["Red"].node_tree.nodes["Diffuse BSDF"].inputs["Color"].default_value = (0, 1, 0, 1)
    follower.follow(full=True)


def test_a_light_that_goes_out_is_gone(kit: Kit) -> None:
    follower = furnished(kit)
    bpy.data.lights["Fill"].energy = 0
    assert follower.follow(full=True).lights == ["Key"]
    bpy.data.lights["Fill"].energy = 1
    assert sorted(follower.follow(full=True).lights) == ["Fill", "Key"]


@pytest.mark.parametrize("what", ["mesh", "modifier", "material", "new", "hidden", "deleted", "instances", "flat"])
def test_other_changes_are_read_again(kit: Kit, what: str) -> None:
    follower = furnished(kit)
    box = bpy.data.objects["Box"]
    if what == "mesh":
        box.data.vertices[0].co.x -= 0.5
        box.data.update()
    elif what == "modifier":
        box.modifiers.new("Bevel", "BEVEL")
    elif what == "material":
        material = kit.material("Red", "ShaderNodeBsdfDiffuse", Color=(1, 0, 0, 1))
        box.data.materials.append(material)
        follower.follow(full=True)
        material.node_tree.nodes["Diffuse BSDF"].inputs["Color"].default_value = (0, 1, 0, 1)
    elif what == "new":
        kit.cube("Another", at=(3, 0, 1))
    elif what == "hidden":
        box.hide_viewport = True
    elif what == "deleted":
        bpy.data.objects.remove(box)
    elif what == "instances":
        empty = kit.object("Maker", None)
        group = bpy.data.collections.new("Group")
        bpy.context.scene.collection.children.link(group)
        group.objects.link(box)
        empty.instance_type, empty.instance_collection = "COLLECTION", group
        follower.follow(full=True)
        empty.location.z = 3
    else:
        box.scale.x = 0
    follower.follow(full=True)


def test_meshes_that_nobody_touched_are_kept(kit: Kit, monkeypatch: pytest.MonkeyPatch) -> None:
    follower = furnished(kit)
    read: list[str] = []
    real = bridge.read_mesh

    def counted(mesh: Any, *rest: Any) -> Any:
        read.append(mesh.name)
        return real(mesh, *rest)

    with monkeypatch.context() as patch:
        patch.setattr(bridge, "read_mesh", counted)
        box = bpy.data.objects["Box"]
        box.data.vertices[0].co.x -= 0.5
        box.data.update()
        before = follower.sync.full_reads
        handler: list[Any] = []
        handler.append(lambda _scene, depsgraph: follower.sync.update(depsgraph))
        bpy.app.handlers.depsgraph_update_post.append(handler[0])
        bpy.context.view_layer.update()
        bpy.app.handlers.depsgraph_update_post.remove(handler[0])
        assert follower.sync.full_reads == before + 1
        assert read == ["Box"]


def test_a_deleted_object_s_mesh_is_never_taken_for_another_s(kit: Kit) -> None:
    follower = furnished(kit)
    for number in range(12):
        obj = kit.cube(f"Visitor {number}", half=0.1 + 0.05 * number, at=(number, 0, 1))
        follower.follow(full=True)
        mesh = obj.data
        bpy.data.objects.remove(obj)
        bpy.data.meshes.remove(mesh)
        follower.follow(full=True)


def test_an_invalid_scene_is_a_sentence_and_the_next_update_reads_everything(kit: Kit) -> None:
    follower = furnished(kit)
    bpy.data.objects["Box"].location.x = 1
    kit.camera("Flat").scale = (0, 0, 0)
    with pytest.raises(bridge.BridgeError, match="Flat"):
        follower.follow(full=True)
    bpy.data.objects["Flat"].scale = (1, 1, 1)
    follower.follow(full=True)


def test_moving_one_object_among_many_reads_one_matrix(kit: Kit, monkeypatch: pytest.MonkeyPatch) -> None:
    from penumbra import sync

    for number in range(300):
        kit.cube(f"Box {number}", half=0.3, at=(number % 20, number // 20, 0))
    kit.light("SUN")
    kit.camera()
    follower = Follower()
    read: list[Any] = []
    real = sync.matrix_of
    monkeypatch.setattr(sync, "matrix_of", lambda matrix: read.append(matrix) or real(matrix))
    bpy.data.objects["Box 150"].location.z = 1
    follower.follow(full=False)
    assert len(read) == 1
