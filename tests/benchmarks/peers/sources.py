"""Where scenes come from: a torus knot made here, the examples, meshes of a folder."""

from __future__ import annotations

import math
import sys
from pathlib import Path
from typing import Any

import numpy as np

from .exchange import LIGHT_KINDS, Camera, Light, Part, SharedScene

ROOT = Path(__file__).resolve().parents[3]
KNOT = "knot"
EXAMPLES = ("courtyard", "desk", "plaza")
MESH_SUFFIXES = (".obj", ".ply", ".stl")


def names(meshes: Path | None) -> dict[str, Path | None]:
    """Every scene by its name, and the file it comes from."""
    found: dict[str, Path | None] = {KNOT: None}
    found |= {name: ROOT / "examples" / f"{name}.blend" for name in EXAMPLES}
    if meshes is not None:
        files = sorted(file for file in meshes.iterdir() if file.suffix.lower() in MESH_SUFFIXES)
        found |= {file.stem.removeprefix("stanford-"): file for file in files}
    return found


class Made:
    """A worker that makes a scene for the others and is done."""

    def __init__(self, name: str, file: Path | None, size: tuple[int, int], folder: Path) -> None:
        self._scene = make(name, file, size)
        self._scene.save(folder)

    def facts(self) -> dict[str, Any]:
        return {"triangles": self._scene.triangle_count}

    def render(self, settings: dict[str, Any], out: str) -> dict[str, Any]:
        raise NotImplementedError


def make(name: str, file: Path | None, size: tuple[int, int]) -> SharedScene:
    return knot(size) if file is None else from_blender(name, file, size)


def knot(size: tuple[int, int], around: int = 22, along: int = 264) -> SharedScene:
    """Torus knot (2, 3) of 2 `around` `along` triangles over a ground, under a square light of 1 m."""

    def centre(t: float) -> Any:
        r = 1.0 + 0.4 * math.cos(3.0 * t)
        return np.array([r * math.cos(2.0 * t), r * math.sin(2.0 * t), 0.9 + 0.4 * math.sin(3.0 * t)])

    angles = 2.0 * math.pi * np.arange(around) / around
    rings = []
    for t in 2.0 * math.pi * np.arange(along) / along:
        tangent = centre(t + 1e-4) - centre(t - 1e-4)
        side = np.cross(tangent, (0, 0, 1))
        side /= np.linalg.norm(side)
        up = np.cross(side, tangent)
        up /= np.linalg.norm(up)
        rings.append(centre(t) + 0.16 * (np.outer(np.cos(angles), side) + np.outer(np.sin(angles), up)))
    i, j = np.meshgrid(np.arange(along), np.arange(around), indexing="ij")
    at = [(i + u) % along * around + (j + v) % around for u, v in ((0, 0), (1, 0), (1, 1), (0, 1))]
    faces = np.stack([at[0], at[1], at[2], at[0], at[2], at[3]], axis=-1).reshape(-1, 3)
    ground = np.array([[-4, -4, 0], [4, -4, 0], [4, 4, 0], [-4, 4, 0]], np.float32)
    parts = [
        Part("ground", ground, np.array([[0, 1, 2], [0, 2, 3]], np.uint32)),
        Part("knot", np.concatenate(rings).astype(np.float32), faces.astype(np.uint32)),
    ]
    light = Light("rectangle", (1.0, 0.6, 5.0), (0, 0, -1), (0.5, 0, 0), (0, -0.5, 0), 0.0, math.pi**2 * 5.0**2)
    eye, aim = np.array([4.2, -4.2, 4.2]), np.array([0, 0, 0.3])
    back = (eye - aim) / np.linalg.norm(eye - aim)
    right = np.cross((0, 0, 1), back)
    right /= np.linalg.norm(right)
    matrix = np.eye(4)
    matrix[:3, :3] = np.stack([right, np.cross(back, right), back], axis=-1)
    matrix[:3, 3] = eye
    return SharedScene(KNOT, parts, light, Camera(matrix.tolist(), 0.45, 0.1, 50.0, *size))


def from_blender(name: str, file: Path, size: tuple[int, int]) -> SharedScene:
    """A .blend or mesh file as the bridge reads it, with the first of its lights that all renderers know.

    @raises ValueError if it has none, or something that only some renderers know
    """
    sys.path.insert(0, str(ROOT / "tests" / "blender"))
    import pytest
    from blender_kit import record
    from penumbra import scenes

    scenes.open_scene(file)
    with pytest.MonkeyPatch.context() as patch:
        sent = record(patch)
        core_scene = scenes.read(size=size).scene
    parts = []
    for i in sent.instances:
        if not (i.casts and i.receives and i.visible):
            raise ValueError(f"{name}: {i.name} does not cast, receive and show alike")
        triangles = np.asarray(i.mesh.triangles, np.uint32)
        if np.linalg.det(i.world_from_local[:3, :3]) < 0:  # mirrored: keep the outside out
            triangles = np.ascontiguousarray(triangles[:, ::-1])
        parts.append(Part(i.name, np.ascontiguousarray(i.world_positions(), np.float32), triangles))
    known = [light for light in core_scene.lights if light.kind in LIGHT_KINDS]
    if not known:
        raise ValueError(f"{name}: no light of a kind that all renderers know ({', '.join(LIGHT_KINDS)})")
    camera = core_scene.camera
    if camera.orthographic or tuple(camera.shift) != (0.0, 0.0) or camera.pixel_aspect != 1.0:
        raise ValueError(f"{name}: the camera is orthographic, shifted, or its pixels are not square")
    return SharedScene(
        name,
        parts,
        _light(known[0], np.concatenate([part.positions for part in parts]).mean(axis=0)),
        Camera(
            np.asarray(camera.world_from_camera).tolist(),
            camera.tan_half_width,
            camera.near_m,
            camera.far_m,
            camera.width_px,
            camera.height_px,
        ),
    )


def _light(light: Any, middle: Any) -> Light:
    """With a power that shows a white surface in the middle of the scene as about 1."""

    def triple(vector: Any) -> tuple[float, float, float]:
        return (float(vector[0]), float(vector[1]), float(vector[2]))

    distance = float(np.linalg.norm(np.asarray(light.position_ws) - middle))
    return Light(
        light.kind,
        triple(light.position_ws),
        triple(light.direction_ws),
        triple(light.half_u_ws),
        triple(light.half_v_ws),
        float(light.sun_angle_rad),
        math.pi if light.kind == "sun" else math.pi**2 * distance**2,
    )
