"""Makes scenes in few words, and writes down what the bridge sends."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import bpy
import numpy as np
import penumbra_core as core
import pytest

__all__ = ["Kit", "Sent", "SentInstance", "SentMesh", "bpy", "core", "record"]


@dataclass
class SentMesh:
    name: str
    positions: Any
    triangles: Any
    corner_normals: Any
    triangle_material: Any


@dataclass
class SentInstance:
    name: str
    mesh: SentMesh
    world_from_local: Any
    albedo: Any
    casts: bool
    receives: bool
    visible: bool

    def world_positions(self) -> Any:
        m = self.world_from_local
        return self.mesh.positions.astype(np.float64) @ m[:3, :3].T + m[:3, 3]


@dataclass
class Sent:
    """What went over the border to the core, which received it too."""

    meshes: list[SentMesh] = field(default_factory=list)
    instances: list[SentInstance] = field(default_factory=list)

    def __getitem__(self, name: str) -> SentInstance:
        return next(i for i in self.instances if i.name == name)

    def names(self) -> list[str]:
        return [i.name for i in self.instances]


class Kit:
    """Short words for making scenes."""

    def __init__(self) -> None:
        self.scene = bpy.context.scene

    def object(self, name: str, data: Any, at: Any = (0, 0, 0), turn: Any = (0, 0, 0), scale: Any = (1, 1, 1)) -> Any:
        obj = bpy.data.objects.new(name, data)
        obj.location, obj.rotation_euler, obj.scale = at, turn, scale
        self.scene.collection.objects.link(obj)
        return obj

    def mesh(self, name: str, points: Any, faces: Any, **place: Any) -> Any:
        mesh = bpy.data.meshes.new(name)
        mesh.from_pydata([tuple(p) for p in points], [], [tuple(f) for f in faces])
        return self.object(name, mesh, **place)

    def plane(self, name: str = "Plane", half: float = 1.0, **place: Any) -> Any:
        corners = [(-half, -half, 0), (half, -half, 0), (half, half, 0), (-half, half, 0)]
        return self.mesh(name, corners, [(0, 1, 2, 3)], **place)

    def cube(self, name: str = "Cube", half: float = 1.0, **place: Any) -> Any:
        points = [((i & 1) * 2 - 1, (i >> 1 & 1) * 2 - 1, (i >> 2) * 2 - 1) for i in range(8)]
        faces = [(0, 2, 3, 1), (4, 5, 7, 6), (0, 1, 5, 4), (2, 6, 7, 3), (0, 4, 6, 2), (1, 3, 7, 5)]
        return self.mesh(name, np.array(points) * half, faces, **place)

    def light(self, kind: str, name: str = "Light", energy: float = 10.0, **rest: Any) -> Any:
        place = {key: rest.pop(key) for key in ("at", "turn", "scale") if key in rest}
        data = bpy.data.lights.new(name, kind)
        data.energy = energy
        for key, value in rest.items():
            setattr(data, key, value)
        return self.object(name, data, **place)

    def camera(self, name: str = "Camera", at: Any = (0, 0, 10), turn: Any = (0, 0, 0), **settings: Any) -> Any:
        data = bpy.data.cameras.new(name)
        for key, value in settings.items():
            setattr(data, key, value)
        obj = self.object(name, data, at, turn)
        self.scene.camera = obj
        return obj

    def plate_over_floor(self) -> None:
        """A plate over a floor under a square light, seen from the side in 96 x 64 pixels."""
        self.plane("Floor", half=5)
        self.plane("Plate", half=0.7, at=(0, 0, 1))
        self.light("AREA", name="Key", energy=100, at=(0, 0, 4), size=1.0)
        self.camera(at=(0, -5, 4.2), turn=(0.87, 0, 0))
        render = self.scene.render
        render.resolution_x, render.resolution_y, render.resolution_percentage = 96, 64, 100

    def material(self, name: str, node: str, **inputs: Any) -> Any:
        """A material of one shader node; input names with _ for a space."""
        material = bpy.data.materials.new(name)
        if bpy.app.version < (5, 0, 0):
            material.use_nodes = True
        tree = material.node_tree
        tree.nodes.clear()
        output = tree.nodes.new("ShaderNodeOutputMaterial")
        shader = tree.nodes.new(node)
        for key, value in inputs.items():
            shader.inputs[key.replace("_", " ")].default_value = value
        tree.links.new(shader.outputs[0], output.inputs["Surface"])
        return material

    def read(self, **wanted: Any) -> Any:
        """As a final render sees it."""
        from penumbra import scenes

        bpy.context.view_layer.update()
        return scenes.read(**wanted)


def record(monkeypatch: pytest.MonkeyPatch) -> Sent:
    """Write down what the bridge sends from now on; the core gets it all the same."""
    log = Sent()
    known: dict[int, SentMesh] = {}

    def mesh(
        name: str, positions: Any, triangles: Any, corner_normals: Any = None, triangle_material: Any = None
    ) -> Any:
        made = real_mesh(name, positions, triangles, corner_normals=corner_normals, triangle_material=triangle_material)
        known[id(made)] = SentMesh(name, positions, triangles, corner_normals, triangle_material)
        log.meshes.append(known[id(made)])
        kept.append(made)
        return made

    class Scene(core.Scene):  # type: ignore[misc, name-defined]
        def add_instance(self, name: str, mesh: Any, world_from_local: Any, **rest: Any) -> None:
            super().add_instance(name, mesh, world_from_local, **rest)
            log.instances.append(SentInstance(name, known[id(mesh)], world_from_local, **rest))

    real_mesh, kept = core.Mesh, []
    monkeypatch.setattr(core, "Mesh", mesh)
    monkeypatch.setattr(core, "Scene", Scene)
    return log
    return log
